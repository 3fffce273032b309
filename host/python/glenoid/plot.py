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
from glenoid.tables import whole_file

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


def draw_girdle(axes: Axes, reach: Reach, first: int, second: int) -> None:
    """The line from the trunk's fixed point S to the shoulder centre, at the start and at the end."""
    for row, colour in ((0, GREY), (-1, GREEN)):
        centre = reach.samples["shoulder_m"][row]
        axes.plot([0.0, centre[first]], [0.0, centre[second]], color=colour, lw=1.2, ls=(0, (4, 2)), zorder=3)
    axes.plot(0, 0, "s", color=GREY, ms=5)
    axes.annotate("S", (0, 0), textcoords="offset points", xytext=(-11, -11), color=GREY)


def draw_measured(axes: Axes, reach: Reach, first: int, second: int) -> None:
    """What the person did, where the file says it."""
    measured = reach.given.measured
    if measured.wrist_path_m:
        path = np.array(measured.wrist_path_m)
        axes.plot(path[:, first], path[:, second], ":", color=INK, lw=1.6, label="measured hand", zorder=6)
    if measured.shoulder_m and measured.elbow_m and measured.wrist_m:
        arm = np.array([measured.shoulder_m, measured.elbow_m, measured.wrist_m])
        axes.plot(
            arm[:, first], arm[:, second], "--o", color=INK, lw=1.0, ms=4, mfc="white", label="measured end posture"
        )


def draw_view(axes: Axes, reach: Reach, first: int, second: int, labels: tuple[str, str]) -> None:
    """Arm, hand path and what was measured, seen along the third axis."""
    draw_girdle(axes, reach, first, second)
    draw_arms(axes, reach, first, second)
    wrist, shoulder = reach.samples["wrist_m"], reach.samples["shoulder_m"]
    axes.plot([], [], color=BLUE, lw=2.2, label="arm (start pale)")
    axes.plot(wrist[:, first], wrist[:, second], color=ORANGE, lw=2.2, label="hand path", zorder=5)
    axes.plot(shoulder[:, first], shoulder[:, second], color=GREEN, lw=3.0, label="shoulder centre", zorder=5)
    draw_measured(axes, reach, first, second)
    target = reach.given.target_m
    axes.plot(target[first], target[second], "*", color=ORANGE, ms=13, mec="white", mew=0.8, zorder=7, label="target")
    axes.set(xlabel=labels[0], ylabel=labels[1])
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.06)


def draw_shoulder(axes: Axes, reach: Reach) -> None:
    """Displacement of the shoulder centre, which a fixed-shoulder device ignores."""
    moved = 1e3 * (reach.samples["shoulder_m"] - reach.samples["shoulder_m"][0])
    for k, (name, colour) in enumerate(zip(("lateral", "forward", "up"), (PURPLE, ORANGE, GREEN), strict=True)):
        axes.plot(reach.time_s, moved[:, k], color=colour, label=name)
    axes.plot(reach.time_s, np.linalg.norm(moved, axis=1), "--", color=INK, lw=1.3, label="distance")
    axes.set(xlabel="time (s)", ylabel="from start (mm)", xlim=(0.0, reach.time_s[-1]))
    axes.set_title("Shoulder centre", pad=20)
    legend_above(axes)


def draw_angles(axes: Axes, reach: Reach) -> None:
    """Joint angles in time, with the measured end posture where it is known."""
    for k, (label, colour) in enumerate(zip(ANGLE_LABELS, ANGLE_COLOURS, strict=True)):
        axes.plot(reach.time_s, np.rad2deg(reach.samples["q_rad"][:, k]), color=colour, label=label)
    end = reach.given.measured.end_q_deg
    for value, colour in zip(end or (), ANGLE_COLOURS, strict=False):
        axes.plot(reach.time_s[-1], value, "o", color=colour, mfc="white", mew=1.5, ms=6, clip_on=False, zorder=5)
    if end is not None:
        axes.plot([], [], "o", color=GREY, mfc="white", mew=1.5, ms=6, label="measured")
    axes.set(xlabel="time (s)", ylabel="angle (deg)", xlim=(0.0, reach.time_s[-1]))
    axes.set_title("Joint angles", pad=20)
    legend_above(axes)


