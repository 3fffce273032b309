"""`glenoid replay` and `glenoid source` move real simulated drives through a real bridge, over UDP."""

import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import yaml
from glenoid.device_link import fingerprint
from glenoid.devices import load_device
from glenoid.inputs import load_reach
from glenoid.programs import program
from glenoid.source import FmuMotion
from glenoid.streaming import Blend

ROOT = Path(__file__).resolve().parents[2]
REACH, DEVICE, REACH_S = ROOT / "host/examples/reach_to_head.yaml", "generic_75_75", 5.0
PERIOD_MS = 10
RUN_S = 1.0  # from the first setpoint to the motion's begin: the bridge arms, the drives close the first distance
JOINTS, COUNTS_PER_RAD = 6, 100 * 16384 / (2 * np.pi)


@pytest.fixture
def bridge(tmp_path, bus_address, drives):
    """A bridge with its drives; ends with both. Periods for a busy machine."""
    group, port = bus_address
    config = yaml.safe_load((ROOT / "host/bridge/examples/six_drives_udp.yaml").read_text(encoding="utf-8"))
    arm = config["exoskeletons"]["six_drives_udp"]
    arm["sync"]["period_ms"] = PERIOD_MS
    arm["setpoints"] = {"period_ms": PERIOD_MS, "delay_ms": 60, "hold_after_ms": 500}
    arm["setpoints"] |= {"quick_stop_after_ms": 2000, "disarm_after_ms": 4000}
    arm["heartbeat"] |= {"drive_waits_ms": 2000, "drive_timeout_ms": 5000}
    arm["supervision"] = {"feedback_misses": 500, "transmit_skips": 100, "sdo_timeout_ms": 1000}
    arm["joint_defaults"]["limits"]["step_rad"] = 1.0
    arm["device"] = {"name": DEVICE, "sha256": fingerprint(load_device(DEVICE))}
    for joint in arm["joints"][2:5]:
        joint["limits"] = {"lower_rad": -2.8, "upper_rad": 2.8}
    arm["buses"][0]["url"] = f"udp:{group}:{port}"
    file, log = tmp_path / "six.yaml", tmp_path / "frames.log"
    file.write_text(yaml.safe_dump(config), encoding="utf-8")
    url = f"udpm://239.255.76.67:{port + 6000}?ttl=0"
    running = drives("--nodes", "1-6", "--profile", "patient")
    output = (tmp_path / "bridge.txt").open("w+")
    words = [program("glenoid-bridge"), file, "--log", log, "--lcm-url", url]
    process = subprocess.Popen(words, stdout=output, stderr=subprocess.STDOUT)

    def run(*arguments, asleep_s=None):
        """Runs a command of glenoid that moves the arm, then ends all: drives' reports, log lines, what was said.

        `asleep_s`: from when to when the command gets no processor, counted from the motion's begin.
        """
        command = [sys.executable, "-m", "glenoid", *map(str, arguments), "--lcm-url", url]
        command += ["--rate-hz", str(1000 / PERIOD_MS), "--timeout-s", "60"]
        source = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        told = ""
        if asleep_s:
            while "blend:" not in told and (line := source.stdout.readline()):
                told += line
            time.sleep(RUN_S + asleep_s[0])
            source.send_signal(signal.SIGSTOP)
            time.sleep(asleep_s[1] - asleep_s[0])
            source.send_signal(signal.SIGCONT)
        told += source.communicate(timeout=120)[0]
        time.sleep(0.3)
        process.terminate()
        process.wait(20)
        output.seek(0)
        said = output.read()
        assert source.returncode == 0, told + said
        return running.stop()["drives"], log.read_text().splitlines(), said

    yield run
    process.kill()
    process.wait()
    output.close()


def check(drives, log, said, goal):
    """All drives are where they should be, came there in steps their limits allow, and one session did it."""
    for drive, angle in zip(drives, goal, strict=True):
        assert abs(drive["position_rad"] - angle) < 5e-3, (drive, said)
    assert "READY -> RUN" in said
    assert said.count("armed: all drives follow") == 1
    assert "STOP" not in said
    assert "FAULT" not in said
    targets = {}
    for line in log:
        identifier, _, data = line.split()[2].partition("#")
        if 0x200 < int(identifier, 16) < 0x280 and data.startswith("0F00"):
            target = int.from_bytes(bytes.fromhex(data[4:12]), "little", signed=True)
            # bumpless: from the place where the drive stands, never faster than the limit
            step = abs(target - targets.get(identifier, 0))
            assert step <= 2.5e-3 * PERIOD_MS * COUNTS_PER_RAD + 1
            targets[identifier] = target
    assert len(targets) == JOINTS


@pytest.fixture
def recording(tmp_path):
    """File of a motion of 1.5 s, and where it ends, rad."""
    begin, goal = np.linspace(0.05, 0.3, JOINTS), np.linspace(0.4, 0.65, JOINTS)
    time_s = np.linspace(0.0, 1.5, 151)
    blend = Blend(begin, goal, 1.5)
    rows = np.array([np.concatenate(blend.at(t)) for t in time_s])
    names = ["time_s", *[f"q{k}_rad" for k in range(1, 7)], *[f"dq{k}_rad_per_s" for k in range(1, 7)]]
    path = tmp_path / "recorded.csv"
    np.savetxt(path, np.column_stack([time_s, rows]), delimiter=",", header=",".join(names), comments="")
    return path, goal


def test_a_recorded_motion_is_replayed_into_drives_that_stand_elsewhere(bridge, recording):
    path, goal = recording
    check(*bridge("replay", path), goal)


def test_a_source_that_slept_to_its_end_brings_the_drives_there_all_the_same(bridge, recording):
    path, goal = recording
    drives, log, said = bridge("replay", path, asleep_s=(0.9, 2.2))
    assert "RUN -> HOLD" in said
    check(drives, log, said, goal)


def test_the_fmu_moves_the_drives(bridge, fmu):
    reach = load_reach(REACH).model_copy(update={"duration_s": REACH_S})
    motion = FmuMotion(reach, load_device(DEVICE), fmu, PERIOD_MS / 1000)
    goal, _ = motion.at(motion.duration_s)
    motion.close()
    drives, log, said = bridge("source", REACH, "--exo", DEVICE, "--duration-s", REACH_S)
    check(drives, log, said, goal)
