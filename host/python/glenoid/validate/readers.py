"""Recordings of a clinic's own: marker positions from CSV, TRC or C3D, brought into the thorax frame and cut to movements.

The frame is that of the public reaches: x from the left to the right shoulder (horizontal), z up, y forward, origin at the
sternoclavicular joint; it follows the sternum and the resting shoulder. A left arm is mirrored.
"""

from __future__ import annotations

import csv
import struct
import sys
import warnings
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import Field, ValidationError

from glenoid.inputs import InputError, Strict, explain, read_mapping
from glenoid.reach import Array
from glenoid.validate.movements import STERNUM_TO_JOINT_M, Movement, make_movement

METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001}
#: a movement lasts while the wrist is faster than this share of its peak speed
LEAST_SPEED = 0.05
#: gaps of markers up to this long are bridged by straight lines, s
MOST_GAP_S = 0.1
UP_M = 0.10
#: clean: one speed peak, path at most this many times the distance
MOST_DETOUR = 1.6


class UnusableRecordingError(InputError):
    """A recording that was read but shows no whole movement: left out of a list, and named."""


class Markers(Strict):
    """Names of the markers (or joint centres) in a recording. left and right are points of the two shoulders or acromia."""

    shoulder: str
    elbow: str
    wrist: str
    sternum: str
    left: str
    right: str


class Recording(Strict):
    """One recording with one movement."""

    file: str
    subject: str
    task: str
    arm: Literal["right", "left"] = "right"
    up: Literal["x", "y", "z", "-x", "-y", "-z"] = "z"
    unit: Literal["m", "cm", "mm"] | None = Field(default=None, description="of a CSV file; the other formats tell it")
    markers: Markers


class Manifest(Strict):
    """What `glenoid validate --data FILE.yaml` reads; files are found beside it."""

    recordings: list[Recording] = Field(min_length=1)


def load_manifest(path: Path) -> list[Movement]:
    """The movements of a list of recordings; unusable ones are left out and named. InputError names file and problem."""
    try:
        manifest = Manifest.model_validate(read_mapping(path))
    except ValidationError as error:
        raise explain(error, str(path)) from error
    out, left_out = [], []
    for index, item in enumerate(manifest.recordings):
        try:
            out.append(read_movement(path.parent / item.file, item, index))
        except UnusableRecordingError as error:
            left_out.append(str(error))
    if not out:
        raise InputError(f"{path}: no recording is usable: {left_out[0]}")
    for reason in left_out:
        print(f"{path}: left out: {reason}", file=sys.stderr)
    return out


def read_markers(path: Path, unit: str | None = None) -> tuple[float, dict[str, Array]]:
    """Rate in Hz and positions (n, 3) in m of every marker, NaN where it is hidden. InputError if the file cannot be read.

    A marker exactly at the lab's origin is a hidden one too: so do several systems write it.
    """
    readers = {".csv": read_csv, ".trc": read_trc, ".c3d": read_c3d}
    if path.suffix.lower() not in readers:
        raise InputError(f"{path}: must be .csv, .trc or .c3d")
    try:
        rate_hz, markers = readers[path.suffix.lower()](path, unit)
    except OSError as error:
        raise InputError(f"{path}: {error.strerror or error}") from error
    except (ValueError, KeyError, IndexError, AssertionError, struct.error) as error:
        raise InputError(f"{path}: not a {path.suffix[1:].upper()} file of markers: {error}") from error
    for rows in markers.values():
        rows[(rows == 0.0).all(axis=1)] = np.nan
    return rate_hz, markers


