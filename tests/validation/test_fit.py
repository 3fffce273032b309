"""The fits find what was put in, and no person's movements enter the coefficients that judge that person."""

import numpy as np
import pytest
import yaml
from glenoid import _core
from glenoid.inputs import InputError, build_reach
from glenoid.settings import core_motion
from glenoid.validate import coefficients as fits
from glenoid.validate.clock import CUT, cut_progress, homing, minimum_jerk, shown_part, shown_shares
from glenoid.validate.movements import load_npz
from made_movements import crowd, synthetic, write_npz

SLOPE = np.array([[0.0, 0.0, -0.02], [-0.04, 0.02, 0.0], [0.0, 0.0, 0.03]])  # the four slopes that are fitted


def test_rhythm_of_the_data_is_found(monkeypatch):
    monkeypatch.setattr(fits, "RHYTHM_RIDGE", 1e-9)
    assert np.allclose(fits.fit_rhythm(crowd(3, 8, slope_m=SLOPE)), SLOPE, atol=1e-5)  # tables linear between samples


def test_ridge_only_shrinks():
    found = fits.fit_rhythm(crowd(3, 8, slope_m=SLOPE))
    assert np.linalg.norm(found) < np.linalg.norm(SLOPE)


@pytest.mark.parametrize("tail", [0.0, 0.3, 0.7])
def test_tail_of_the_data_is_found(tail):
    movements = []
    q0, q1 = np.deg2rad([20, -40, 45, 75]), np.deg2rad([60, -20, 25, 50])
    for k, duration_s in enumerate(np.linspace(1.2, 2.5, 10)):
        m = synthetic(str(k), "P0", q0, q1, duration_s=duration_s)
        scaled = _core.scale_subject(_core.Subject())
        settings = _core.RhythmSettings()
        settings.model = _core.RhythmModel.Fixed
        rhythm = _core.Rhythm(settings, scaled.shoulder_distance_m)
        arm = _core.make_arm_model(scaled, rhythm, _core.JointLimits(), False)
        way = fits.arc_progress(arm, m.q_rad)
        wanted = cut_progress(duration_s, tail)
        rows = np.interp(wanted, way, np.arange(len(way)))
        q = np.column_stack([np.interp(rows, np.arange(len(way)), column) for column in m.q_rad.T])
        movements.append(type(m)(**(vars(m) | {"q_rad": q})))
    assert fits.fit_tail(movements) == pytest.approx(tail, abs=0.05 + 1e-9)


def test_slopes_that_are_not_fitted_stay_zero():
    full = SLOPE + np.array([[0.01, -0.02, 0.0], [0.0, 0.0, 0.005], [0.0, 0.01, 0.0]])
    found = fits.fit_rhythm(crowd(3, 8, slope_m=full))
    assert np.array_equal(found != 0.0, fits.RHYTHM_SLOPES)


@pytest.mark.parametrize("clock", [minimum_jerk, homing(0.7)], ids=["minimum jerk", "homing"])
@pytest.mark.parametrize("duration_s", [0.6, 1.7])
def test_shown_part_begins_and_ends_at_its_share_of_the_peak_speed(clock, duration_s):
    """By speeds of the cut movement itself, at its ends and everywhere between."""
    count = 2001
    shares = shown_shares(clock, lambda way: way, duration_s, count)
    speed = np.diff(shares)
    assert speed[0] == pytest.approx(CUT * speed.max(), rel=0.1)  # of the steps of 1/200 that the cut was found with
    assert speed[-1] == pytest.approx(CUT * speed.max(), rel=0.1)
    assert (speed >= 0.9 * CUT * speed.max()).all()
    assert (shares[0], shares[-1]) == (0.0, 1.0)


def test_shown_part_of_an_even_movement_is_all_of_it():
    begin, end = shown_part(np.linspace(0.0, 1.0, 201))
    assert begin == pytest.approx(0.0, abs=1 / 200)
    assert end == pytest.approx(1.0, abs=1 / 200)


def test_halves_judge_every_person_equally_often():
    chosen = fits.halves(crowd(4, 3))
    assert len(chosen) == len(set(chosen)) == 6
    assert all(sum(person in half for half in chosen) == 3 for person in ("P0", "P1", "P2", "P3"))
    assert len(fits.halves(crowd(10, 1))) == 70


def test_no_person_enters_the_fit_that_judges_them():
    movements = crowd(4, 6, slope_m=SLOPE)
    folds = fits.leave_one_out(movements)
    assert set(folds) == {"P0", "P1", "P2", "P3"}
    for person in folds:
        spoiled = [
            type(m)(
                **(
                    vars(m)
                    | {"shoulder_m": m.shoulder_m * 2.0, "q_rad": m.q_rad[::-1].copy(), "wrist_m": m.wrist_m[::-1]}
                )
            )
            if m.subject == person
            else m
            for m in movements
        ]
        again = fits.leave_one_out(spoiled)
        assert np.array_equal(again[person].slope_m, folds[person].slope_m)
        for name in ("height_rad", "lateral_rad", "regression", "common_rad", "tail"):
            assert getattr(again[person], name) == getattr(folds[person], name)
        others = [p for p in folds if p != person]
        assert any(not np.array_equal(again[p].slope_m, folds[p].slope_m) for p in others), "the others do see them"


def test_too_little_data_is_refused():
    with pytest.raises(InputError, match="at least 10"):
        fits.fit(crowd(1, 3))
    with pytest.raises(InputError, match="two persons"):
        fits.leave_one_out(crowd(1, 12))


def test_fitted_file_is_a_reach_that_the_core_takes(tmp_path):
    fitted = fits.fit(crowd(3, 8, slope_m=SLOPE))
    reach = build_reach(yaml.safe_load(fits.to_yaml(fitted)), "fit")
    settings = core_motion(reach)
    assert np.allclose(settings.rhythm.measured.slope_m, fitted.slope_m.ravel(), atol=1e-6)
    assert settings.posture_prior.height_rad == pytest.approx(fitted.height_rad, abs=1e-6)
    _core.MotionGenerator(settings, 0.0).command(0.0, np.array(reach.target_m))
    file = tmp_path / "fit.yaml"
    file.write_text(fits.to_yaml(fitted), encoding="utf-8")
    assert np.allclose(fits.from_yaml(file).slope_m, fitted.slope_m, atol=1e-6)


def test_archive_keeps_the_movements(tmp_path):
    movements = crowd(2, 3)
    write_npz(tmp_path / "reaches.npz", movements)
    again = load_npz(tmp_path / "reaches.npz")
    for one, two in zip(movements, again, strict=True):
        assert np.allclose(one.q_rad, two.q_rad, atol=1e-9)
        assert np.allclose(one.shoulder_m, two.shoulder_m, atol=1e-12)
        assert one.upper_arm_length_m == pytest.approx(two.upper_arm_length_m)
