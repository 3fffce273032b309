"""Files of marker positions: CSV, TRC and C3D."""

from __future__ import annotations

import csv
import struct
import warnings
from pathlib import Path

import numpy as np

from glenoid.inputs import InputError
from glenoid.reach import Array

METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001}


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
