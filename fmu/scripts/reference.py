"""Runs the default experiment of a library (FMI 3.0) and draws it."""

from __future__ import annotations

import ctypes
import xml.etree.ElementTree as ET
from pathlib import Path

from description import Variable, read_variables

Row = dict[str, float]
OUTPUT_INTERVAL_S = 0.01


def check(status: int, call: str) -> None:
    """Raises RuntimeError unless the status is fmi3OK."""
    if status != 0:
        raise RuntimeError(f"{call}: status {status}")


def read_row(library: ctypes.CDLL, instance: ctypes.c_void_p, outputs: list[Variable], time_s: float) -> Row:
    """All outputs now."""
    row = {"time": time_s}
    for output in outputs:
        integer = output.tag == "Enumeration"
        value: ctypes.c_int64 | ctypes.c_double = ctypes.c_int64() if integer else ctypes.c_double()
        get = library.fmi3GetInt64 if integer else library.fmi3GetFloat64
        reference, one = ctypes.c_uint32(output.reference), ctypes.c_size_t(1)
        check(get(instance, ctypes.byref(reference), one, ctypes.byref(value), one), output.name)
        row[output.name] = value.value
    return row


def run(path: Path, root: ET.Element) -> list[Row]:
    """Outputs of the default experiment every OUTPUT_INTERVAL_S.

    Raises:
        RuntimeError: a call fails.
    """
    experiment = root.find("DefaultExperiment")
    assert experiment is not None
    start, stop, step = (float(experiment.attrib[k]) for k in ("startTime", "stopTime", "stepSize"))
    outputs = [v for v in read_variables(root) if v.causality == "output"]
    library = ctypes.CDLL(str(path))
    library.fmi3InstantiateCoSimulation.restype = ctypes.c_void_p
    token = root.attrib["instantiationToken"].encode()
    instance = ctypes.c_void_p(
        library.fmi3InstantiateCoSimulation(
            b"reference", token, None, *[False] * 4, None, ctypes.c_size_t(0), *[None] * 3
        )
    )
    if not instance:
        raise RuntimeError("fmi3InstantiateCoSimulation: no instance")
    real = ctypes.c_double
    check(
        library.fmi3EnterInitializationMode(instance, False, real(0), real(start), True, real(stop)),
        "fmi3EnterInitializationMode",
    )
    check(library.fmi3ExitInitializationMode(instance), "fmi3ExitInitializationMode")
    rows = [read_row(library, instance, outputs, start)]
    every = round(OUTPUT_INTERVAL_S / step)
    flags = (ctypes.c_bool * 3)()
    last = real()
    for k in range(round((stop - start) / step)):
        pointers = [ctypes.byref(flags, i) for i in range(3)]
        status = library.fmi3DoStep(instance, real(start + k * step), real(step), False, *pointers, ctypes.byref(last))
        check(status, "fmi3DoStep")
        if (k + 1) % every == 0:
            rows.append(read_row(library, instance, outputs, start + (k + 1) * step))
    check(library.fmi3Terminate(instance), "fmi3Terminate")
    library.fmi3FreeInstance(instance)
    return rows


def csv_text(rows: list[Row]) -> str:
    """Comma-separated table with full precision."""
    lines = [",".join(f'"{name}"' for name in rows[0])]
    lines += [",".join(repr(value) for value in row.values()) for row in rows]
    return "\n".join(lines) + "\n"


def polyline(points: list[tuple[float, float]], colour: str, width: float) -> str:
    """SVG polyline."""
    text = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    return f'<polyline points="{text}" fill="none" stroke="{colour}" stroke-width="{width}" stroke-linejoin="round"/>'


def stick_figures(rows: list[Row], axis: int, left: float, title: str) -> list[str]:
    """Arm at nine instants, seen along the other horizontal axis; axis 1 = x, 2 = y. 300 pixels a metre."""

    def place(row: Row, joint: str) -> tuple[float, float]:
        x, z = (row[f"{joint}[{axis}]"], row[f"{joint}[3]"]) if joint else (0.0, 0.0)
        return left + 90 + 300 * x, 150 - 300 * z

    moving = [row for row in rows if row["progress"] < 1] + [row for row in rows if row["progress"] >= 1][:1]
    shown = [moving[round(k * (len(moving) - 1) / 8)] for k in range(9)]
    parts = [f'<text x="{left + 10}" y="20" font-size="13">{title}</text>']
    for k, row in enumerate(shown):
        colour = f"hsl(174,60%,{80 - 6 * k}%)"
        parts.append(polyline([place(row, j) for j in ("", "shoulder", "elbow", "wrist")], colour, 2.5))
    parts.append(polyline([place(row, "wrist") for row in moving], "#ef6c00", 1.5))
    return parts


def picture_svg(rows: list[Row]) -> str:
    """The reach from the front and from the side, and the arm angles over time."""
    parts = stick_figures(rows, 1, 0, "front view: x, z") + stick_figures(rows, 2, 280, "side view: y, z")
    end, low, high = rows[-1]["time"], -2.0, 2.5
    for k, (name, colour) in enumerate(
        zip(("theta", "eta", "zeta", "phi"), ("#00695c", "#ef6c00", "#5e35b1", "#546e7a"), strict=True)
    ):
        curve = [(600 + 260 * r["time"] / end, 290 - 250 * (r[f"q[{k + 1}]"] - low) / (high - low)) for r in rows]
        parts.append(polyline(curve, colour, 1.8))
        parts.append(f'<text x="{610 + 62 * k}" y="40" font-size="13" fill="{colour}">{name}</text>')
    parts.append('<path d="M600 40 V290 H860" fill="none" stroke="#999"/>')
    parts.append(f'<text x="600" y="20" font-size="13">angles, {low:g} .. {high:g} rad, over {end:g} s</text>')
    body = "\n  ".join(parts)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 880 310" font-family="sans-serif">\n  {body}\n</svg>\n'
    )
