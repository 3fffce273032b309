"""Runs a command where a real Linux SocketCAN interface exists.

    python with_vcan.py [--interface vcan0] [--timeout SECONDS] [--echo] [--backend native|uml] [--] COMMAND [ARGUMENT...]
    python with_vcan.py --check

Two ways, tried in this order:

native  a network namespace of its own with `ip link add type vcan`, on kernels that have vcan
uml     Debian's user-mode-linux: a kernel that runs as a process on this machine's own files, without root and without
        virtualisation

In both the command sees the same paths, working directory and environment, has its own network with lo (multicast routed
over it, as LCM needs) and the CAN interfaces, and the variable WITH_VCAN says which way it is. Its output and exit status
are passed through; 124 timed out, 125 no way works here (the reasons are printed), 126 or 127 not started.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

TIMED_OUT, NO_WAY = 124, 125
BOOT_S, KILL_S = 60.0, 5.0
MEMORY_MIB = 1024
UML_MODULES = Path("/usr/lib/uml/modules")
TOOLS = "/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin"
INSIDE = Path(__file__).resolve().with_name("vcan_inside.py")


class UnusableError(Exception):
    """A way that does not work here; the text says why and what to install."""


def idle_cpu() -> int:
    """The processor that idled most just now: the processes of a user-mode Linux must not be spread over several."""

    def idle() -> dict[int, int]:
        rows = [line.split() for line in Path("/proc/stat").read_text().splitlines()]
        return {int(row[0][3:]): int(row[4]) for row in rows if row[0].startswith("cpu") and row[0] != "cpu"}

    before = idle()
    time.sleep(0.05)
    after = idle()
    return max(os.sched_getaffinity(0), key=lambda cpu: after[cpu] - before[cpu])


def memory_directory() -> str:
    """Where the memory file of a user-mode Linux can be: room for it, and not noexec."""
    for place in ("/dev/shm", tempfile.gettempdir(), "/var/tmp"):
        with contextlib.suppress(OSError):
            facts = os.statvfs(place)
            if facts.f_bavail * facts.f_frsize >> 20 >= MEMORY_MIB and not facts.f_flag & os.ST_NOEXEC:
                return place
    raise UnusableError(f"no directory with {MEMORY_MIB} MiB free that is not noexec")


def copy(source: int, target: int | None, keep: bytearray) -> None:
    """A thread's body: a pipe to a file descriptor, the last of it kept."""
    while data := os.read(source, 65536):
        keep.extend(data)
        del keep[:-8192]
        while target is not None and data:
            try:
                data = data[os.write(target, data) :]
            except OSError:
                target = None
    os.close(source)


def start_native(directory: str) -> tuple[subprocess.Popen, list[threading.Thread], bytearray]:
    """A child in its own namespace, with our output."""
    command = [sys.executable, "-I", "-S", str(INSIDE), directory]
    return subprocess.Popen(command, start_new_session=True), [], bytearray()


