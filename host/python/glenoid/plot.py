"""One picture of a reach: the arm in two views, its shoulder, its joints in time, and the choice of the swivel."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from glenoid.findings import warnings_for
from glenoid.reach import Array, Reach

# Okabe and Ito's palette: distinct with every common colour vision.
INK, GREY, PALE = "#1b1f24", "#7a828c", "#d9dde2"
BLUE, ORANGE, GREEN, PURPLE = "#0072b2", "#d55e00", "#009e73", "#aa4499"
ANGLE_COLOURS = (BLUE, ORANGE, GREEN, PURPLE)
ANGLE_LABELS = (r"$\theta$ elevation", r"$\eta$ plane", r"$\zeta$ rotation", r"$\varphi$ elbow")
STYLE: Any = {
    "font.size": 9.0,
    "axes.titlesize": 10.0,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": GREY,
    "axes.labelcolor": INK,
    "axes.grid": True,
    "grid.color": PALE,
    "grid.linewidth": 0.6,
    "xtick.color": GREY,
    "ytick.color": GREY,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "legend.frameon": False,
    "legend.fontsize": 8.0,
    "lines.linewidth": 1.8,
}
FIGURES = 9
X, Y, Z = 0, 1, 2


def pick_rows(progress: Array, count: int) -> list[int]:
    """Rows nearest to equal steps of the path parameter."""
    return [int(np.argmin(np.abs(progress - value))) for value in np.linspace(0.0, 1.0, count)]


def draw_arms(axes: Axes, reach: Reach, first: int, second: int) -> None:
    """Stick figures from pale (start) to dark (end)."""
    chain = np.stack([reach.samples[name] for name in ("shoulder_m", "elbow_m", "wrist_m")], axis=1)
    rows = pick_rows(reach.samples["progress"], FIGURES)
    shades = np.linspace(0.15, 1.0, len(rows))
    lines = [chain[row][:, (first, second)] for row in rows]
    colours = [(*to_rgb(BLUE), 0.12 + 0.88 * shade) for shade in shades]
    widths = [1.2 + 1.6 * (row in (rows[0], rows[-1])) for row in rows]
    axes.add_collection(LineCollection(lines, colors=colours, linewidths=widths, capstyle="round", joinstyle="round"))
    for line, colour in ((lines[0], colours[2]), (lines[-1], colours[-1])):
        axes.plot(*line.T, "o", color=colour[:3], alpha=colour[3], ms=4.5, mec="white", mew=0.6, zorder=4)


def draw_view(axes: Axes, reach: Reach, first: int, second: int, labels: tuple[str, str]) -> None:
    """Arm, hand path and what was measured, seen along the third axis; T's origin is marked."""
    draw_arms(axes, reach, first, second)
    wrist, shoulder = reach.samples["wrist_m"], reach.samples["shoulder_m"]
    axes.plot(wrist[:, first], wrist[:, second], color=ORANGE, lw=2.2, label="hand path", zorder=5)
    axes.plot(shoulder[:, first], shoulder[:, second], color=GREEN, lw=2.6, label="shoulder centre", zorder=5)
    target = reach.given.target_m
    axes.plot(target[first], target[second], "*", color=ORANGE, ms=11, mec="white", mew=0.8, zorder=7, label="target")
    measured = reach.given.measured
    if measured.wrist_path_m:
        path = np.array(measured.wrist_path_m)
        axes.plot(path[:, first], path[:, second], ":", color=INK, lw=1.6, label="measured hand", zorder=6)
    if measured.shoulder_m and measured.elbow_m and measured.wrist_m:
        arm = np.array([measured.shoulder_m, measured.elbow_m, measured.wrist_m])
        axes.plot(
            arm[:, first], arm[:, second], ":o", color=INK, lw=1.2, ms=3.5, mfc="white", label="measured end posture"
        )
    axes.plot(0, 0, "+", color=GREY, ms=9, mew=1.4)
    axes.annotate("S", (0, 0), textcoords="offset points", xytext=(5, -11), color=GREY)
    axes.set(xlabel=labels[0], ylabel=labels[1], aspect="equal")
    axes.margins(0.08)


def draw_shoulder(axes: Axes, reach: Reach) -> None:
    """Displacement of the shoulder centre, which a fixed-shoulder device ignores."""
    moved = 1e3 * (reach.samples["shoulder_m"] - reach.samples["shoulder_m"][0])
    for k, (name, colour) in enumerate(zip(("lateral", "forward", "up"), (PURPLE, ORANGE, GREEN), strict=True)):
        axes.plot(reach.time_s, moved[:, k], color=colour, label=name)
    axes.plot(reach.time_s, np.linalg.norm(moved, axis=1), "--", color=INK, lw=1.3, label="distance")
    axes.set(xlabel="time (s)", ylabel="from start (mm)", title="Shoulder-centre path")
    axes.legend(ncols=2)


