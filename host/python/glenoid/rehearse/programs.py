"""glenoid-bridge and glenoid-drives as child processes of a rehearsal in real time."""

from __future__ import annotations

import contextlib
import gc
import json
import os
import resource
import signal
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from glenoid.inputs import InputError, read_mapping
from glenoid.programs import program
from glenoid.rehearse.load import load_yaml
from glenoid.rehearse.motion import Motion
from glenoid.rehearse.scenario import RealTimeInput, Scenario
from glenoid.rehearse.virtual import profile_file

#: of the bridge as it is shipped; drives and source stay below it
BRIDGE_PRIORITY, SOURCE_PRIORITY = 80, 40
CAP_IPC_LOCK = 14  # linux/capability.h
STOP_WAIT_S, READY_WAIT_S = 6.0, 5.0


class Programs(NamedTuple):
    """What runs, and where it writes."""

    bridge: subprocess.Popen[str]
    drives: subprocess.Popen[str]
    frames: Path
    report: Path

    def counters(self) -> list[dict[str, Any]]:
        """Of the drives, after their end; empty where they left none."""
        try:
            drives: list[dict[str, Any]] = json.loads(self.report.read_text(encoding="utf-8"))["drives"]
        except (OSError, ValueError, KeyError):
            return []
        return drives


def may_be_realtime() -> bool:
    """Whether this process may have SCHED_FIFO and locked memory; root of a container often may not."""
    status = Path("/proc/self/status").read_text(encoding="ascii")
    rights = int(next(line for line in status.splitlines() if line.startswith("CapEff")).split()[1], 16)
    if not rights >> CAP_IPC_LOCK & 1 and resource.getrlimit(resource.RLIMIT_MEMLOCK)[0] != resource.RLIM_INFINITY:
        return False
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(BRIDGE_PRIORITY))
    except OSError:
        return False
    os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
    return True


@contextlib.contextmanager
def realtime_source(priority: int) -> Iterator[None]:
    """The source of setpoints under SCHED_FIFO, where wanted and permitted, and not held up by its own process.

    All threads of the process get the priority: one of them that holds the interpreter's lock and waits for a processor behind
    other programs would keep the source waiting, too. Nothing is collected meanwhile.
    """
    collecting = gc.isenabled()
    gc.disable()
    wanted = priority > 0 and may_be_realtime()
    try:
        if wanted:
            schedule_threads(os.SCHED_FIFO, SOURCE_PRIORITY)
        yield
    finally:
        if wanted:
            schedule_threads(os.SCHED_OTHER, 0)
        if collecting:
            gc.enable()


def schedule_threads(policy: int, priority: int) -> None:
    """Policy and priority of every thread of this process, as far as that is permitted."""
    for task in Path("/proc/self/task").iterdir():
        with contextlib.suppress(OSError):  # one that ended meanwhile, or a container that forbids it all the same
            os.sched_setscheduler(int(task.name), policy, os.sched_param(priority))


def bridge_configuration(scenario: Scenario, bus: str, folder: Path) -> Path:
    """The configuration with the bus of the rehearsal in place of its own; its hash is the same."""
    if len(scenario.config.buses) != 1:
        raise InputError(f"{scenario.bridge_file}: {len(scenario.config.buses)} buses: mode real_time takes one")
    data = yaml.safe_load(scenario.bridge_yaml)
    data["exoskeletons"][scenario.config.name]["buses"][0]["url"] = bus
    path = folder / "bridge.yaml"
    path.write_text(yaml.safe_dump(data, sort_keys=False), encoding="utf-8")
    return path


def drive_profile(scenario: Scenario, joint: dict[str, Any], folder: Path) -> Path:
    """The profile with the gear of the configuration, as in virtual time."""
    data = read_mapping(profile_file(scenario))
    mechanics = data.setdefault("mechanics", {})
    gear, counts = joint["gear_ratio"], joint["encoder_counts_per_turn"]
    if gear == int(gear) and counts == int(counts):
        mechanics |= {"gear_ratio": int(gear), "encoder_counts_per_motor_rev": int(counts)}
    if joint["rated_torque_Nm"] > 0.0:
        mechanics["rated_torque_Nm"] = joint["rated_torque_Nm"]
    path = folder / f"drive_{joint['node']}.yaml"
    path.write_text(yaml.safe_dump(data, sort_keys=False), encoding="utf-8")
    return path


