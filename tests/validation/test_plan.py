"""The models that the validation chose, where plans are made: batch, command line, generator."""

import json

import numpy as np
import pytest
from glenoid import _core
from glenoid.batch import run_batch
from glenoid.inputs import ReachInput
from glenoid.settings import make_generator

TASK = {"id": 1, "q0": [0.26, -0.52, 0.52, 1.05], "target": [0.20, 0.36, 0.15]}
HUMAN = {"rhythm": {"model": "Measured"}, "swivel": {"mode": "HumanPrior"}}


def test_batch_takes_the_prior(run, tmp_path):
    (tmp_path / "tasks.json").write_text(json.dumps([TASK, TASK | {"id": 2, "target": [2, 2, 2]}]))
    done = run("plan", "--batch", tmp_path / "tasks.json", "--json", "--swivel", "HumanPrior", "--rhythm", "Measured")
    first, second = done.json
    assert (first["status"], second["status"]) == ("ok", "TargetUnreachable")
    assert np.allclose(first["wrist"][-1], TASK["target"], atol=1e-8)


def test_batch_and_generator_choose_the_same_posture():
    (answer,) = run_batch([TASK], ReachInput(**HUMAN, axial_factor=3.0))
    reach = ReachInput(**HUMAN, axial_factor=3.0, start_q_rad=TASK["q0"], target_m=TASK["target"])
    generator = make_generator(reach)
    generator.command(0.0, np.array(reach.target_m))
    assert np.allclose(generator.sample(np.array([9.0]))["q_rad"][0], answer["q"][-1], atol=1e-6)
    assert generator.path.energy_kg_m2 == pytest.approx(answer["energy"], rel=1e-9)


def test_left_arm_is_the_mirror_image():
    (right,) = run_batch([TASK], ReachInput(**HUMAN))
    mirrored = TASK | {"target": [-0.20, 0.36, 0.15]}
    (left,) = run_batch([mirrored], ReachInput(**HUMAN, subject={"arm": "left"}))
    assert np.allclose(right["q"], left["q"], atol=1e-12)
    assert np.allclose(np.array(right["elbow"]) * [-1, 1, 1], left["elbow"], atol=1e-12)


def test_own_coefficients_are_used():
    prior = {"height_rad": 0.0, "lateral_rad": 0.0, "regression": 1.0, "common_rad": 1.2, "effort": 0.0}
    (plain,) = run_batch([TASK], ReachInput(**HUMAN))
    (other,) = run_batch([TASK], ReachInput(rhythm=HUMAN["rhythm"], swivel={"mode": "HumanPrior", "prior": prior}))
    assert other["swivel"] > plain["swivel"] + 0.3
    slope = {"slope_m": [0.0] * 9, "shoulder_distance_m": 0.16}
    still = {"model": "Measured", "measured": slope}
    (fixed,) = run_batch([TASK], ReachInput(rhythm=still, swivel=HUMAN["swivel"]))
    assert np.ptp(fixed["shoulder"], axis=0).max() == 0.0


def test_homing_arrives_with_the_others_but_leads_in_the_middle():
    samples = []
    for timing in ("MinimumJerkRiemannian", "MinimumJerkHoming"):
        reach = ReachInput(**HUMAN, timing=timing, duration_s=2.0)
        generator = make_generator(reach)
        generator.command(0.0, np.array(reach.target_m))
        samples.append(generator.sample(np.array([0.0, 1.0, 2.0])))
    assert samples[0]["progress"][1] == pytest.approx(0.5)
    assert samples[1]["progress"][1] == pytest.approx(_core.homing_progress(np.array([1.0]), 2.0)[0])
    assert samples[1]["progress"][1] > 0.6
    for sample in samples:
        assert sample["progress"][2] == 1.0
        assert np.abs(sample["dq_rad_per_s"][[0, 2]]).max() < 1e-9
