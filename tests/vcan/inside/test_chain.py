"""The whole chain: FMU -> LCM -> bridge -> vcan0 -> six drives."""

import json
import re
import subprocess
import sys
import time
from pathlib import Path

import pytest
from glenoid.inputs import InputError, load_reach

ROOT = Path(__file__).resolve().parents[3]
REACH = ROOT / "host/examples/reach_to_head.yaml"
DEVICE = "generic_75_75"
PERIOD_MS = 20  # as the bridge of these tests
PATIENCE_S = 60.0
DURATION_S = 5.0  # the device's first shoulder joint turns by 2.8 rad; the bridge refuses more than 2.5 rad/s


def test_a_reach_of_the_fmu_is_followed_by_six_drives(bridge, drives, patient):
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
    own = bridge()
    running = drives("--nodes", "1-6", "--profile", patient)
    source = [sys.executable, "-m", "glenoid", "source", str(REACH), "--exo", DEVICE]
    source += ["--duration-s", str(DURATION_S), "--rate-hz", str(1000 / PERIOD_MS), "--timeout-s", str(PATIENCE_S)]
    done = subprocess.run(source, capture_output=True, text=True, check=False, timeout=3 * PATIENCE_S)
    time.sleep(0.5)
    report = running.stop()
    said, log = own.stop()
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