def read_csv(path: Path, unit: str | None) -> tuple[float, dict[str, Array]]:
    """Columns time_s and NAME_x, NAME_y, NAME_z; the unit must be given. An empty cell is an occluded marker."""
    if unit is None:
        raise InputError(f"{path}: a CSV file needs `unit` (m, cm, mm)")
    with path.open(encoding="utf-8-sig", newline="") as file:
        rows = [row for row in csv.reader(file) if row]
    if not rows or "time_s" not in (head := [name.strip() for name in rows[0]]):
        raise ValueError("the first line must name the columns: time_s, NAME_x, NAME_y, NAME_z with commas between")
    names = [name[:-2] for name in head if name.endswith("_x")]
    lacking = [f"{name}_{axis}" for name in names for axis in "yz" if f"{name}_{axis}" not in head]
    if lacking:
        raise ValueError(f"lacks column {', '.join(lacking)}")
    values = numbers(rows[1:], len(head))
    time_s = values[:, head.index("time_s")]
    scale = METRES[unit]
    return rate_of(time_s), {
        name: scale * values[:, [head.index(f"{name}_{axis}") for axis in "xyz"]] for name in names
    }


def read_trc(path: Path, unit: str | None = None) -> tuple[float, dict[str, Array]]:
    """The text format of OpenSim and Motion Analysis."""
    lines = path.read_text(encoding="utf-8-sig", errors="replace").splitlines()
    if len(lines) < 6:
        raise ValueError("five lines of head and then samples are needed")
    settings = dict(zip(lines[1].split("\t"), lines[2].split("\t"), strict=False))
    if not {"DataRate", "Units"} <= settings.keys():
        raise ValueError("lines 2 and 3 must give DataRate and Units, with tabs between")
    scale = metres(settings["Units"])
    names = [name.strip() for name in lines[3].split("\t")[2::3] if name.strip()]
    rows = [line.split("\t") for line in lines[5:] if line.strip()]
    values = numbers(rows, 2 + 3 * len(names))
    return float(settings["DataRate"]), {name: scale * values[:, 2 + 3 * k : 5 + 3 * k] for k, name in enumerate(names)}


def read_c3d(path: Path, unit: str | None = None) -> tuple[float, dict[str, Array]]:
    """The binary format of motion capture systems; occluded points are NaN."""
    import c3d  # type: ignore[import-untyped]

    with path.open("rb") as file, warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="No analog data")  # none is needed
        reader = c3d.Reader(file)
        names = [name.strip() for name in reader.point_labels]
        told = reader.get("POINT:UNITS")
        scale = metres(told.string_value if told is not None else unit or "")
        frames = np.array([points[:, :4] for _, points, _ in reader.read_frames()])
        rate = float(reader.point_rate)
    positions = np.where(frames[:, :, 3:4] < 0.0, np.nan, frames[:, :, :3])
    return rate, {name: scale * positions[:, k] for k, name in enumerate(names)}


def metres(unit: str) -> float:
    """Metres of a unit's name. ValueError for one that is none of length."""
    if unit.strip().lower() not in METRES:
        raise ValueError(f"unit {unit.strip()!r}: must be one of {', '.join(METRES)}")
    return METRES[unit.strip().lower()]


def numbers(rows: list[list[str]], width: int) -> Array:
    """A table of numbers, NaN in empty and missing cells. ValueError names a cell that is no number, or too few rows."""
    if len(rows) < 3:
        raise ValueError(f"{len(rows)} samples: needs 3")
    return np.array([[float(x) if x.strip() else np.nan for x in (row + [""] * width)[:width]] for row in rows])


def rate_of(time_s: Array) -> float:
    """Samples per second. ValueError if the times do not rise evenly."""
    steps = np.diff(time_s)
    if not (steps.min() > 0.0 and np.ptp(steps) <= 0.1 * steps.mean()):
        raise ValueError("time_s must rise evenly")
    return float(1.0 / steps.mean())


def filled(rows: Array, name: str) -> Array:
    """Gaps filled by straight lines. InputError for a marker that is never seen."""
    known = np.isfinite(rows).all(axis=1)
    if known.sum() < 2:
        raise UnusableRecordingError(f"marker {name} is never seen")
    at = np.arange(len(rows))
    return np.column_stack([np.interp(at, at[known], column[known]) for column in rows.T])


def up_axis(name: str) -> Array:
    """Unit vector of a lab axis."""
    return np.asarray(np.eye(3)["xyz".index(name[-1])] * (-1.0 if name.startswith("-") else 1.0), dtype=float)


