"""The FMU as a source of setpoints: what it streams is what `glenoid simulate` computes."""

import sys
from pathlib import Path

import numpy as np
import pytest
from glenoid.cli import main
from glenoid.devices import load_device
from glenoid.inputs import ReachInput
from glenoid.simulate import simulate
from glenoid.source import FmuMotion

sys.path.insert(0, str(Path(__file__).parent))
from wires_bridge import Bridge

STEP_S = 0.01
DEVICE = "generic_60_60"
REACH = {"start_q_deg": (15, -30, 30, 60), "target_m": (0.20, 0.42, 0.25), "duration_s": 1.0}


def test_the_streamed_motion_is_the_simulated_one(fmu):
    reach, device = ReachInput(**REACH), load_device(DEVICE)
    simulated = simulate(reach, fmu, STEP_S, reach.duration_s, device)
    motion = FmuMotion(reach, device, fmu, STEP_S)
    # FMPy sums its steps up and we multiply: the instants differ by rounding, the values by that times their slopes.
    rounding_s = len(simulated.time_s) * np.finfo(float).eps * reach.duration_s
    fastest = np.abs(simulated.samples["exo_dq_rad_per_s"]).max()
    steepest = np.abs(np.diff(simulated.samples["exo_dq_rad_per_s"], axis=0)).max() / STEP_S
    try:
        for time_s, q, dq in zip(
            simulated.time_s, simulated.samples["exo_q_rad"], simulated.samples["exo_dq_rad_per_s"], strict=True
        ):
            position, velocity = motion.at(time_s)
            np.testing.assert_allclose(position, q, rtol=0, atol=rounding_s * fastest + 1e-15)
            np.testing.assert_allclose(velocity, dq, rtol=0, atol=rounding_s * steepest + 1e-15)
    finally:
        motion.close()


def test_instants_that_were_left_out_do_not_change_the_rest(fmu):
    reach, device = ReachInput(**REACH), load_device(DEVICE)
    every, some = (FmuMotion(reach, device, fmu, STEP_S) for _ in range(2))
    try:
        all_of_them = [every.at(k * STEP_S)[0] for k in range(60)]
        for k in (0, 3, 4, 20, 59):
            np.testing.assert_array_equal(some.at(k * STEP_S)[0], all_of_them[k])
    finally:
        every.close()
        some.close()


def test_source_streams_the_reach_to_a_bridge(fmu, url, monkeypatch, capsys):
    options = ["--start-q-deg", "15,-30,30,60", "--target-m", "0.20,0.42,0.25", "--duration-s", "1.0", "--exo", DEVICE]
    arguments = ["glenoid", "source", *options, "--lcm-url", url, "--rate-hz", "100"]
    monkeypatch.setattr(sys, "argv", arguments)
    motion = FmuMotion(ReachInput(**REACH), load_device(DEVICE), fmu, STEP_S)
    first, _ = motion.at(0.0)
    last, _ = motion.at(1.2)
    motion.close()
    with Bridge(url, first) as bridge, pytest.raises(SystemExit) as end:
        sys.exit(main())
    assert not end.value.code, capsys.readouterr()
    np.testing.assert_allclose(bridge.setpoints[0].position_rad[:6], first)
    np.testing.assert_allclose(bridge.setpoints[-1].position_rad[:6], last)