def draw_speeds(axes: Axes, reach: Reach) -> None:
    """Joint speeds in time."""
    for k, (label, colour) in enumerate(zip(ANGLE_LABELS, ANGLE_COLOURS, strict=True)):
        axes.plot(reach.time_s, np.rad2deg(reach.samples["dq_rad_per_s"][:, k]), color=colour, label=label)
    axes.set(xlabel="time (s)", ylabel="speed (deg/s)", xlim=(0.0, reach.time_s[-1]))
    axes.set_title("Joint speeds", pad=20)
    legend_above(axes)


def legend_above(axes: Axes, columns: int = 5) -> None:
    """A legend in one row between title and axes, where no curve can run through it."""
    legend = axes.legend(
        loc="lower left",
        bbox_to_anchor=(-0.02, 0.98),
        ncols=columns,
        columnspacing=1.0,
        handlelength=1.2,
        handletextpad=0.35,
    )
    legend.set_in_layout(False)


def draw_family(axes: Axes, reach: Reach) -> None:
    """Energy over the swivel angle: every final posture that reaches the target, the feasible ones solid."""
    swivel = np.rad2deg(reach.family["swivel_rad"])
    energy = reach.family["energy_kg_m2"]
    feasible = reach.family["margin_rad"] >= 0.0
    axes.plot(swivel, energy, ".", color=PALE, ms=4, label="outside the limits")
    axes.plot(swivel[feasible], energy[feasible], ".", color=BLUE, ms=5, label="within the limits")
    chosen = np.rad2deg(reach.samples["swivel_rad"][-1])
    axes.plot(chosen, reach.generator.path.energy_kg_m2, "*", color=ORANGE, ms=13, mec="white", mew=0.8, label="chosen")
    finite = feasible & np.isfinite(energy)
    if finite.any():
        low, high = float(energy[finite].min()), float(energy[finite].max())
        room = max(0.25 * (high - low), 0.05 * high)
        axes.set(ylim=(low - room, high + room), xlim=(swivel[finite].min() - 30.0, swivel[finite].max() + 30.0))
    axes.set(
        xlabel=r"swivel angle $\alpha$ (deg)", ylabel=r"energy (kg m$^2$)", title="Energy over the family of postures"
    )
    axes.set_title("Energy over the family of postures", pad=20)
    legend_above(axes)


def compose(reach: Reach) -> Figure:
    """The figure of a planned reach."""
    figure = Figure(figsize=(12.6, 7.4), layout="constrained")
    grid = figure.subplots(2, 3, height_ratios=(1.25, 1.0))
    draw_view(grid[0, 0], reach, Y, Z, ("forward y (m)", "up z (m)"))
    grid[0, 0].set_title("From the side (sagittal)", pad=20)
    draw_view(grid[0, 1], reach, X, Z, ("lateral x (m)", "up z (m)"))
    grid[0, 1].set_title("From behind (frontal)", pad=20)
    panels: tuple[tuple[Axes, Callable[[Axes, Reach], None]], ...] = (
        (grid[0, 2], draw_family),
        (grid[1, 0], draw_angles),
        (grid[1, 1], draw_speeds),
        (grid[1, 2], draw_shoulder),
    )
    for axes, draw in panels:
        draw(axes, reach)
    legend_above(grid[0, 0], columns=6)
    figure.suptitle(headline(reach), x=0.008, ha="left", fontsize=12.0, color=INK, fontweight="bold")
    return figure


def draw_reach(reach: Reach, path: Path) -> None:
    """Writes the picture of a planned reach; the format follows the suffix of `path`. InputError if it cannot be written."""
    with mpl.rc_context(STYLE), whole_file(path) as place:
        compose(reach).savefig(place, dpi=110)


def plain(text: str) -> str:
    """Text in which a dollar sign begins no formula."""
    return text.replace("$", r"\$")


def headline(reach: Reach) -> str:
    """Name, choices and, if there are any, the warnings."""
    given = reach.given
    swivel = np.rad2deg(reach.samples["swivel_rad"][-1])
    text = f"{plain(given.name) or 'Reach'}: {given.swivel.mode}, swivel {swivel:.1f} deg, "
    text += f"rhythm {given.rhythm.model}, gain {given.rhythm.gain:g}"
    return text + "".join(f"\nWARNING: {line}" for line in warnings_for(reach))
