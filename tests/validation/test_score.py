"""Laws of the scorer: a perfect prediction scores 1, and constructed errors score what they must."""

from dataclasses import replace

import numpy as np
import pytest
from glenoid import _core
from glenoid.validate.clock import shown_part
from glenoid.validate.coefficients import built_in
from glenoid.validate.evaluate import (
    GRID,
    about,
    bootstrap_interval,
    evaluate,
    measured_course,
    over_arc_length,
    summary,
)
from glenoid.validate.geometry import angles_of_points, elbow_on_circle, swivel_of_points, wrapped
from glenoid.validate.models import MODELS, Predictor
from glenoid.validate.score import Trajectory, course_scores, end_scores, squared_pearson, strict_r2
from made_movements import crowd, points_of, synthetic

Q0, Q1 = np.deg2rad([20, -40, 45, 75]), np.deg2rad([60, -20, 25, 50])


@pytest.fixture
def measured():
    return measured_course(synthetic("a", "P0", Q0, Q1))


def test_perfect_prediction_scores_one_and_no_error(measured):
    scores = course_scores(measured, measured) | end_scores(measured, measured)
    for key, value in scores.items():
        assert value == (
            1.0 if key.endswith(("_r2", "_pooled", "_plain")) else pytest.approx(1.0 if "pearson" in key else 0.0)
        )


def test_the_mean_scores_zero():
    rows = np.random.default_rng(1).normal(size=(50, 3))
    assert strict_r2(rows, np.broadcast_to(rows.mean(axis=0), rows.shape)) == pytest.approx(0.0, abs=1e-14)


def test_constant_offset_costs_its_square_over_the_variance(measured):
    offset = np.array([0.03, -0.02, 0.01])
    moved = replace(measured, elbow_m=measured.elbow_m + offset)
    spread = ((measured.elbow_m - measured.elbow_m.mean(axis=0)) ** 2).sum(axis=1).mean()
    scores = course_scores(measured, moved)
    assert scores["elbow_r2"] == pytest.approx(1.0 - offset @ offset / spread, rel=1e-12)
    assert scores["elbow_rms_cm"] == pytest.approx(100.0 * np.linalg.norm(offset), rel=1e-12)
    assert scores["wrist_r2"] == 1.0


def test_pooled_weighs_joints_by_their_variance_and_plain_does_not(measured):
    wrong = measured.q_rad.copy()
    wrong[:, 0] = measured.q_rad[:, 0].mean()
    variances = measured.q_rad.var(axis=0)
    scores = course_scores(measured, replace(measured, q_rad=wrong + 0.0))
    first = 1.0 - ((measured.q_rad[:, 0] - measured.q_rad[:, 0].mean()) ** 2).sum() / (variances[0] * len(wrong))
    assert scores["theta_r2"] == pytest.approx(first, abs=1e-12)
    assert scores["joint_pooled"] == pytest.approx(1.0 - variances[0] / variances.sum(), rel=1e-12)
    assert scores["joint_plain"] == pytest.approx(0.75, rel=1e-12)


def test_pearson_is_blind_where_the_strict_measure_is_not(measured):
    halved = measured.q_rad[0] + 0.5 * (measured.q_rad - measured.q_rad[0])
    scores = course_scores(measured, replace(measured, q_rad=halved))
    assert scores["joint_pearson"] == pytest.approx(1.0)
    assert scores["joint_pooled"] < 0.7
    assert squared_pearson(measured.q_rad[:, 0], np.ones(len(halved))) == 0.0


def test_whole_turns_of_the_angles_cost_nothing(measured):
    turned = measured.q_rad + 2.0 * np.pi * np.array([0.0, 1.0, -1.0, 0.0])
    assert course_scores(measured, replace(measured, q_rad=turned))["joint_pooled"] == pytest.approx(1.0, abs=1e-12)


def test_joint_that_rests_is_not_in_the_plain_mean():
    course = measured_course(synthetic("a", "P0", Q0, Q0 + np.array([0.5, 0.01, 0.5, 0.5])))
    scores = course_scores(course, replace(course, q_rad=course.q_rad + np.array([0.0, 0.3, 0.0, 0.0])))
    assert np.isnan(scores["eta_r2"])
    assert scores["joint_plain"] == 1.0
    assert scores["joint_pooled"] < 1.0


