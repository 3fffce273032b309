"""Pictures of a rehearsal."""

from __future__ import annotations

import base64
import io
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from glenoid.plot import STYLE
from glenoid.publisher import STATES
from glenoid.rehearse.checks import Evidence, sync_errors_us

COLOURS = ("#1b6ca8", "#d1495b", "#2e8b57", "#edae49", "#6a4c93", "#444444")


def png(figure: Figure) -> str:
    """A picture as a data URL, the same bytes for the same figure."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=110, metadata={"Software": None})
    return "data:image/png;base64," + base64.b64encode(buffer.getvalue()).decode("ascii")


def frame(rows: int = 1) -> tuple[Figure, Any]:
    """A figure with axes below each other that share their time."""
    figure = Figure(figsize=(9.0, 1.4 + 2.2 * rows), layout="constrained")
    return figure, figure.subplots(rows, 1, sharex=True, squeeze=False)[:, 0]


def mark(axes: Any, e: Evidence) -> None:
    """Dotted lines where something was made to go wrong."""
    for k, fault in enumerate(e.scenario.data.faults):
        axes.axvline(fault.at_s, color="#d1495b", linestyle=":", label=fault.kind.replace("_", " ") if k == 0 else None)


def seen(e: Evidence) -> tuple[Any, Any]:
    """Times of the feedback from shortly before the motion on, s, and which rows these are."""
    times = e.record.seconds(e.record.feedback["time_ns"])
    rows = times > -0.5
    return times[rows], rows


def joints(e: Evidence) -> Figure:
    """Commanded and measured joints; the band is what the bridge allows."""
    names = e.scenario.joints
    figure = Figure(figsize=(9.0, 1.9 * ((len(names) + 1) // 2) + 0.4), layout="constrained")
    grid = figure.subplots((len(names) + 1) // 2, 2, sharex=True, squeeze=False)
    times, rows = seen(e)
    for k, name in enumerate(names):
        axes = grid[k // 2, k % 2]
        axes.plot(times, e.record.feedback["command_rad"][rows, k], color="#999999", linewidth=2.5, label="command")
        axes.plot(
            times, e.record.feedback["position_rad"][rows, k], color=COLOURS[k % 6], linewidth=1.0, label="measured"
        )
        if (truth := e.record.truth) is not None and len(e.scenario.data.faults):
            since = e.record.seconds(truth["time_ns"])
            shown = since > -0.5
            axes.plot(since[shown], truth["position_rad"][shown, k], color="#222222", linestyle=":", label="true")
        joint = e.scenario.config.joints[k]
        for limit in ("lower_rad", "upper_rad"):
            axes.axhline(joint[limit], color="#bbbbbb", linewidth=0.7)
        mark(axes, e)
        axes.set_title(name.replace("_", " "), loc="left")
        axes.set_ylabel("angle (rad)")
        axes.secondary_yaxis("right", functions=(np.rad2deg, np.deg2rad)).set_ylabel("deg")
    grid[0, 0].legend(loc="best")
    for axes in grid[-1]:
        axes.set_xlabel("time (s)")
    return figure


def drives(e: Evidence) -> Figure:
    """Speeds and torques at the joints, and the bridge's state."""
    figure, axes = frame(3)
    times, rows = seen(e)
    for k, name in enumerate(e.scenario.joints):
        label = name.replace("_", " ")
        axes[0].plot(times, e.record.feedback["velocity_rad_per_s"][rows, k], color=COLOURS[k % 6], label=label)
        axes[1].plot(times, e.record.feedback["effort_Nm"][rows, k], color=COLOURS[k % 6])
    axes[0].set_ylabel("speed (rad/s)")
    axes[0].legend(loc="best", ncols=2)
    axes[1].set_ylabel("torque (Nm)")
    axes[2].step(times, e.record.feedback["state"][rows], where="post", color="#1b6ca8")
    axes[2].set_yticks(list(STATES), labels=list(STATES.values()))
    axes[2].set_ylim(0.5, 6.5)
    axes[2].set_ylabel("state")
    axes[2].set_xlabel("time (s)")
    for one in axes:
        mark(one, e)
    return figure


def errors(e: Evidence) -> Figure:
    """What the drives lag behind the source, and the hand's path in height."""
    figure, axes = frame(2)
    times = e.record.seconds(e.record.feedback["time_ns"][e.in_motion])
    for k, name in enumerate(e.scenario.joints):
        axes[0].plot(
            times,
            1e3 * (e.measured_rad[:, k] - e.reference_rad[:, k]),
            color=COLOURS[k % 6],
            label=name.replace("_", " "),
        )
    mark(axes[0], e)
    axes[0].set_ylabel("tracking error (mrad)")
    axes[0].legend(loc="best", ncols=2)
    wrist = e.motion.samples["wrist_m"]
    grid = np.arange(len(wrist)) * e.motion.period_s
    for k, label in enumerate(("to the right", "forward", "up")):
        axes[1].plot(grid, wrist[:, k], color=COLOURS[k], label=label)
    axes[1].set_ylabel("planned wrist (m)")
    axes[1].set_xlabel("time (s)")
    axes[1].legend(loc="best")
    return figure


def jitter(e: Evidence) -> Figure:
    """Histogram of the intervals between SYNCs."""
    figure, axes = frame()
    values = sync_errors_us(e.record, e.scenario.config.period_ns, e.until_ns)
    if values.size and not values.any():
        axes[0].set_title("virtual time: none", loc="left")
    if values.size:
        axes[0].hist(values, bins=np.linspace(-1.0, 1.0, 61) * max(1.0, float(np.abs(values).max())), color="#1b6ca8")
    axes[0].set_yscale("symlog")
    axes[0].set_xlabel("interval between two SYNCs less the period (us)")
    axes[0].set_ylabel("count (1)")
    return figure


def pictures(e: Evidence) -> list[tuple[str, str]]:
    """Title and data URL of each picture."""
    with mpl.rc_context(STYLE):
        return [
            ("Joints: command and measured", png(joints(e))),
            ("Drives", png(drives(e))),
            ("Tracking error and planned hand", png(errors(e))),
            ("Jitter of SYNC", png(jitter(e))),
        ]
