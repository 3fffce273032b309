"""Measured movements and how they are read: points in the thorax frame T of a right arm, m, and angles, rad."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar
from zipfile import BadZipFile

import numpy as np

from glenoid.inputs import InputError
from glenoid.reach import Array
from glenoid.validate.geometry import angles_of_points

T = TypeVar("T")
SAMPLES = 101
#: sternum marker -> sternoclavicular joint, the origin of T, m (DSEM cadaver: 20 mm lateral, 14 mm back)
STERNUM_TO_JOINT_M = np.array([0.020, -0.015, 0.0])
#: what a segment's length and the shoulder's distance from the sternum can be, m, and a movement's duration, s
LENGTHS_M, DURATIONS_S = (0.05, 1.0), (0.05, 60.0)
POINT_COLUMNS = tuple(f"{point}_{axis}" for point in ("gh", "el", "wr") for axis in "xyz")


@dataclass(frozen=True)
class Movement:
    """One movement at SAMPLES equidistant times. A left arm is already mirrored.

    shoulder_m, elbow_m, wrist_m: (SAMPLES, 3) in T. q_rad: (SAMPLES, 4), unwrapped (theta, eta, zeta, phi).
    """

    name: str
    subject: str
    arm: str
    task: str
    phase: str
    clean: bool
    duration_s: float
    upper_arm_length_m: float
    forearm_length_m: float
    shoulder_m: Array
    elbow_m: Array
    wrist_m: Array
    q_rad: Array


def resampled(rows: Array, count: int = SAMPLES) -> Array:
    """Rows at `count` equidistant times, linear between samples."""
    known, wanted = np.linspace(0.0, 1.0, len(rows)), np.linspace(0.0, 1.0, count)
    return np.column_stack([np.interp(wanted, known, column) for column in rows.T])


def make_movement(
    shoulder_m: Array,
    elbow_m: Array,
    wrist_m: Array,
    *,
    name: str,
    subject: str,
    arm: str,
    task: str,
    duration_s: float,
    phase: str = "",
    clean: bool = True,
) -> Movement:
    """A movement from joint centres in T, any number of samples at a constant rate. InputError names the movement."""
    points = [resampled(np.asarray(rows, dtype=float)) for rows in (shoulder_m, elbow_m, wrist_m)]
    if not np.isfinite(np.stack(points)).all():
        raise InputError(f"movement {name}: a joint centre is not finite")
    upper, fore = (np.linalg.norm(b - a, axis=1) for a, b in zip(points, points[1:], strict=False))
    if min(upper.min(), fore.min()) <= 0.0:
        raise InputError(f"movement {name}: two joint centres coincide")
    lengths = {"upper arm": np.median(upper), "forearm": np.median(fore), "shoulder": np.linalg.norm(points[0][0])}
    for part, length in lengths.items():
        require_within(name, part, float(length), LENGTHS_M, "m")
    require_within(name, "duration", duration_s, DURATIONS_S, "s")
    return Movement(
        name=name,
        subject=subject,
        arm=arm,
        task=task,
        phase=phase,
        clean=clean,
        duration_s=duration_s,
        upper_arm_length_m=float(np.median(upper)),
        forearm_length_m=float(np.median(fore)),
        shoulder_m=points[0],
        elbow_m=points[1],
        wrist_m=points[2],
        q_rad=angles_of_points(*points),
    )


def require_within(movement: str, what: str, value: float, bounds: tuple[float, float], unit: str) -> None:
    """InputError for a value that no arm has: mostly another unit. The shoulder's is its distance from the sternum."""
    if not bounds[0] <= value <= bounds[1]:
        raise InputError(
            f"movement {movement}: {what} = {value:.4g} {unit}: must be {bounds[0]:g}..{bounds[1]:g} {unit}; "
            "another unit in the file?"
        )


def read_usable(
    path: Path, noun: str, items: Iterable[T], read: Callable[[T], Movement], unusable: type[InputError] = InputError
) -> list[Movement]:
    """What `read` makes of the items; those it finds unusable are left out and named. InputError where nothing is left."""
    out, left_out = [], []
    for item in items:
        try:
            out.append(read(item))
        except unusable as error:
            left_out.append(str(error))
    if not out:
        raise InputError(f"{path}: no {noun} is usable: {left_out[0] if left_out else 'there is none'}")
    for reason in left_out:
        print(f"{path}: left out: {reason}", file=sys.stderr)
    return out