def drives_command(scenario: Scenario, motion: Motion, places: RealTimeInput, folder: Path, report: Path) -> list[str]:
    """Command line of the drives, standing where the motion begins."""
    joints = scenario.config.joints
    start = motion.samples["exo_q_rad"][0]
    if len(start) != len(joints):
        raise InputError(f"{scenario.bridge_file}: {len(joints)} joints, the exoskeleton has {len(start)}")
    load, load_file = load_yaml(scenario, motion), folder / "load.yaml"
    if load is not None:
        load_file.write_text(load, encoding="utf-8")
    own = [joint["sign"] * (q - joint["offset_rad"]) for joint, q in zip(joints, start.tolist(), strict=True)]
    profiles = [f"--profile={joint['node']}={drive_profile(scenario, joint, folder)}" for joint in joints]
    return [
        str(program("glenoid-drives")),
        f"--bus={places.bus}",
        "--nodes=" + ",".join(str(joint["node"]) for joint in joints),
        "--start-rad=" + ",".join(repr(value) for value in own),
        f"--seed={scenario.data.drives.seed}",
        f"--report={report}",
        *profiles,
        *([f"--load={load_file}"] if load is not None else []),
        *(["--realtime"] if scenario.data.real_time.priority > 0 and may_be_realtime() else []),
    ]


def bridge_command(scenario: Scenario, places: RealTimeInput, folder: Path, frames: Path) -> list[str]:
    """Command line of the bridge."""
    return [
        str(program("glenoid-bridge")),
        str(bridge_configuration(scenario, places.bus, folder)),
        f"--exoskeleton={scenario.config.name}",
        f"--lcm-url={places.lcm_url}",
        f"--log={frames}",
        f"--priority={places.priority}",
        "--quiet",
    ]


def start(command: list[str], log: Path) -> subprocess.Popen[str]:
    """A child process whose words go to a file."""
    with log.open("w", encoding="utf-8") as words:
        return subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=words, stderr=words, text=True)


def stop(process: subprocess.Popen[str]) -> None:
    """Asks a program to end, and ends it where it does not."""
    if process.poll() is None:
        process.send_signal(signal.SIGTERM)
    try:
        process.wait(STOP_WAIT_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def require_running(process: subprocess.Popen[str], log: Path, name: str) -> None:
    """InputError with the program's last words where it ended by itself."""
    if process.poll() is not None:
        words = log.read_text(encoding="utf-8", errors="replace").strip().splitlines()
        raise InputError(f"{name} ended at once: {words[-1] if words else f'status {process.returncode}'}")


@contextlib.contextmanager
def programs(scenario: Scenario, motion: Motion, places: RealTimeInput, folder: Path) -> Iterator[Programs]:
    """Runs both programs; they have ended when this is left.

    Raises:
        InputError: a program is missing or ends at once; its words are in the text.

    """
    frames, report = folder / "candump.log", folder / "drives.json"
    drives_log, bridge_log = folder / "drives.txt", folder / "bridge.txt"
    drives = start(drives_command(scenario, motion, places, folder, report), drives_log)
    try:
        end = time.monotonic() + READY_WAIT_S
        while "ready" not in drives_log.read_text(encoding="utf-8") and time.monotonic() < end:
            require_running(drives, drives_log, "glenoid-drives")
            time.sleep(0.02)
        bridge = start(bridge_command(scenario, places, folder, frames), bridge_log)
        try:
            time.sleep(0.1)
            require_running(bridge, bridge_log, "glenoid-bridge")
            yield Programs(bridge, drives, frames, report)
        finally:
            stop(bridge)
    finally:
        stop(drives)
