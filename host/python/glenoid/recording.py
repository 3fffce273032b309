"""Recorded and planned motions of a device's joints, out of LCM logs, CSV and JSON files."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import lcm
import numpy as np
from scipy.interpolate import CubicHermiteSpline, PchipInterpolator

from glenoid.devices import JOINTS
from glenoid.inputs import InputError
from glenoid.lcm_types import feedback_v1_t, setpoint_v1_t
from glenoid.publisher import FEEDBACK, MOST_JOINTS, SETPOINT, decoded
from glenoid.reach import Array


@dataclass(frozen=True)
class Recording:
    """A motion of joints in the order of exo.q.

    Attributes:
        time_s: N instants from 0, growing.
        position_rad: N x joints.
        velocity_rad_per_s: N x joints.
        skipped: messages of a log that were no setpoints of this motion.

    """

    time_s: Array
    position_rad: Array
    velocity_rad_per_s: Array
    skipped: int = 0

    @property
    def joints(self) -> int:
        """How many joints."""
        return int(self.position_rad.shape[1])

    @property
    def duration_s(self) -> float:
        """From the first to the last instant, s."""
        return float(self.time_s[-1])

    def curve(self) -> CubicHermiteSpline:
        """Position over time, with the recorded velocities at the recorded instants."""
        return CubicHermiteSpline(self.time_s, self.position_rad, self.velocity_rad_per_s)


def make_recording(time_s: Any, position_rad: Any, velocity_rad_per_s: Any, origin: str, skipped: int = 0) -> Recording:
    """A checked recording. InputError says what is wrong; velocities that are not given come from a monotone cubic."""
    time, position = np.asarray(time_s, dtype=float), np.asarray(position_rad, dtype=float)
    if position.ndim != 2 or len(time) != len(position) or len(time) < 2:
        raise InputError(f"{origin}: a motion needs two samples or more, one row of joints each")
    if not 1 <= position.shape[1] <= MOST_JOINTS:
        raise InputError(f"{origin}: {position.shape[1]} joints: must be 1 to {MOST_JOINTS}")
    if not (np.isfinite(time).all() and np.isfinite(position).all()):
        raise InputError(f"{origin}: a time or position is not finite")
    if (bad := np.flatnonzero(np.diff(time) <= 0)).size:
        raise InputError(f"{origin}: time {time[bad[0] + 1]} s after {time[bad[0]]} s: must grow")
    if velocity_rad_per_s is None:
        velocity = PchipInterpolator(time, position).derivative()(time)
    else:
        velocity = np.asarray(velocity_rad_per_s, dtype=float)
    if velocity.shape != position.shape or not np.isfinite(velocity).all():
        raise InputError(f"{origin}: velocities must be finite, one for each position")
    return Recording(time - time[0], position, velocity, skipped)


def read_recording(path: Path, channel: str | None = None) -> Recording:
    """A motion out of FILE: .csv and .json of `glenoid plan --exo` or `glenoid simulate --exo`, anything else an LCM log.

    Args:
        path: of the file.
        channel: of a log: "setpoint" (what was asked for) or "feedback" (what was measured); None takes setpoints if any.

    Raises:
        InputError: the file cannot be read or holds no motion of a device's joints.

    """
    readers: dict[str, Callable[[Path], Recording]] = {".csv": read_csv, ".json": read_json}
    reader = readers.get(path.suffix.lower())
    try:
        return reader(path) if reader is not None else read_log(path, channel)
    except OSError as error:
        raise InputError(f"{path}: {error.strerror or error}") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: not UTF-8: {error}") from error
    except (csv.Error, RecursionError) as error:
        raise InputError(f"{path}: {error}") from error


def column_names(header: Sequence[str]) -> tuple[list[str], list[str]]:
    """Columns of position and velocity: those of `glenoid plan --exo`, or q1_rad, q2_rad, ... and dq1_rad_per_s, ..."""
    planned = [f"exo_{name}_rad" for name in JOINTS]
    if planned[0] in header:
        return planned, [f"dexo_{name}_rad_per_s" for name in JOINTS]
    count = sum(f"q{k}_rad" in header for k in range(1, MOST_JOINTS + 1))
    return [f"q{k}_rad" for k in range(1, count + 1)], [f"dq{k}_rad_per_s" for k in range(1, count + 1)]


def read_table(path: Path) -> tuple[list[str], Array]:
    """Header and numbers of a CSV file with commas, with or without byte order mark, blank lines left out.

    Raises:
        InputError: a cell is no number, or a row has not one for each column; the text says in which line.
    """
    with path.open(newline="", encoding="utf-8-sig") as file:
        reader = csv.reader(file)
        rows = [(reader.line_num, row) for row in reader if row]
    header = rows[0][1] if rows else []
    if len(header) == 1 and ";" in header[0]:
        raise InputError(f"{path}: columns are separated by semicolons: must be commas, and points in the numbers")
    table = np.empty((max(0, len(rows) - 1), len(header)))
    for place, (line, row) in zip(table, rows[1:], strict=True):
        if len(row) != len(header):
            raise InputError(f"{path}:{line}: {len(row)} cells: must be {len(header)}, one for each column")
        for k, (name, cell) in enumerate(zip(header, row, strict=True)):
            try:
                place[k] = float(cell)
            except ValueError as error:
                raise InputError(f"{path}:{line}: {name} = {cell!r}: must be a number") from error
    return header, table


def read_csv(path: Path) -> Recording:
    """Columns time_s and those of `column_names`; others are ignored."""
    header, table = read_table(path)
    position, velocity = column_names(header)
    if missing := [name for name in ("time_s", *(position or ["q1_rad"])) if name not in header]:
        raise InputError(
            f"{path}: no column {missing[0]}; a motion of a device has them: glenoid plan --exo NAME --csv"
        )
    column = {name: table[:, k] for k, name in enumerate(header)}
    given = set(velocity) <= set(header)
    return make_recording(
        column["time_s"],
        np.column_stack([column[name] for name in position]),
        np.column_stack([column[name] for name in velocity]) if given else None,
        str(path),
    )


def read_json(path: Path) -> Recording:
    """time_s and exo_q_rad, at the top or under "motion" or "exo"."""
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise InputError(f"{path}: not readable as JSON: {error}") from error
    sections = [data] if isinstance(data, dict) else []
    sections += [data[key] for key in ("motion", "exo") if sections and isinstance(data.get(key), dict)]
    found = {key: section[key] for section in sections for key in section if section[key] is not None}
    if missing := [name for name in ("time_s", "exo_q_rad") if name not in found]:
        raise InputError(f"{path}: no {missing[0]}; a motion of a device has it: glenoid plan --exo NAME --json")
    try:
        return make_recording(found["time_s"], found["exo_q_rad"], found.get("exo_dq_rad_per_s"), str(path))
    except (TypeError, ValueError) as error:
        raise error if isinstance(error, InputError) else InputError(f"{path}: {error}") from error


@dataclass(frozen=True)
class Sample:
    """One message of a log."""

    session: int
    time_ns: int
    position_rad: tuple[float, ...]
    velocity_rad_per_s: tuple[float, ...]


def sample_of(event: lcm.Event) -> Sample | None:
    """None where the bytes are no message of the channel's type."""
    message: setpoint_v1_t | feedback_v1_t | None
    message = decoded(setpoint_v1_t, event.data) if event.channel == SETPOINT else decoded(feedback_v1_t, event.data)
    if message is None or not 1 <= message.count <= MOST_JOINTS:
        return None
    position, velocity = message.position_rad[: message.count], message.velocity_rad_per_s[: message.count]
    return Sample(message.session, message.time_mono_ns, tuple(position), tuple(velocity))


