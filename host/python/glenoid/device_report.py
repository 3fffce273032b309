"""What the commands print about devices and subjects, for people."""

from __future__ import annotations

from collections import Counter
from dataclasses import asdict
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table
from rich.text import Text

from glenoid import _core
from glenoid.device_geometry import axes_of, geometry
from glenoid.device_link import fingerprint
from glenoid.devices import JOINTS, Device
from glenoid.exo import Coverage, DeviceMotion, coverage
from glenoid.inputs import InputError, SubjectInput
from glenoid.reach import Array
from glenoid.report import two_columns
from glenoid.settings import core_subject


def scaling_report(subject: SubjectInput) -> list[dict[str, Any]]:
    """Every figure of a person's arm with its source. InputError if the core refuses one."""
    try:
        scaled = _core.scale_subject(core_subject(subject))
    except ValueError as error:
        raise InputError(f"subject: {error}") from error
    return [{"name": e.name, "value": e.value, "unit": e.unit, "source": e.source} for e in scaled.report]


def print_scaling(console: Console, subject: SubjectInput) -> None:
    """Which figure of a person came from where, and how many were not measured."""
    entries = scaling_report(subject)
    given = sum("given" in entry["source"] for entry in entries)
    console.print(Text.assemble("\n", (f"Subject {subject.name}", "bold"), f" ({subject.arm} arm)"))
    if given < len(entries):
        rest = f"  {len(entries) - given} of {len(entries)} figures are not this person's own: they come from the tables named below"
        console.print(Text.assemble(("SCALED", "bold yellow"), rest), soft_wrap=True)
    table = Table("figure", "value", "unit", "source", box=None, pad_edge=False, title_justify="left")
    for entry in entries:
        style = None if "given" in entry["source"] else "yellow"
        table.add_row(entry["name"], f"{entry['value']:.5g}", entry["unit"], entry["source"], style=style)
    console.print(table)


def device_to_json(device: Device, subject: SubjectInput) -> dict[str, Any]:
    """A device as plain data; fingerprint, axes and coverage are null for a template."""
    figures = [{"key": f.key, "value": f.value, "status": f.status, "source": f.source} for f in device.figures]
    out: dict[str, Any] = {
        "name": device.data.name,
        "file": str(device.path),
        "side": device.data.side,
        "note": device.data.note,
        "figures": figures,
        "missing": [figure.key for figure in device.missing],
        "device_sha256": None,
        "axes": None,
        "coverage": None,
    }
    if not device.missing:
        out["device_sha256"] = fingerprint(device)
        out["axes"] = axes_of(device.data.shoulder).tolist()
        out["coverage"] = asdict(coverage(device, subject))
    return out


def value_text(value: Any) -> str:
    """A figure's value in one line."""
    if isinstance(value, dict):
        return ", ".join(f"{key} {item}" for key, item in value.items())
    return str(value)


def print_device(console: Console, device: Device, subject: SubjectInput) -> None:
    """Figures with their statuses, and the coverage of a person's postures. InputError before anything is printed."""
    data = device.data
    share = None if device.missing else coverage(device, subject)
    console.print(Text.assemble((data.name, "bold"), f"  {data.note}"), soft_wrap=True)
    table = Table("figure", "value", "status", "source", box=None, pad_edge=False)
    for figure in device.figures:
        style = "bold red" if figure in device.missing else None
        table.add_row(figure.key, value_text(figure.value), figure.status, figure.source, style=style)
    console.print(table)
    counts = Counter(figure.status for figure in device.figures)
    console.print("  ".join(f"{name}: {count}" for name, count in sorted(counts.items())))
    if share is None:
        console.print(
            Text.assemble(("TEMPLATE", "bold red"), "  nothing is planned before the red figures are filled in")
        )
        return
    print_coverage(console, device, share)
    console.print(f"fingerprint {fingerprint(device)} (what a bridge is told to drive)", soft_wrap=True)


def print_coverage(console: Console, device: Device, share: Coverage) -> None:
    """Shares of a person's postures."""
    a1, a2, a3 = geometry(device).axes
    table = two_columns()
    angles = (np.rad2deg(np.arccos(np.clip(first @ second, -1, 1))) for first, second in ((a1, a2), (a2, a3)))
    table.add_row("angles between axes", "  ".join(f"{angle:.1f} deg" for angle in angles))
    table.add_row("postures", f"{share.samples} random ones, uniform within the person's limits")
    table.add_row("reached by T", f"{100 * share.reached:.1f} %")
    table.add_row("with 10 deg margin", f"{100 * share.with_margin:.1f} %")
    table.add_row("also within the joint ranges", f"{100 * share.within_ranges:.1f} %")
    table.add_row("nearer than 5 deg to singular", f"{100 * share.near_singular:.1f} % of those reached")
    console.print(Text("Coverage", "bold"))
    console.print(table)


def print_motion(console: Console, motion: DeviceMotion, samples: dict[str, Array]) -> None:
    """The joints of a device at both ends, and its worst moments."""
    found = motion.summary(samples)
    table = Table("joint", "start deg", "end deg", "least", "most", "range deg", "peak deg/s", box=None, pad_edge=False)
    q, dq = np.rad2deg(samples["exo_q_rad"]), np.rad2deg(samples["exo_dq_rad_per_s"])
    for k, name in enumerate(JOINTS):
        bounds = np.rad2deg([motion.settings.lower_rad[k], motion.settings.upper_rad[k]])
        stated = "not stated" if abs(bounds[0]) > 1e9 else f"{bounds[0]:.0f} .. {bounds[1]:.0f}"
        figures = (q[0, k], q[-1, k], q[:, k].min(), q[:, k].max())
        table.add_row(name, *(f"{value:.1f}" for value in figures), stated, f"{np.abs(dq[:, k]).max():.1f}")
    console.print(Text(f"Exoskeleton {motion.device.data.name}", "bold"))
    console.print(table)
    lines = two_columns()
    lines.add_row("least distance to the edge of reach", f"{np.rad2deg(found['least_margin_rad']):.1f} deg")
    lines.add_row("least distance to singular", f"{np.rad2deg(found['least_singularity_rad']):.1f} deg")
    lines.add_row("girdle residual", f"{found['largest_residual_mm']:.1f} mm (what the girdle drives cannot follow)")
    lines.add_row("misalignment if the shoulder were fixed", f"{found['largest_misalignment_mm']:.1f} mm")
    console.print(lines)
