"""Every model on every movement, and the sums: mean, median, a bootstrap interval over persons, tasks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from glenoid import _core
from glenoid.reach import Array
from glenoid.validate.coefficients import Coefficients, arc_progress, fit, halves, subjects_of
from glenoid.validate.models import MODELS, Model, Prediction, Predictor
from glenoid.validate.movements import SAMPLES, Movement
from glenoid.validate.score import Trajectory, course_scores, end_scores

GRID = np.linspace(0.0, 1.0, SAMPLES)
BOOTSTRAPS, BOOTSTRAP_SEED = 2000, 1712
#: errors with a sign or of outliers' weight are summed as root mean squares
RMS_KEYS = ("swivel_deg",)


@dataclass(frozen=True)
class Scored:
    """One model on one movement: scores over time, over the path, at the end, and how it was come by."""

    movement: Movement
    scores: dict[str, float]
    pulled_m: float
    failed: str = ""


def measured_course(movement: Movement) -> Trajectory:
    """The measured movement over normalised time."""
    return Trajectory(movement.shoulder_m, movement.elbow_m, movement.wrist_m, movement.q_rad)


def at_rows(course: Trajectory, place: Array) -> Trajectory:
    """A trajectory at fractional row numbers."""
    rows = np.arange(len(course.q_rad))
    return Trajectory(
        *(
            np.column_stack([np.interp(place, rows, column) for column in part.T])
            for part in (course.shoulder_m, course.elbow_m, course.wrist_m, course.q_rad)
        )
    )


def over_arc_length(arm: _core.ArmModel, course: Trajectory) -> Trajectory:
    """The same path at equal steps of Riemannian arc length: its time law is gone."""
    way = arc_progress(arm, course.q_rad)
    return at_rows(course, np.interp(GRID, way, np.arange(len(way))))


def about(course: Trajectory, shoulder_m: Array) -> Trajectory:
    """The same postures about another shoulder path."""
    shift = shoulder_m - course.shoulder_m
    return replace(course, shoulder_m=shoulder_m, elbow_m=course.elbow_m + shift, wrist_m=course.wrist_m + shift)


def score_prediction(
    model: Model, movement: Movement, prediction: Prediction, metric: _core.ArmModel
) -> dict[str, float]:
    """All scores of a prediction; keys of the path-only ones begin with path_."""
    measured = measured_course(movement)
    by_path = over_arc_length(metric, measured)
    predicted = prediction.course.at(prediction.shares(movement.duration_s))
    path = prediction.course.at(GRID)
    if model.line:
        path = over_arc_length(metric, path)
    if "shoulder" in model.oracle:
        predicted, path = about(predicted, measured.shoulder_m), about(path, by_path.shoulder_m)
    scores = course_scores(measured, predicted) | end_scores(measured, predicted)
    return scores | {f"path_{key}": value for key, value in course_scores(by_path, path).items()}


def evaluate(
    names: Sequence[str], movements: Sequence[Movement], fitted: Mapping[str, Coefficients]
) -> dict[str, list[Scored]]:
    """Scores of the named models; `fitted` has the coefficients to use for each person."""
    predictor = Predictor()
    out: dict[str, list[Scored]] = {name: [] for name in names}
    for movement in movements:
        metric = predictor.arm(MODELS["fixed-shoulder"], movement, fitted[movement.subject])
        for name in names:
            try:
                prediction = predictor.predict(MODELS[name], movement, fitted[movement.subject])
            except RuntimeError as error:
                out[name].append(Scored(movement, {}, float("nan"), str(error)))
                continue
            scores = score_prediction(MODELS[name], movement, prediction, metric)
            out[name].append(Scored(movement, scores, prediction.pulled_m))
    return out


def evaluate_halves(
    names: Sequence[str], movements: Sequence[Movement], fit_to: Sequence[Movement]
) -> dict[str, list[Scored]]:
    """Scores when only half of the persons are fitted to, every movement of the others judged; over all choices of halves."""
    out: dict[str, list[Scored]] = {name: [] for name in names}
    for half in halves(fit_to):
        one = fit([m for m in fit_to if m.subject in half])
        others = [m for m in movements if m.subject not in half]
        for name, rows in evaluate(names, others, dict.fromkeys(subjects_of(others), one)).items():
            out[name] += rows
    return out


def bootstrap_interval(values: Array, people: Array) -> tuple[float, float]:
    """95 % interval of the mean when the persons are drawn anew with replacement; the persons, not the reaches, are the sample."""
    groups = [values[people == person] for person in sorted(set(people))]
    random = np.random.default_rng(BOOTSTRAP_SEED)
    draws = random.integers(0, len(groups), size=(BOOTSTRAPS, len(groups)))
    sums, counts = np.array([g.sum() for g in groups]), np.array([len(g) for g in groups])
    means = sums[draws].sum(axis=1) / counts[draws].sum(axis=1)
    low, high = np.percentile(means, [2.5, 97.5])
    return float(low), float(high)


def summary(rows: Sequence[Scored]) -> dict[str, Any]:
    """Mean, median and interval of every score over the rows that have one; counts of pulled and failed ones."""
    done = [row for row in rows if not row.failed]
    out: dict[str, Any] = {
        "movements": len(rows),
        "failed": len(rows) - len(done),
        "pulled": sum(row.pulled_m > 0.0 for row in done),
    }
    if not done:
        return out
    people = np.array([row.movement.subject for row in done])
    for key in done[0].scores:
        values = np.array([row.scores[key] for row in done])
        known = np.isfinite(values)
        if not known.any():
            continue
        values = values[known]
        low, high = bootstrap_interval(values, people[known])
        out[key] = {"mean": float(values.mean()), "median": float(np.median(values)), "interval": [low, high]}
        if key in RMS_KEYS:
            out[key]["rms"] = float(np.sqrt((values**2).mean()))
    return out


def summaries(results: Mapping[str, Sequence[Scored]]) -> dict[str, Any]:
    """Per model: all movements, each task, each person."""
    out = {}
    for name, rows in results.items():
        tasks = sorted({row.movement.task for row in rows})
        people = subjects_of(row.movement for row in rows)
        out[name] = {
            "about": MODELS[name].about,
            "all": summary(rows),
            "tasks": {task: summary([row for row in rows if row.movement.task == task]) for task in tasks},
            "subjects": {who: summary([row for row in rows if row.movement.subject == who]) for who in people},
        }
    return out
