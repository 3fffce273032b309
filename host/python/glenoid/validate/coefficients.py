"""The fitted numbers of the measured models: rhythm (4), posture prior (4), homing tail (1); how they are fitted and folded.

The core's own coefficients come from `fit` over the clean outward reaches of FITTED_SUBJECTS, see docs/human-likeness.md.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import yaml

from glenoid import _core
from glenoid.inputs import InputError, build_reach, read_mapping
from glenoid.reach import Array
from glenoid.validate.clock import cut_progress
from glenoid.validate.geometry import swivel_of_points
from glenoid.validate.movements import Movement

#: persons whose reaches the core's coefficients were fitted to: they are judged by cross-validation only
FITTED_SUBJECTS = ("S01", "S03", "S05", "S07", "S09", "S11", "S13", "S15")
#: ridge on the rhythm's standardised slopes: a little keeps the correlated directions of everyday reaching apart
RHYTHM_RIDGE = 0.03
#: slopes (row: displacement, column: direction, x y z) that are fitted: forward and sideways of the arm move the shoulder forward and
#: back, lifting it moves the shoulder inwards and up; the other five are 0, since they carry over to other persons as noise
RHYTHM_SLOPES = np.array([[0, 0, 1], [1, 1, 0], [0, 0, 1]], dtype=bool)
PRIOR_RIDGE = 0.03
#: the length that displacements of the wrist are counted in, m, and how many of them make half of the regression; as in the core
SPAN_M, FAR = 0.54, 0.2
EVERY = 5
PRIOR_NAMES = ("height_rad", "lateral_rad", "regression", "common_rad", "effort", "lift_per_m")


@dataclass(frozen=True)
class Coefficients:
    """Slope of the rhythm, m (3, 3); the persons' shoulder distance, m; the prior's four numbers; the homing tail.

    The last two, effort and lift, are chosen, not fitted.
    """

    slope_m: Array
    shoulder_distance_m: float
    height_rad: float
    lateral_rad: float
    regression: float
    common_rad: float
    tail: float
    effort: float = 0.02
    lift_per_m: float = 2.0

    @property
    def count(self) -> int:
        """How many numbers were fitted: the persons' distance is measured, not fitted."""
        return int(RHYTHM_SLOPES.sum()) + 5

    def measured(self) -> _core.MeasuredRhythm:
        """The rhythm as the core takes it."""
        out = _core.MeasuredRhythm()
        out.slope_m = self.slope_m.ravel().tolist()
        out.shoulder_distance_m = self.shoulder_distance_m
        return out

    def prior(self, lift: bool = True) -> _core.PosturePriorCoefficients:
        """The posture prior as the core takes it, with or without its lift."""
        out = _core.PosturePriorCoefficients()
        for name in PRIOR_NAMES:
            setattr(out, name, getattr(self, name))
        if not lift:
            out.lift_per_m = 0.0
        return out


def built_in() -> Coefficients:
    """The core's own."""
    rhythm, prior = _core.MeasuredRhythm(), _core.PosturePriorCoefficients()
    return Coefficients(
        slope_m=np.array(rhythm.slope_m).reshape(3, 3),
        shoulder_distance_m=rhythm.shoulder_distance_m,
        height_rad=prior.height_rad,
        lateral_rad=prior.lateral_rad,
        regression=prior.regression,
        common_rad=prior.common_rad,
        tail=_core.HOMING_TAIL,
        effort=prior.effort,
        lift_per_m=prior.lift_per_m,
    )


def ridge(features: Array, values: Array, strength: float) -> Array:
    """Least squares without intercept, the columns scaled to unit root mean square and then shrunk."""
    scale = np.sqrt((features**2).mean(axis=0)) + 1e-12
    x = features / scale
    left = x.T @ x + strength * len(x) * np.eye(x.shape[1])
    solved = np.linalg.solve(left, x.T @ values) / (scale[:, None] if values.ndim == 2 else scale)
    return np.asarray(solved, dtype=float)


def upper_arm_direction(movement: Movement) -> Array:
    """Direction u = -z_TU along the movement, (n, 3)."""
    r = movement.elbow_m - movement.shoulder_m
    return np.asarray(r / np.linalg.norm(r, axis=1, keepdims=True), dtype=float)


def fit_rhythm(movements: Sequence[Movement]) -> Array:
    """Slope (3, 3), m: displacement of the shoulder from the start against that of the upper arm's direction."""
    features, values = [], []
    for m in movements:
        u = upper_arm_direction(m)
        features.append((u - u[0])[::EVERY])
        values.append((m.shoulder_m - m.shoulder_m[0])[::EVERY])
    u, shift = np.concatenate(features), np.concatenate(values)
    slope = np.zeros((3, 3))
    for row, used in enumerate(RHYTHM_SLOPES):
        slope[row, used] = ridge(u[:, used], shift[:, row], RHYTHM_RIDGE)
    return slope