def longest_session(samples: list[Sample]) -> list[Sample]:
    """Of the samples with one token, one number of joints and growing stamps the longest list."""
    sessions: dict[tuple[int, int], list[Sample]] = {}
    for sample in samples:
        run = sessions.setdefault((sample.session, len(sample.position_rad)), [])
        if not run or sample.time_ns > run[-1].time_ns:
            run.append(sample)
    return max(sessions.values(), key=len, default=[])


def read_log(path: Path, channel: str | None = None) -> Recording:
    """Of an LCM log the longest session: a log may hold several, and other channels."""
    samples: dict[str, list[Sample]] = {SETPOINT: [], FEEDBACK: []}
    unreadable = 0
    for event in open_log(path):
        if event.channel in samples:
            sample = sample_of(event)
            unreadable += sample is None
            samples[event.channel] += [sample] if sample is not None else []
    chosen = {"setpoint": SETPOINT, "feedback": FEEDBACK, None: SETPOINT if samples[SETPOINT] else FEEDBACK}[channel]
    kept = longest_session(samples[chosen])
    if len(kept) < 2:
        raise InputError(f"{path}: no motion on {chosen}; is it a log of lcm-logger?")
    return make_recording(
        [1e-9 * (sample.time_ns - kept[0].time_ns) for sample in kept],
        [sample.position_rad for sample in kept],
        [sample.velocity_rad_per_s for sample in kept],
        str(path),
        unreadable + len(samples[chosen]) - len(kept),
    )


def open_log(path: Path) -> lcm.EventLog:
    """The log for reading. OSError where it cannot be opened."""
    with path.open("rb"):
        return lcm.EventLog(str(path), "r")
