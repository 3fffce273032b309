"""Pictures of devices: their axes, and their joints beside the arm's in time."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from glenoid.device_geometry import geometry, rotation
from glenoid.devices import JOINTS, Device
from glenoid.exo import DeviceMotion
from glenoid.plot import ANGLE_COLOURS, ANGLE_LABELS, BLUE, GREEN, GREY, INK, ORANGE, PALE, PURPLE, STYLE, plain
from glenoid.reach import Reach
from glenoid.tables import whole_file

AXIS_COLOURS = (BLUE, ORANGE, GREEN)
#: axes that coincide stay visible
LENGTHS = (1.0, 0.85, 0.7)
JOINT_COLOURS = (PURPLE, INK, BLUE, ORANGE, GREEN, GREY)


def draw_axes(device: Device, path: Path) -> None:
    """The three shoulder axes at zero in the thorax frame, from behind and from above. InputError for a template."""
    figures = geometry(device)
    axes = (rotation(figures.base_rad) @ figures.axes.T).T
    with mpl.rc_context(STYLE), whole_file(path) as place:
        figure = Figure(figsize=(8.4, 3.9), layout="constrained")
        panels = figure.subplots(1, 3)
        views = ((0, 2, "from behind", "right x", "up z"), (1, 2, "from the right", "forward y", "up z"))
        for panel, (first, second, title, *labels) in zip(
            panels, (*views, (0, 1, "from above", "right x", "forward y")), strict=True
        ):
            draw_axis_view(panel, axes, first, second)
            panel.set(title=title, xlabel=labels[0], ylabel=labels[1])
        handles, names = panels[0].get_legend_handles_labels()
        figure.legend(handles, names, loc="outside lower center", ncols=4)
        a12, a23 = (np.rad2deg(np.arccos(np.clip(axes[k] @ axes[k + 1], -1, 1))) for k in range(2))
        figure.suptitle(
            f"{plain(device.data.name)}: axes at zero, {a12:.0f} and {a23:.0f} deg apart", x=0.01, ha="left"
        )
        figure.savefig(place, dpi=90)


def draw_axis_view(panel: Axes, axes: np.ndarray, first: int, second: int) -> None:
    """Axes as arrows from the shoulder centre, with the hanging arm; one that points at the viewer is a ring."""
    arm = np.array([0.0, 0.0, -1.15])
    panel.plot(
        [0, arm[first]], [0, arm[second]], color=PALE, lw=9, solid_capstyle="round", label="hanging arm", zorder=1
    )
    for k, (axis, colour) in enumerate(zip(axes, AXIS_COLOURS, strict=True)):
        x, y = LENGTHS[k] * axis[first], LENGTHS[k] * axis[second]
        if np.hypot(x, y) < 0.05:
            panel.plot(0, 0, "o", ms=11 + 5 * k, mfc="none", mec=colour, mew=2.2, zorder=4)
        else:
            width = 0.014 + 0.009 * k
            panel.quiver(0, 0, x, y, color=colour, angles="xy", scale_units="xy", scale=1, width=width, zorder=3 + k)
        panel.plot([], [], color=colour, lw=3, label=f"axis {k + 1}")
    panel.plot(0, 0, "o", color=INK, ms=4, zorder=9)
    panel.set(xlim=(-1.3, 1.3), ylim=(-1.3, 1.3), aspect="equal")


def shade_range(panel: Axes, lower_deg: float, upper_deg: float) -> None:
    """Greys what lies outside a range, without widening the view beyond it by much."""
    low, high = panel.get_ylim()
    for edge, outer in ((lower_deg, low - 1e3), (upper_deg, high + 1e3)):
        if np.isfinite(edge) and abs(edge) < 1e9:
            panel.axhspan(min(edge, outer), max(edge, outer), color=GREY, alpha=0.18, lw=0)
            panel.axhline(edge, color=GREY, lw=0.8)
    panel.set_ylim(low, high)


def draw_arm_angles(panel: Axes, reach: Reach) -> None:
    """The person's angles."""
    for k, (label, colour) in enumerate(zip(ANGLE_LABELS, ANGLE_COLOURS, strict=True)):
        panel.plot(reach.time_s, np.rad2deg(reach.samples["q_rad"][:, k]), color=colour, label=label)
    panel.set(ylabel="angle (deg)")
    panel.set_title("Arm", pad=34)
    panel.legend(loc="lower left", bbox_to_anchor=(-0.02, 0.98), ncols=2, columnspacing=1.0, handlelength=1.2)


def draw_joint(panel: Axes, reach: Reach, motion: DeviceMotion, joint: int) -> None:
    """One joint of the device with its range."""
    panel.plot(reach.time_s, np.rad2deg(reach.samples["exo_q_rad"][:, joint]), color=JOINT_COLOURS[joint])
    low, high = panel.get_ylim()
    middle, half = 0.5 * (low + high), max(0.65 * (high - low), 6.0)
    panel.set_ylim(middle - half, middle + half)
    shade_range(panel, *np.rad2deg([motion.settings.lower_rad[joint], motion.settings.upper_rad[joint]]))
    panel.set(title=JOINTS[joint].replace("_", " "), ylabel="joint (deg)")


def draw_errors(panel: Axes, reach: Reach) -> None:
    """What the girdle drives leave, and what a fixed shoulder would leave."""
    panel.plot(reach.time_s, 1e3 * reach.samples["misalignment_m"], color=ORANGE, label="shoulder held fixed")
    panel.plot(reach.time_s, 1e3 * reach.samples["exo_residual_m"], color=BLUE, label="this device")
    panel.set(title="Shoulder centre, arm to device", ylabel="distance (mm)")
    panel.legend()


def draw_motion(reach: Reach, motion: DeviceMotion, path: Path) -> None:
    """Both spaces in time: the arm's angles and the device's joints; outside the joint ranges is grey."""
    with mpl.rc_context(STYLE), whole_file(path) as place:
        figure = Figure(figsize=(12.6, 6.6), layout="constrained")
        grid = figure.subplots(2, 4, sharex=True)
        draw_arm_angles(grid[0, 0], reach)
        draw_errors(grid[1, 0], reach)
        for joint in range(len(JOINTS)):
            draw_joint(grid[joint // 3, 1 + joint % 3], reach, motion, joint)
        for panel in grid[1]:
            panel.set(xlabel="time (s)", xlim=(0.0, reach.time_s[-1]))
        figure.suptitle(
            f"{plain(reach.given.name) or 'Reach'} with {plain(motion.device.data.name)}", x=0.008, ha="left"
        )
        figure.savefig(place, dpi=110)
