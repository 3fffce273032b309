"""The part of with_vcan.py that runs where the interfaces are: in a network namespace, or as process 1 of a user-mode Linux.

    python vcan_inside.py DIRECTORY

DIRECTORY/job.json says what to do; DIRECTORY/ready appears when the command starts, DIRECTORY/result holds its status.
"""

from __future__ import annotations

import contextlib
import ctypes
import errno
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import termios
import time
import tty
from pathlib import Path

NO_WAY, TIMED_OUT, NOT_RUN, NOT_FOUND = 125, 124, 126, 127
KILL_S = 5.0
UML_MODULES = Path("/usr/lib/uml/modules")
# In the order in which they depend on each other; those that a kernel has built in or lacks are left out.
MODULES = ("can", "can_raw", "can_dev", "vcan", "sch_netem", "sch_tbf")
RECEIVE_BUFFER = 16 << 20
INIT_MODULE = 175  # system call number on x86-64
CLONE_NEWUSER, CLONE_NEWNET, POWER_OFF = 0x10000000, 0x40000000, 0x4321FEDC
TOOLS = "/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin"


class UnusableError(Exception):
    """The network could not be made; the text says why."""


LIBC = ctypes.CDLL(None, use_errno=True)


def require(result: int, what: str) -> None:
    """Raises UnusableError when a C call failed."""
    if result < 0:
        raise UnusableError(f"{what}: {os.strerror(ctypes.get_errno())}")


def ip(*lines: str) -> None:
    """Runs commands of iproute2."""
    try:
        done = subprocess.run(
            ["ip", "-batch", "-"],
            input="\n".join(lines) + "\n",
            capture_output=True,
            text=True,
            check=False,
            env={**os.environ, "PATH": TOOLS},
        )
    except FileNotFoundError as error:
        raise UnusableError("no command ip: apt-get install iproute2") from error
    if done.returncode != 0:
        raise UnusableError(f"ip: {(done.stdout + done.stderr).strip().splitlines()[0]}")


