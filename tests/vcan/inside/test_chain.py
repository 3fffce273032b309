"""The whole chain: FMU -> LCM -> bridge -> vcan0 -> six drives."""

import json
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import yaml
from glenoid.inputs import InputError, load_reach
from glenoid.programs import program

ROOT = Path(__file__).resolve().parents[3]
REACH = ROOT / "host/examples/reach_to_head.yaml"
DEVICE = "generic_75_75"
PERIOD_MS = 20
PATIENCE_S = 60.0
DURATION_S = 5.0  # the device's first shoulder joint turns by 2.8 rad; the bridge refuses more than 2.5 rad/s
# Periods of a machine with one slow processor; the tests of the bridge state its own in virtual time.
TIMES = {
    "sync": {"period_ms": PERIOD_MS, "rpdo_phase": 0.5},
    "setpoints": {
        "period_ms": PERIOD_MS,
        "delay_ms": 100,
        "hold_after_ms": 500,
        "quick_stop_after_ms": 2000,
        "disarm_after_ms": 4000,
    },
    "heartbeat": {
        "master_id": 127,
        "master_period_ms": 50,
        "drive_waits_ms": 2000,
        "drive_period_ms": 100,
        "drive_timeout_ms": 5000,
    },
}


@pytest.fixture
def bridge(link, tmp_path):
    """Starts glenoid-bridge on the interface; ends it with the test."""
    try:
        path = program("glenoid-bridge")
    except InputError as error:
        pytest.skip(str(error))
    config = yaml.safe_load((ROOT / "host/bridge/examples/six_drives.yaml").read_text(encoding="utf-8"))
    arm = config["exoskeletons"]["six_drives"]
    arm.update(TIMES)
    arm["joint_defaults"]["limits"]["step_rad"] = 1.0  # setpoints are 0.1 s ahead of the commands, or more
    for joint in arm["joints"][2:5]:
        joint["limits"] = {"lower_rad": -2.8, "upper_rad": 2.8}
    arm["buses"][0]["url"] = f"socketcan:{link.name}"
    file = tmp_path / "chain.yaml"
    file.write_text(yaml.safe_dump(config), encoding="utf-8")
    log, stats = tmp_path / "frames.log", tmp_path / "stats.json"
    output = (tmp_path / "bridge.txt").open("w+")
    words = [path, file, "--priority", "0", "--log", log, "--stats", stats]
    process = subprocess.Popen(words, stdout=output, stderr=subprocess.STDOUT)

    def stop():
        process.send_signal(signal.SIGTERM)
        process.wait(PATIENCE_S)
        output.seek(0)
        return output.read(), log

    yield stop
    process.kill()
    process.wait()


def test_a_reach_of_the_fmu_is_followed_by_six_drives(bridge, drives, tmp_path):
    from glenoid.devices import load_device
    from glenoid.fmus import fmu_path
    from glenoid.source import FmuMotion

    try:
        fmu = fmu_path("3")
    except InputError as error:
        pytest.skip(str(error))
    reach = load_reach(REACH).model_copy(update={"duration_s": DURATION_S})
    motion = FmuMotion(reach, load_device(DEVICE), fmu, PERIOD_MS / 1000)
    steps = round(motion.duration_s * 1000 / PERIOD_MS)
    reached = [motion.at(k * PERIOD_MS / 1000)[0] for k in range(steps + 1)][-1]
    motion.close()
    patient = tmp_path / "patient.yaml"
    patient.write_text('name: patient\nobjects: {"2F10h:02": 2000000}\n')  # SYNC may come 2 s late
    running = drives("--nodes", "1-6", "--profile", patient)
    source = [sys.executable, "-m", "glenoid", "source", str(REACH), "--exo", DEVICE]
    source += ["--duration-s", str(DURATION_S), "--rate-hz", str(1000 / PERIOD_MS), "--timeout-s", str(PATIENCE_S)]
    done = subprocess.run(source, capture_output=True, text=True, check=False, timeout=3 * PATIENCE_S)
    time.sleep(0.5)
    report = running.stop()
    said, log = bridge()
    assert done.returncode == 0, done.stdout + done.stderr + said
    assert re.search(r"\b0 rejected", said), said
    assert [one["emergencies"] for one in report["drives"]] == [0] * 6, json.dumps(report, indent=1) + said
    for one, goal in zip(report["drives"], reached, strict=True):
        # The controller's integral has 50 ms to remove friction over stiffness; the last position is held much longer.
        assert abs(one["position_rad"] - goal) < 2e-3, (one["node"], one["position_rad"], goal)
        assert one["worst_following_error_rad"] < 0.1
        assert one["setpoints"] > 0.9 * steps
    assert max(abs(one["position_rad"]) for one in report["drives"]) > 0.3  # it moved
    frames = [line.split()[2] for line in log.read_text().splitlines()]
    assert sum(frame.startswith("080#") for frame in frames) > 0.9 * steps