def load_npz(path: Path) -> list[Movement]:
    """Movements of an archive laid out like the public reaches: data, columns, offsets, meta_*. InputError if it is not."""
    try:
        with np.load(path, allow_pickle=False) as archive:
            data, columns, offsets = archive["data"], list(archive["columns"]), archive["offsets"]
            meta = {key[5:]: archive[key] for key in archive.files if key.startswith("meta_")}
    except OSError as error:
        raise InputError(f"{path}: {error.strerror or error}") from error
    except (KeyError, TypeError, ValueError, EOFError, BadZipFile) as error:
        raise InputError(f"{path}: not an archive of reaches: {error}") from error
    missing = {"subject", "arm", "task", "duration_s"} - meta.keys() | set(POINT_COLUMNS) - set(columns)
    if missing:
        raise InputError(f"{path}: lacks {', '.join(sorted(missing))}")
    require_shapes(path, data, columns, offsets, meta)
    at = [columns.index(name) for name in POINT_COLUMNS]

    def movement(i: int) -> Movement:
        points = data[offsets[i] : offsets[i + 1]][:, at].astype(float).reshape(-1, 3, 3) - STERNUM_TO_JOINT_M
        return movement_of(points, {key: column[i] for key, column in meta.items()}, i)

    return read_usable(path, "movement", range(len(offsets) - 1), movement)


def require_shapes(
    path: Path, data: np.ndarray[Any, Any], columns: list[str], offsets: np.ndarray[Any, Any], meta: dict[str, Any]
) -> None:
    """InputError where the arrays of an archive do not fit each other."""
    if data.ndim != 2 or data.shape[1] != len(columns) or data.dtype.kind not in "fiu":
        raise InputError(
            f"{path}: data, {data.dtype} {data.shape}: must be numbers, a row per sample, a column for each of {len(columns)}"
        )
    rising = offsets.ndim == 1 and len(offsets) > 1 and offsets.dtype.kind in "iu" and (np.diff(offsets) >= 0).all()
    if not rising or offsets[0] < 0 or offsets[-1] > len(data):
        raise InputError(f"{path}: offsets: must be whole numbers, rising from 0 to the rows of data, {len(data)}")
    for key, column in meta.items():
        if np.shape(column) != (len(offsets) - 1,):
            raise InputError(
                f"{path}: meta_{key} {np.shape(column)}: must have one value for each of {len(offsets) - 1} movements"
            )
    if meta["duration_s"].dtype.kind not in "fiu":
        raise InputError(f"{path}: meta_duration_s, {meta['duration_s'].dtype}: must be numbers")


def movement_of(points: Array, values: dict[str, np.generic], index: int) -> Movement:
    """A movement of an archive from its joint centres (n, 3, 3) and its row of the meta data. InputError names it."""
    name = f"{values['subject']}{values['arm']}-{values.get('reach_id', index)}"
    if len(points) < 2:
        raise InputError(f"movement {name}: {len(points)} samples: needs 2")
    made = make_movement(
        points[:, 0],
        points[:, 1],
        points[:, 2],
        name=name,
        subject=str(values["subject"]),
        arm=str(values["arm"]),
        task=str(values["task"]),
        phase=str(values.get("phase", "")),
        clean=bool(values.get("clean", 1)),
        duration_s=float(values["duration_s"]),
    )
    return with_lengths(made, values)


def with_lengths(movement: Movement, values: dict[str, np.generic]) -> Movement:
    """The segment lengths of the person where the archive has them: medians over the person, not over one movement."""
    known = {
        name: float(values.get(key, np.float64(np.nan)))
        for name, key in (("upper_arm_length_m", "lu_m"), ("forearm_length_m", "lf_m"))
    }
    lengths = {name: value for name, value in known.items() if np.isfinite(value)}
    for name, value in lengths.items():
        require_within(movement.name, name, value, LENGTHS_M, "m")
    return Movement(**(vars(movement) | lengths))


def is_clean_outward(movement: Movement) -> bool:
    """Free point-to-point reaches: one speed peak, away from the table; no combing stroke, no way around the head."""
    return movement.clean and (movement.task.startswith("reach") or movement.phase == "up")


SUBSETS: dict[str, Callable[[Movement], bool]] = {
    "clean-outward": is_clean_outward,
    "clean": lambda movement: movement.clean,
    "all": lambda movement: True,
    "around-head": lambda movement: movement.task.startswith("comb") and movement.phase != "up",
    "carried-cup": lambda movement: movement.task == "drink",
}


def subset_of(movements: Sequence[Movement], subset: str) -> list[Movement]:
    """The movements of a subset. InputError for an unknown or empty one."""
    if subset not in SUBSETS:
        raise InputError(f"--subset = {subset!r}: must be one of {', '.join(SUBSETS)}")
    chosen = [movement for movement in movements if SUBSETS[subset](movement)]
    if not chosen:
        raise InputError(f"--subset = {subset!r}: no movement of the data is in it")
    return chosen
