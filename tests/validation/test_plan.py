"""The models that the validation chose, where plans are made: batch, command line, generator, FMU."""

import json

import numpy as np
import pytest
from glenoid import _core
from glenoid.batch import run_batch
from glenoid.fmus import fmu_path
from glenoid.inputs import InputError, ReachInput
from glenoid.settings import make_generator
from glenoid.simulate import difference_from_core, simulate
from glenoid.validate import models
from glenoid.validate.coefficients import built_in
from glenoid.validate.movements import load_npz, subset_of
from made_movements import crowd

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


#: the flags with which a plan is the validated model: rhythm, prior and metric, and the limits of the measured persons
VALIDATED = HUMAN | {"axial_factor": models.HUMAN_AXIAL_FACTOR}
WIDE = {"elevation": [0, 160], "plane": [-145, 55], "axial_rotation": [-100, 90], "elbow_flexion": [0, 155]}


def task_of(movement):
    """What a batch is told of a measured movement: start, target, lengths and the shoulder's centre at the start."""
    return {
        "id": movement.name,
        "q0": movement.q_rad[0].tolist(),
        "target": movement.wrist_m[-1].tolist(),
        "subject": {
            "upper_arm_length_m": movement.upper_arm_length_m,
            "forearm_length_m": movement.forearm_length_m,
            "shoulder_distance_m": float(np.linalg.norm(movement.shoulder_m[0])),
            "shoulder_start_m": movement.shoulder_m[0].tolist(),
        },
    }


def compare_with_validation(movements):
    """Batch and validation plan the same path and pull by the same length. Gives the lengths, m."""
    answers = run_batch([task_of(m) for m in movements], ReachInput(**VALIDATED, subject={"limits_deg": WIDE}))
    predictor, pulled = models.Predictor(), []
    for movement, answer in zip(movements, answers, strict=True):
        assert answer["status"] == "ok", movement.name
        predicted = predictor.predict(models.MODELS["glenoid"], movement, built_in())
        course = predicted.course.at(np.linspace(0.0, 1.0, 101))
        assert answer["pulled_m"] == predicted.pulled_m
        for name, points in (("wrist", course.wrist_m), ("elbow", course.elbow_m), ("shoulder", course.shoulder_m)):
            assert np.allclose(answer[name], points, rtol=0.0, atol=1e-7), (movement.name, name)
        pulled.append(answer["pulled_m"])
    return np.array(pulled)


def test_batch_plans_made_reaches_as_the_validation_does():
    compare_with_validation(crowd(2, 4))


def test_batch_plans_measured_reaches_as_the_validation_does(reaches):
    movements = subset_of(load_npz(reaches), "clean-outward")
    far = sorted(movements, key=lambda m: -np.linalg.norm(m.wrist_m[-1] - m.shoulder_m[0]) / m.upper_arm_length_m)
    pulled = compare_with_validation([*far[:8], *movements[::40]])
    assert (pulled > 0.0).any(), "targets at the very edge are among them"
    assert (pulled == 0.0).any()


def test_only_measured_targets_are_pulled_and_only_a_little():
    reach = ReachInput(**VALIDATED)
    (plain,) = run_batch([TASK], reach)
    shoulder = np.array(plain["shoulder"][0])
    direction = np.array(TASK["target"]) - shoulder
    direction /= np.linalg.norm(direction)
    length = sum(
        np.linalg.norm(np.diff([plain[a][0], plain[b][0]], axis=0))
        for a, b in (("shoulder", "elbow"), ("elbow", "wrist"))
    )
    measured = {"subject": {"shoulder_start_m": shoulder.tolist()}}
    tasks = [TASK | more | {"target": (shoulder + (length + beyond) * direction).tolist()}
             for more in ({}, measured) for beyond in (0.03, 0.15)]  # fmt: skip
    free, free_far, near, far = run_batch(tasks, reach)
    assert [free["status"], free_far["status"], far["status"]] == ["TargetUnreachable"] * 3
    assert free["pulled_m"] is None
    assert near["status"] == "ok"
    assert 0.0 < near["pulled_m"] <= 0.05
    missed = np.linalg.norm(np.array(near["wrist"][-1]) - tasks[2]["target"])
    assert missed == pytest.approx(near["pulled_m"], abs=1e-7)
    assert plain["pulled_m"] == 0.0


@pytest.mark.parametrize("fmi", ["2", "3"])
@pytest.mark.parametrize("target", [(0.20, 0.42, 0.25), (0.05, 0.35, -0.05), (0.32, 0.22, 0.05)])
def test_fmu_takes_all_human_choices_together(fmi, target):
    try:
        fmu = fmu_path(fmi)
    except InputError as error:
        pytest.skip(str(error))
    reach = ReachInput(**VALIDATED, timing="MinimumJerkHoming", target_m=target, duration_s=1.6)
    done = simulate(reach, fmu, 0.02, 1.8)
    assert done.status == "Arrived"
    assert difference_from_core(reach, done) == 0.0
    plain = simulate(ReachInput(target_m=target, duration_s=1.6), fmu, 0.02, 1.8)
    assert np.abs(done.samples["q_rad"][-1] - plain.samples["q_rad"][-1]).max() > 1e-3, "another posture is chosen"