def fit_prior(movements: Sequence[Movement]) -> tuple[float, float, float, float]:
    """height, lateral, regression and common swivel (P1). The common one is the mean at the start of the movements."""
    own = np.array([swivel_of_points(m.shoulder_m[0], m.elbow_m[0], m.wrist_m[0]) for m in movements])
    end = np.array([swivel_of_points(m.shoulder_m[-1], m.elbow_m[-1], m.wrist_m[-1]) for m in movements])
    d = np.array([m.wrist_m[-1] - m.wrist_m[0] for m in movements]) / SPAN_M
    square = (d**2).sum(axis=1)
    common = float(own.mean())
    features = np.column_stack([d[:, 2], d[:, 0], square / (square + FAR**2) * (common - own)])
    height, lateral, regression = ridge(features, end - own, PRIOR_RIDGE)
    return float(height), float(lateral), float(np.clip(regression, 0.0, 1.0)), common


def hand_progress(movement: Movement) -> Array:
    """Share of the wrist's way that is behind it, 0..1."""
    steps = np.linalg.norm(np.diff(movement.wrist_m, axis=0), axis=1)
    way = np.concatenate([[0.0], np.cumsum(steps)])
    return np.asarray(way / way[-1], dtype=float)


def arc_progress(arm: _core.ArmModel, q_rad: Array) -> Array:
    """Share of the Riemannian arc length of a joint path that is behind each row, 0..1."""
    middle, step = (q_rad[1:] + q_rad[:-1]) / 2.0, np.diff(q_rad, axis=0)
    lengths = [np.sqrt(max(0.0, float(d @ _core.mass_matrix(arm, q) @ d))) for q, d in zip(middle, step, strict=True)]
    way = np.concatenate([[0.0], np.cumsum(lengths)])
    return np.asarray(way / way[-1], dtype=float)


def fit_tail(movements: Sequence[Movement]) -> float:
    """The tail (T5) whose mean error of the progress along the path is least for the median movement: slow ones do not rule."""
    settings = _core.RhythmSettings()
    settings.model = _core.RhythmModel.Fixed
    scaled = _core.scale_subject(_core.Subject())
    rhythm = _core.Rhythm(settings, scaled.shoulder_distance_m)
    arm = _core.make_arm_model(scaled, rhythm, _core.JointLimits(), False)
    measured = [arc_progress(arm, m.q_rad) for m in movements]

    def error(tail: float) -> float:
        predicted = [cut_progress(m.duration_s, tail) for m in movements]
        return float(np.median([np.abs(a - b).mean() for a, b in zip(predicted, measured, strict=True)]))

    grid = np.linspace(0.0, 1.0, 21)
    return float(grid[int(np.argmin([error(tail) for tail in grid]))])


def fit(movements: Sequence[Movement]) -> Coefficients:
    """All coefficients of the measured models. InputError if there are too few movements."""
    if len(movements) < 10:
        raise InputError(f"a fit needs at least 10 movements, there are {len(movements)}")
    height, lateral, regression, common = fit_prior(movements)
    return Coefficients(
        slope_m=fit_rhythm(movements),
        shoulder_distance_m=float(np.mean([np.linalg.norm(m.shoulder_m[0]) for m in movements])),
        height_rad=height,
        lateral_rad=lateral,
        regression=regression,
        common_rad=common,
        tail=fit_tail(movements),
    )


def subjects_of(movements: Iterable[Movement]) -> list[str]:
    """Their persons, sorted."""
    return sorted({movement.subject for movement in movements})


def halves(movements: Sequence[Movement], most: int = 70) -> list[tuple[str, ...]]:
    """Every choice of half of the persons, or `most` of them at random: fitted to these, the others are judged."""
    people = subjects_of(movements)
    choices = list(itertools.combinations(people, len(people) // 2))
    if len(choices) <= most:
        return choices
    picked = np.random.default_rng(1712).choice(len(choices), most, replace=False)
    return [choices[i] for i in sorted(picked)]


def leave_one_out(movements: Sequence[Movement]) -> dict[str, Coefficients]:
    """For every person the coefficients fitted to all the others. InputError for fewer than two persons."""
    people = subjects_of(movements)
    if len(people) < 2:
        raise InputError(
            "cross-validation needs movements of at least two persons; --coefficients built-in judges one, by coefficients "
            "that may be fitted to them"
        )
    return {person: fit([m for m in movements if m.subject != person]) for person in people}


def to_yaml(fitted: Coefficients) -> str:
    """The coefficients as a reach file: `glenoid plan FILE --target-m ...` uses them."""
    numbers = {name: round(getattr(fitted, name), 6) for name in PRIOR_NAMES}
    measured = {
        "slope_m": [round(float(x), 6) for x in fitted.slope_m.ravel()],
        "shoulder_distance_m": round(fitted.shoulder_distance_m, 4),
    }
    data = {
        "rhythm": {"model": "Measured", "measured": measured},
        "swivel": {"mode": "HumanPrior", "prior": numbers},
        "timing": "MinimumJerkHoming",
    }
    return f"# homing tail of these recordings: {fitted.tail:.2f} (the core's: {_core.HOMING_TAIL})\n" + yaml.safe_dump(
        data, sort_keys=False
    )


def from_yaml(path: Path) -> Coefficients:
    """Coefficients from a file of `to_yaml`; what it does not have is the core's own."""
    reach = build_reach(read_mapping(path), str(path))
    base = vars(built_in())
    if reach.rhythm.measured is not None:
        base |= {
            "slope_m": np.array(reach.rhythm.measured.slope_m).reshape(3, 3),
            "shoulder_distance_m": reach.rhythm.measured.shoulder_distance_m,
        }
    if reach.swivel.prior is not None:
        base |= reach.swivel.prior.model_dump()
    return Coefficients(**base)
