"""Recordings of a clinic's own: marker positions from CSV, TRC or C3D, brought into the thorax frame and cut to movements.

The frame is that of the public reaches: x from the left to the right shoulder (horizontal), z up, y forward, origin at the
sternoclavicular joint; it follows the sternum and the resting shoulder. A left arm is mirrored.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import Field, ValidationError

from glenoid.inputs import InputError, Strict, explain, read_mapping
from glenoid.reach import Array
from glenoid.validate.formats import read_markers
from glenoid.validate.movements import STERNUM_TO_JOINT_M, Movement, make_movement, read_usable

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

    def movement(numbered: tuple[int, Recording]) -> Movement:
        index, item = numbered
        return read_movement(path.parent / item.file, item, index)

    return read_usable(path, "recording", enumerate(manifest.recordings), movement, UnusableRecordingError)


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