def set_up_network(interfaces: list[str]) -> None:
    """Lo with multicast, and the CAN interfaces."""
    links = [line for name in interfaces for line in (f"link add dev {name} type vcan", f"link set dev {name} up")]
    ip("link set dev lo up", "link set dev lo multicast on", *links, "route replace 224.0.0.0/4 dev lo")
    with socket.socket(socket.PF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as raw:
        raw.bind((interfaces[0],))


def enter_namespace() -> None:
    """A network namespace of its own; without root, inside a user namespace."""
    if LIBC.unshare(CLONE_NEWNET) == 0:
        return
    user, group = os.getuid(), os.getgid()
    require(LIBC.unshare(CLONE_NEWUSER | CLONE_NEWNET), "unshare")
    try:
        Path("/proc/self/setgroups").write_text("deny")
        Path("/proc/self/uid_map").write_text(f"0 {user} 1")
        Path("/proc/self/gid_map").write_text(f"0 {group} 1")
    except OSError as error:
        raise UnusableError(f"user namespace: {error}") from error


def load_modules(echo: bool) -> None:
    """Inserts the CAN modules of user-mode Linux with their dependencies."""
    base = UML_MODULES / os.uname().release
    needs = {}
    for line in (base / "modules.dep").read_text().splitlines():
        target, _, rest = line.partition(":")
        needs[Path(target).name.split(".ko")[0].replace("-", "_")] = [*reversed(rest.split()), target]
    for name in MODULES:
        for relative in needs.get(name, []):
            data = (base / relative).read_bytes()
            options = b"echo=1" if echo and Path(relative).name.startswith("vcan.ko") else b""
            if LIBC.syscall(INIT_MODULE, data, ctypes.c_ulong(len(data)), options) < 0:
                number = ctypes.get_errno()
                if number != errno.EEXIST:
                    raise UnusableError(f"module {name}: {os.strerror(number)}")


def mount(kind: str, target: str, options: str = "") -> None:
    """Mounts a file system of the kernel; one that is there already is left."""
    with contextlib.suppress(OSError):
        Path(target).mkdir(parents=True, exist_ok=True)
    LIBC.mount(kind.encode(), target.encode(), kind.encode(), 0, options.encode() or None)


def reap(status_of: int) -> int | None:
    """As process 1: buries orphans. The exit status of the process asked for once it has ended."""
    status = None
    with contextlib.suppress(ChildProcessError):
        while (ended := os.waitpid(-1, os.WNOHANG))[0] != 0:
            if ended[0] == status_of:
                status = os.waitstatus_to_exitcode(ended[1])
    return status


def run_command(job: dict, out: int | None = None, err: int | None = None) -> int:
    """Starts the command in its own session and waits for it; kills it when its time is over."""
    os.chdir(job["cwd"])
    os.environ["PATH"] = job["env"].get("PATH", os.defpath)
    try:
        process = subprocess.Popen(
            job["command"],
            env={**job["env"], "WITH_VCAN": job["backend"]},
            stdin=subprocess.DEVNULL,
            stdout=out,
            stderr=err,
            start_new_session=True,
        )
    except FileNotFoundError:
        return NOT_FOUND
    except OSError:
        return NOT_RUN
    deadline = time.monotonic() + job["timeout"]
    killed_at = None
    while True:
        status = reap(process.pid) if os.getpid() == 1 else process.poll()
        if status is not None:
            return TIMED_OUT if killed_at is not None else 128 - status if status < 0 else status
        now = time.monotonic()
        if killed_at is None and now > deadline:
            killed_at = now
            os.killpg(process.pid, signal.SIGTERM)
        elif killed_at is not None and now > killed_at + KILL_S:
            os.killpg(process.pid, signal.SIGKILL)
        time.sleep(0.01)


def inside_native(job: dict) -> int:
    """The command in a namespace of this kernel."""
    if os.geteuid() == 0 and shutil.which("modprobe", path=TOOLS):
        options = ["echo=1"] if job["echo"] else []
        for module in ("can-raw", "vcan"):
            subprocess.run(
                ["modprobe", "-q", module, *(options if module == "vcan" else [])],
                check=False,
                stderr=subprocess.DEVNULL,
                env={**os.environ, "PATH": TOOLS},
            )
    enter_namespace()
    set_up_network(job["interfaces"])
    Path(job["directory"], "ready").touch()
    return run_command(job)


def inside_uml(job: dict) -> int:
    """The command as a child of process 1 of a user-mode Linux."""
    for kind, target, options in (
        ("proc", "/proc", ""),
        ("sysfs", "/sys", ""),
        ("devtmpfs", "/dev", ""),
        ("devpts", "/dev/pts", ""),
        ("tmpfs", "/dev/shm", "mode=1777"),
    ):
        mount(kind, target, options)
    for name, target in (("fd", ""), ("stdin", "/0"), ("stdout", "/1"), ("stderr", "/2")):
        with contextlib.suppress(OSError):
            Path("/dev", name).symlink_to("/proc/self/fd" + target)
    for limit in ("rmem_max", "wmem_max"):
        Path("/proc/sys/net/core", limit).write_text(str(RECEIVE_BUFFER))
    load_modules(job["echo"])
    set_up_network(job["interfaces"])
    consoles = [os.open(f"/dev/tty{number}", os.O_WRONLY | os.O_NOCTTY) for number in (1, 2)]
    for console in consoles:
        tty.setraw(console)
    Path(job["directory"], "ready").touch()
    status = run_command(job, *consoles)
    for console in consoles:
        termios.tcdrain(console)
    return status


def inside(directory: str) -> int:
    """The part that runs where the interfaces are. Leaves [status, reason] in the file `result`."""
    job = json.loads(Path(directory, "job.json").read_text())
    status, reason = NO_WAY, None
    try:
        status = inside_native(job) if job["backend"] == "native" else inside_uml(job)
    except Exception as error:  # process 1 must not die: that would be a panic of its kernel
        reason = str(error) if isinstance(error, UnusableError) else f"{type(error).__name__}: {error}"
    draft = Path(directory, "result.draft")
    draft.write_text(json.dumps([status, reason]))
    draft.rename(Path(directory, "result"))
    if os.getpid() == 1:
        LIBC.kill(-1, signal.SIGKILL)
        LIBC.reboot(POWER_OFF)
        time.sleep(60)
    return 0


if __name__ == "__main__":
    sys.exit(inside(sys.argv[1]))