def draw_angles(axes: Axes, reach: Reach) -> None:
    """Joint angles in time, with the measured end posture where it is known."""
    for k, (label, colour) in enumerate(zip(ANGLE_LABELS, ANGLE_COLOURS, strict=True)):
        axes.plot(reach.time_s, np.rad2deg(reach.samples["q_rad"][:, k]), color=colour, label=label)
        if reach.given.measured.end_q_deg:
            axes.plot(
                reach.time_s[-1], reach.given.measured.end_q_deg[k], "o", color=colour, mfc="white", ms=5, clip_on=False
            )
    if reach.given.measured.end_q_deg:
        axes.plot([], [], "o", color=GREY, mfc="white", ms=5, label="measured end")
    axes.set(xlabel="time (s)", ylabel="angle (deg)", title="Joint angles")
    axes.legend(ncols=2)


def draw_speeds(axes: Axes, reach: Reach) -> None:
    """Joint speeds in time."""
    for k, (label, colour) in enumerate(zip(ANGLE_LABELS, ANGLE_COLOURS, strict=True)):
        axes.plot(reach.time_s, np.rad2deg(reach.samples["dq_rad_per_s"][:, k]), color=colour, label=label)
    axes.set(xlabel="time (s)", ylabel="speed (deg/s)", title="Joint speeds")


def draw_family(axes: Axes, reach: Reach) -> None:
    """Energy over the swivel angle: every final posture that reaches the target, the feasible ones solid."""
    swivel = np.rad2deg(reach.family["swivel_rad"])
    energy = reach.family["energy_kg_m2"]
    feasible = reach.family["margin_rad"] >= 0.0
    axes.plot(swivel, energy, ".", color=PALE, ms=4, label="outside the limits")
    axes.plot(swivel[feasible], energy[feasible], ".", color=BLUE, ms=5, label="within the limits")
    chosen = np.rad2deg(reach.samples["swivel_rad"][-1])
    axes.plot(chosen, reach.generator.path.energy_kg_m2, "*", color=ORANGE, ms=13, mec="white", mew=0.8, label="chosen")
    finite = energy[feasible & np.isfinite(energy)]
    if finite.size:
        axes.set_ylim(0.0, 1.15 * finite.max())
    axes.set(
        xlabel=r"swivel angle $\alpha$ (deg)", ylabel=r"energy (kg m$^2$)", title="Energy over the family of postures"
    )
    axes.legend(loc="upper center", ncols=3, columnspacing=1.0, handletextpad=0.3)


def compose(reach: Reach) -> Figure:
    """The figure of a planned reach."""
    figure = Figure(figsize=(12.6, 7.4), layout="constrained")
    grid = figure.subplots(2, 3, height_ratios=(1.25, 1.0))
    draw_view(grid[0, 0], reach, Y, Z, ("forward y (m)", "up z (m)"))
    grid[0, 0].set_title("From the side (sagittal)")
    draw_view(grid[0, 1], reach, X, Z, ("lateral x (m)", "up z (m)"))
    grid[0, 1].set_title("From behind (frontal)")
    panels: tuple[tuple[Axes, Callable[[Axes, Reach], None]], ...] = (
        (grid[0, 2], draw_family),
        (grid[1, 0], draw_angles),
        (grid[1, 1], draw_speeds),
        (grid[1, 2], draw_shoulder),
    )
    for axes, draw in panels:
        draw(axes, reach)
    grid[0, 0].legend(loc="upper left", handlelength=1.6)
    figure.suptitle(headline(reach), x=0.012, ha="left", fontsize=12.0, color=INK, fontweight="bold")
    return figure


def draw_reach(reach: Reach, path: Path) -> None:
    """Writes the picture of a planned reach; the format follows the suffix of `path`."""
    with mpl.rc_context(STYLE):
        compose(reach).savefig(path, dpi=110)


def headline(reach: Reach) -> str:
    """Name, rhythm and, if there are any, the warnings."""
    text = reach.given.name or "Reach"
    text += f"  ·  rhythm {reach.given.rhythm.model} x {reach.given.rhythm.gain:g}"
    warnings = warnings_for(reach)
    return text + "".join(f"\nWARNING: {line}" for line in warnings)
