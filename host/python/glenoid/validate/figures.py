"""Pictures of a validation: overlays per reach, distributions of r2, rhythm curves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from glenoid import _core
from glenoid.reach import Array
from glenoid.validate.coefficients import Coefficients, upper_arm_direction
from glenoid.validate.evaluate import GRID, Scored
from glenoid.validate.models import MODELS, Predictor
from glenoid.validate.movements import Movement
from glenoid.validate.score import JOINTS, turned_near

THETA_BINS_DEG = np.arange(10.0, 140.0, 10.0)


def draw_distributions(results: Mapping[str, Sequence[Scored]], path: Path) -> None:
    """Cumulative distributions of the three strict r2 over the movements."""
    figure, axes = plt.subplots(1, 3, figsize=(13, 4.5), sharey=True)
    titles = {"joint_pooled": "joint r2, pooled", "elbow_r2": "elbow r2", "wrist_r2": "wrist r2"}
    colours = plt.get_cmap("tab20").colors  # type: ignore[attr-defined]
    for axis, (key, title) in zip(axes, titles.items(), strict=True):
        for k, (name, rows) in enumerate(results.items()):
            values = np.sort([row.scores[key] for row in rows if not row.failed])
            style: dict[str, Any] = {
                "ls": "--" if MODELS[name].oracle else "-",
                "lw": 2.2 if name == "glenoid" else 1.2,
            }
            axis.plot(values, np.linspace(0.0, 1.0, len(values)), color=colours[k % len(colours)], label=name, **style)
        axis.set_xlim(0.0, 1.0)
        axis.set_xlabel(title)
    axes[0].set_ylabel("share of movements below")
    axes[-1].legend(
        fontsize=7, loc="upper left", bbox_to_anchor=(1.0, 1.0), title="dashed: told more", title_fontsize=7
    )
    save(figure, path)


def typical(rows: Sequence[Scored]) -> list[Scored]:
    """Of every task the movement with the median pooled joint r2."""
    out = []
    for task in sorted({row.movement.task for row in rows}):
        of_task = sorted(
            (r for r in rows if r.movement.task == task and not r.failed), key=lambda r: r.scores["joint_pooled"]
        )
        if of_task:
            out.append(of_task[len(of_task) // 2])
    return out


def draw_overlays(names: Sequence[str], rows: Sequence[Scored], fitted: Mapping[str, Coefficients], path: Path) -> None:
    """Joint angles over normalised time of the typical movement of each task, measured and predicted."""
    chosen, predictor = typical(rows), Predictor()
    figure, axes = plt.subplots(len(chosen), 4, figsize=(13, 2.6 * len(chosen)), sharex=True, squeeze=False)
    for line, row in zip(axes, chosen, strict=True):
        movement = row.movement
        curves = {"measured": movement.q_rad}
        for name in names:
            prediction = predictor.predict(MODELS[name], movement, fitted[movement.subject])
            curves[name] = turned_near(
                prediction.course.at(prediction.shares(movement.duration_s)).q_rad, movement.q_rad
            )
        for k, axis in enumerate(line):
            for name, q in curves.items():
                style: dict[str, Any] = {"color": "black", "lw": 2.0} if name == "measured" else {"lw": 1.2}
                axis.plot(GRID, np.rad2deg(q[:, k]), label=name, **style)
            axis.set_title(f"{JOINTS[k]} deg, {movement.task} {movement.name}", fontsize=8)
    for axis in axes[-1]:
        axis.set_xlabel("share of the time", fontsize=8)
    axes[0][0].legend(fontsize=7)
    save(figure, path)


def girdle_increments(shoulder_m: Array) -> Array:
    """Change of (phi_ed deg, phi_pr deg, d_SG mm) since the start."""
    girdle = np.array([_core.girdle_coordinates(row) for row in shoulder_m]) * [180 / np.pi, 180 / np.pi, 1e3]
    return np.asarray(girdle - girdle[0], dtype=float)


def draw_rhythms(movements: Sequence[Movement], fitted: Mapping[str, Coefficients], path: Path) -> None:
    """Girdle angles against elevation, measured and by each rhythm driven with the measured upper arm; means per bin."""
    predictor = Predictor()
    theta = np.concatenate([np.rad2deg(m.q_rad[:, 0]) for m in movements])
    curves = {"measured": np.concatenate([girdle_increments(m.shoulder_m) for m in movements])}
    for label, name in (("eq. (1)", "paper"), ("rhythm Measured", "prior"), ("fixed shoulder", "fixed-shoulder")):
        parts = []
        for m in movements:
            rhythm = predictor.arm(MODELS[name], m, fitted[m.subject]).rhythm
            parts.append(girdle_increments(np.array([rhythm.position(-u) for u in upper_arm_direction(m)])))
        curves[label] = np.concatenate(parts)
    figure, axes = plt.subplots(1, 3, figsize=(12, 4))
    bins = np.digitize(theta, THETA_BINS_DEG)
    for k, (axis, title) in enumerate(zip(axes, ("phi_ed deg", "phi_pr deg", "d_SG mm"), strict=True)):
        for label, values in curves.items():
            known = [b for b in range(1, len(THETA_BINS_DEG)) if (bins == b).sum() > 50]
            axis.plot(THETA_BINS_DEG[known] - 5.0, [values[bins == b, k].mean() for b in known], label=label)
        axis.set_title(f"change of {title} since the start")
        axis.set_xlabel("elevation theta, deg")
    axes[0].legend(fontsize=8)
    save(figure, path)


def save(figure: Any, path: Path) -> None:
    """Writes and closes a figure."""
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    plt.close(figure)