@pytest.mark.parametrize("degrees", [-170.0, -20.0, 7.0, 35.0, 175.0])
def test_swivel_error_is_the_angle_that_the_elbow_was_turned(measured, degrees):
    shoulder, wrist = measured.shoulder_m[-1], measured.wrist_m[-1]
    own = swivel_of_points(shoulder, measured.elbow_m[-1], wrist)
    elbow = elbow_on_circle(shoulder, wrist, 0.29, 0.25, own + np.deg2rad(degrees))
    turned = replace(measured, elbow_m=np.vstack([measured.elbow_m[:-1], elbow]))
    assert end_scores(measured, turned)["swivel_deg"] == pytest.approx(degrees, abs=1e-6)
    chord = 2.0 * np.sin(np.deg2rad(abs(degrees)) / 2.0)
    radius = np.linalg.norm(np.cross((wrist - shoulder) / np.linalg.norm(wrist - shoulder), elbow - shoulder))
    assert end_scores(measured, turned)["end_elbow_cm"] == pytest.approx(100.0 * radius * chord, abs=1e-3)


def test_angles_and_swivel_are_those_of_the_core(measured):
    q = angles_of_points(measured.shoulder_m, measured.elbow_m, measured.wrist_m)
    assert np.allclose(q, measured.q_rad, atol=1e-12)
    _, wrist = points_of(q, measured.shoulder_m)
    assert np.allclose(wrist, measured.wrist_m, atol=1e-3)  # lengths of the movement are its medians
    arm = Predictor().arm(MODELS["fixed-shoulder"], synthetic("a", "P0", Q0, Q1), built_in())
    points = _core.forward_kinematics(arm, _core.posture_from_angles(q[0]))
    expected = _core.swivel_angle(points)
    assert wrapped(swivel_of_points(points.shoulder_m, points.elbow_m, points.wrist_m) - expected) == pytest.approx(
        0.0, abs=1e-12
    )


def test_time_law_does_not_count_over_the_path():
    slow, fast = synthetic("a", "P0", Q0, Q1), synthetic("b", "P0", Q0, Q1)
    place = GRID**2 * (len(GRID) - 1.0)
    rows = np.arange(len(GRID))
    q = np.column_stack([np.interp(place, rows, column) for column in fast.q_rad.T])
    other = Trajectory(fast.shoulder_m, *points_of(q, fast.shoulder_m), q)
    arm = Predictor().arm(MODELS["fixed-shoulder"], slow, built_in())
    one, two = over_arc_length(arm, measured_course(slow)), over_arc_length(arm, other)
    assert course_scores(measured_course(slow), other)["joint_pooled"] < 0.95
    assert course_scores(one, two)["joint_pooled"] == pytest.approx(1.0, abs=1e-3)  # both are tables of 101 rows


def test_about_moves_all_points_alike(measured):
    moved = about(measured, measured.shoulder_m + np.array([0.1, 0.0, 0.0]))
    assert np.allclose(moved.wrist_m - measured.wrist_m, [0.1, 0.0, 0.0])
    assert moved.q_rad is measured.q_rad


def test_told_everything_a_joint_line_is_perfect():
    ends = np.deg2rad([20, -40, 45, 75]), np.deg2rad([60, -20, 25, 50])
    slope = {"slope_m": np.diag([0.02, 0.03, 0.04])}
    whole = synthetic("1", "P0", *ends, **slope, samples=2001)
    recorded = synthetic("1", "P0", *ends, **slope, samples=2001, part=shown_part(whole.wrist_m))
    rows = evaluate(["oracle-joint-line"], [recorded], {"P0": built_in()})["oracle-joint-line"]
    for row in rows:
        assert row.scores["joint_pooled"] == pytest.approx(1.0, abs=1e-5)  # speeds of tables of 100 and of 200 steps
        assert row.scores["gh_mm"] == 0.0
        assert row.scores["wrist_r2"] == pytest.approx(1.0, abs=1e-5)


def test_bootstrap_draws_persons_not_reaches():
    people = np.repeat(["a", "b"], 500)
    values = np.where(people == "a", 0.0, 1.0)
    low, high = bootstrap_interval(values, people)
    assert (low, high) == (0.0, 1.0), "two persons can both be the same one"
    assert bootstrap_interval(np.full(6, 0.3), np.repeat(["a", "b", "c"], 2)) == pytest.approx((0.3, 0.3))


def test_summary_counts_what_failed():
    movements = crowd(2, 2)
    rows = evaluate(["glenoid"], movements, dict.fromkeys(["P0", "P1"], built_in()))["glenoid"]
    out = summary([*rows, replace(rows[0], scores={}, failed="no posture")])
    assert (out["movements"], out["failed"]) == (5, 1)
    assert out["joint_pooled"]["mean"] == pytest.approx(np.mean([row.scores["joint_pooled"] for row in rows]))