def in_thorax(points: dict[str, Array], up: Array, arm: str) -> dict[str, Array]:
    """Points in T of a right arm, from lab positions with keys of Markers.

    The axes are those of the first sample; afterwards they turn with the direction from the sternum to the resting shoulder. A
    turn of the trunk about that very direction is not seen.
    """
    lateral = points["right"][0] - points["left"][0]
    lateral = lateral - (lateral @ up) * up
    x = lateral / np.linalg.norm(lateral)
    axes = np.stack([x, np.cross(up, x), up])
    resting = points["left" if arm == "right" else "right"] - points["sternum"]
    mirror = np.array([1.0 if arm == "right" else -1.0, 1.0, 1.0])
    out = {}
    for name in ("shoulder", "elbow", "wrist"):
        rows = points[name] - points["sternum"]
        turned = np.array([rotation_onto(a, resting[0]) @ p for a, p in zip(resting, rows, strict=True)])
        out[name] = (turned @ axes.T) * mirror - STERNUM_TO_JOINT_M
    return out


def rotation_onto(a: Array, b: Array) -> Array:
    """The shortest rotation that turns the direction of a into that of b, (3, 3)."""
    u, v = a / np.linalg.norm(a), b / np.linalg.norm(b)
    w = np.cross(u, v)
    K = np.array([[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]])
    return np.asarray(np.eye(3) + K + K @ K / (1.0 + u @ v), dtype=float)


def moving_part(wrist_m: Array, rate_hz: float) -> tuple[int, int, bool]:
    """First and last sample of the movement around the highest speed, and whether the wrist goes straight to its end."""
    speed = np.linalg.norm(np.gradient(wrist_m, axis=0), axis=1) * rate_hz
    peak = int(np.argmax(speed))
    slow = np.flatnonzero(speed < LEAST_SPEED * speed[peak])
    first = int(slow[slow < peak].max(initial=0))
    last = int(slow[slow > peak].min(initial=len(speed) - 1))
    way = speed[first : last + 1].sum() / rate_hz
    distance = float(np.linalg.norm(wrist_m[last] - wrist_m[first]))
    return first, last, bool(way < MOST_DETOUR * max(distance, 1e-9))


def longest_gap(rows: Array) -> int:
    """Samples of the longest run of rows with a NaN."""
    lengths = np.diff(np.flatnonzero(np.concatenate([[True], np.isfinite(rows).all(axis=1), [True]]))) - 1
    return int(lengths.max(initial=0))


def read_movement(path: Path, item: Recording, index: int) -> Movement:
    """The movement of one recording, in T. InputError names the file."""
    rate_hz, markers = read_markers(path, item.unit)
    wanted: dict[str, Any] = item.markers.model_dump()
    missing = sorted(set(wanted.values()) - markers.keys())
    if missing:
        raise InputError(f"{path}: no marker {', '.join(missing)}; there are {', '.join(sorted(markers))}")
    try:
        points = {key: filled(markers[name], name) for key, name in wanted.items()}
    except UnusableRecordingError as error:
        raise UnusableRecordingError(f"{path}: {error}") from error
    body = in_thorax(points, up_axis(item.up), item.arm)
    first, last, straight = moving_part(body["wrist"], rate_hz)
    if last - first < 5:
        raise UnusableRecordingError(f"{path}: no movement found")
    for name in wanted.values():
        gap_s = longest_gap(markers[name][first : last + 1]) / rate_hz
        if gap_s > MOST_GAP_S:
            raise UnusableRecordingError(
                f"{path}: marker {name} is not seen for {gap_s:.2f} s of the movement; at most {MOST_GAP_S} s are bridged"
            )
    cut = {name: rows[first : last + 1] for name, rows in body.items()}
    rise = cut["wrist"][-1, 2] - cut["wrist"][0, 2]
    return make_movement(
        cut["shoulder"],
        cut["elbow"],
        cut["wrist"],
        name=f"{item.subject}-{index}",
        subject=item.subject,
        arm=item.arm,
        task=item.task,
        phase="up" if rise > UP_M else "down" if rise < -UP_M else "level",
        clean=straight,
        duration_s=(last - first) / rate_hz,
    )