def start_uml(directory: str) -> tuple[subprocess.Popen, list[threading.Thread], bytearray]:
    """A user-mode Linux whose process 1 is this file."""
    kernel = shutil.which("linux.uml") or shutil.which("linux.uml", path=TOOLS)
    if os.uname().machine != "x86_64" or kernel is None or not UML_MODULES.is_dir():
        raise UnusableError("not there: apt-get install user-mode-linux (x86-64)")
    python = [os.path.realpath(sys.executable), "-I", "-S", str(INSIDE), directory]
    init = Path(directory, "init")
    init.write_text(f"#!/bin/sh\nexec {shlex.join(python)}\n")
    init.chmod(0o700)
    log, threads, ends = bytearray(), [], []
    for target, keep in ((None, log), (1, bytearray()), (2, bytearray())):
        reader, writer = os.pipe()
        thread = threading.Thread(target=copy, args=(reader, target, keep), daemon=True)
        thread.start()
        threads.append(thread)
        ends.append(writer)
    cpu = idle_cpu()
    process = subprocess.Popen(
        [
            kernel,
            f"mem={MEMORY_MIB}M",
            "root=/dev/root",
            "rootfstype=hostfs",
            "rootflags=/",
            "rw",
            f"init={init}",
            f"uml_dir={directory}/",
            "umid=uml",
            "con=null",
            "ssl=null",
            f"con0=null,fd:{ends[0]}",
            f"con1=null,fd:{ends[1]}",
            f"con2=null,fd:{ends[2]}",
            "console=tty0",
            "panic=1",
            "quiet",
            # two benchmarks at boot that take longer than the rest of it
            "initcall_blacklist=raid6_select_algo,calibrate_xor_blocks",
        ],
        stdin=subprocess.DEVNULL,
        stdout=ends[0],
        stderr=ends[0],
        pass_fds=ends,
        start_new_session=True,
        preexec_fn=lambda: os.sched_setaffinity(0, {cpu}),
        env={**os.environ, "TMPDIR": memory_directory()},
    )
    for end in ends:
        os.close(end)
    return process, threads, log


def attempt(backend: str, options: argparse.Namespace) -> int:
    """Runs the command one way. Raises UnusableError if it was never started."""
    # Not under /dev, which a user-mode Linux mounts anew before it starts anything.
    place = "/var/tmp" if tempfile.gettempdir().startswith("/dev/") else None
    with tempfile.TemporaryDirectory(prefix="with_vcan.", dir=place) as directory:
        job = {
            "command": options.command,
            "cwd": str(Path.cwd()),
            "env": dict(os.environ),
            "timeout": options.timeout,
            "interfaces": options.interface or ["vcan0"],
            "echo": options.echo,
            "backend": backend,
            "directory": directory,
        }
        Path(directory, "job.json").write_text(json.dumps(job))
        process, threads, log = {"native": start_native, "uml": start_uml}[backend](directory)
        ready, result = Path(directory, "ready"), Path(directory, "result")
        begin = time.monotonic()
        try:
            while process.poll() is None and not result.exists():
                passed = time.monotonic() - begin
                if passed > BOOT_S and not ready.exists():
                    raise UnusableError(f"did not start within {BOOT_S:.0f} s")
                if passed > BOOT_S + options.timeout + 2 * KILL_S:
                    return TIMED_OUT
                time.sleep(0.02)
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(10)
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
            for thread in threads:
                thread.join(5)
        if not result.exists():
            raise UnusableError("ended without a result: " + log.decode("utf-8", "replace").strip()[-400:])
        status, reason = json.loads(result.read_text())
        if reason is not None:
            raise UnusableError(reason)
        return int(status)


def parse(arguments: list[str]) -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--interface", action="append", help="CAN interface to make, repeatable (vcan0)")
    parser.add_argument("--timeout", type=float, default=600.0, help="end the command after this many seconds (600)")
    parser.add_argument(
        "--echo", action="store_true", help="frames pass the queueing discipline, so that tc acts on them"
    )
    parser.add_argument("--backend", choices=("native", "uml"), help="only this way")
    parser.add_argument("--check", action="store_true", help="say which ways work here")
    parser.add_argument("command", nargs=argparse.REMAINDER)
    options = parser.parse_args(arguments)
    if options.command[:1] == ["--"]:
        del options.command[0]
    if options.check:
        options.command = ["true"]
    if not options.command:
        parser.error("no command given")
    return options


def main(arguments: list[str]) -> int:
    """Exit status of the command, or one of the module's own."""
    options = parse(arguments)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(128 + signal.SIGTERM))
    reasons = []
    for backend in (options.backend,) if options.backend else ("native", "uml"):
        try:
            status = attempt(backend, options)
        except UnusableError as error:
            reasons.append(f"  {backend}: {error}")
            continue
        if options.check:
            print(f"{backend}: works")
        return status
    print("with_vcan: no way to a CAN interface here:\n" + "\n".join(reasons), file=sys.stderr)
    return NO_WAY


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
