"""Scores of a predicted movement against the measured one; definitions in docs/human-likeness.md."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from glenoid.reach import Array
from glenoid.validate.geometry import swivel_of_points, wrapped

JOINTS = ("theta", "eta", "zeta", "phi")
#: joints that move less are left out of plain means: their r2 is noise over noise
LEAST_RANGE_RAD = np.deg2rad(5.0)


@dataclass(frozen=True)
class Trajectory:
    """Shoulder, elbow and wrist (n, 3) m in T, and (theta, eta, zeta, phi) (n, 4) rad."""

    shoulder_m: Array
    elbow_m: Array
    wrist_m: Array
    q_rad: Array


def squares(measured: Array, predicted: Array) -> tuple[Array, Array]:
    """Sums of squared errors and of squares about the mean, a number per column."""
    return ((measured - predicted) ** 2).sum(axis=0), ((measured - measured.mean(axis=0)) ** 2).sum(axis=0)


def strict_r2(measured: Array, predicted: Array) -> float:
    """1 - SSE/SST, both summed over all columns: 1 for a perfect prediction, 0 for the mean, below 0 for worse."""
    sse, sst = squares(measured, predicted)
    return float(1.0 - sse.sum() / sst.sum())


def squared_pearson(measured: Array, predicted: Array) -> float:
    """Squared correlation of two columns; blind to offset and scale. 0 where one of them is constant."""
    a, b = measured - measured.mean(), predicted - predicted.mean()
    norm = (a @ a) * (b @ b)
    return float((a @ b) ** 2 / norm) if norm > 0.0 else 0.0


def rms_distance(a_m: Array, b_m: Array) -> float:
    """Root mean square distance of two point sequences, m."""
    return float(np.sqrt(((a_m - b_m) ** 2).sum(axis=1).mean()))


def turned_near(q_rad: Array, reference_rad: Array) -> Array:
    """The same postures with eta and zeta shifted by whole turns so that the first row is nearest to the reference's."""
    shift = np.round((reference_rad[0] - q_rad[0]) / (2.0 * np.pi)) * (2.0 * np.pi)
    return np.asarray(q_rad + shift * np.array([0.0, 1.0, 1.0, 0.0]), dtype=float)


def joint_scores(measured_rad: Array, predicted_rad: Array) -> dict[str, float]:
    """Strict r2 pooled over the joints, plain mean over moving joints, each joint (NaN where it does not move), and others."""
    predicted = turned_near(predicted_rad, measured_rad)
    sse, sst = squares(measured_rad, predicted)
    moves = np.ptp(measured_rad, axis=0) > LEAST_RANGE_RAD
    each = np.where(moves, 1.0 - sse / np.maximum(sst, 1e-300), np.nan)
    pearson = [squared_pearson(measured_rad[:, k], predicted[:, k]) for k in range(4) if moves[k]]
    return {
        "joint_pooled": strict_r2(measured_rad, predicted),
        "joint_plain": float(np.nanmean(each)) if moves.any() else float("nan"),
        "joint_pearson": float(np.mean(pearson)) if pearson else float("nan"),
        "joint_rms_deg": float(np.rad2deg(np.sqrt(((measured_rad - predicted) ** 2).mean()))),
    } | {f"{name}_r2": float(value) for name, value in zip(JOINTS, each, strict=True)}


def course_scores(measured: Trajectory, predicted: Trajectory) -> dict[str, float]:
    """Scores along the way, both sampled at the same abscissa."""
    return joint_scores(measured.q_rad, predicted.q_rad) | {
        "elbow_r2": strict_r2(measured.elbow_m, predicted.elbow_m),
        "wrist_r2": strict_r2(measured.wrist_m, predicted.wrist_m),
        "elbow_rms_cm": 100.0 * rms_distance(measured.elbow_m, predicted.elbow_m),
        "wrist_rms_cm": 100.0 * rms_distance(measured.wrist_m, predicted.wrist_m),
        "gh_mm": 1e3 * float(np.linalg.norm(measured.shoulder_m - predicted.shoulder_m, axis=1).mean()),
        "gh_rms_mm": 1e3 * rms_distance(measured.shoulder_m, predicted.shoulder_m),
    }


def end_scores(measured: Trajectory, predicted: Trajectory) -> dict[str, float]:
    """Errors of the final posture. swivel_deg is signed: predicted minus measured."""
    first, second = (swivel_of_points(x.shoulder_m[-1], x.elbow_m[-1], x.wrist_m[-1]) for x in (predicted, measured))
    angles = turned_near(predicted.q_rad, measured.q_rad)[-1] - measured.q_rad[-1]
    return {
        "swivel_deg": float(np.rad2deg(wrapped(first - second))),
        "end_posture_deg": float(np.rad2deg(np.sqrt((angles**2).mean()))),
        "end_elbow_cm": 100.0 * float(np.linalg.norm(predicted.elbow_m[-1] - measured.elbow_m[-1])),
        "end_gh_mm": 1e3 * float(np.linalg.norm(predicted.shoulder_m[-1] - measured.shoulder_m[-1])),
    }
