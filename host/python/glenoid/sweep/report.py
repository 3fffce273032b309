"""What a study says in the end: how many cases are possible, and which ranges they need."""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table
from rich.text import Text

from glenoid.devices import JOINTS
from glenoid.sweep.run import FIGURES, Row
from glenoid.sweep.study import Study

PLACES = ("case", "group", "task", "draw", "exo")
VERDICT = ("status", "exo_refusal", "message", "hessian_positive")
SHARES = {"least": 0, "p05": 5, "median": 50, "p95": 95, "most": 100}
NO_DEVICE = "(arm alone)"


def columns_of(study: Study) -> list[str]:
    """Columns of cases.csv: which case, what was varied, verdict, figures."""
    varied = {key: None for section in (study.groups, study.tasks) for variant in section.values() for key in variant}
    return [*PLACES, *varied, *VERDICT, *FIGURES]


def text_of(value: Any) -> Any:
    """A point or posture in one cell, with blanks between."""
    return " ".join(map(repr, value)) if isinstance(value, (list, tuple)) else value


def write_rows(rows: Iterable[Row], study: Study, path: Path) -> Iterator[Row]:
    """Passes the rows through and writes each as it comes; what a row lacks is empty."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, columns_of(study), restval="")
        writer.writeheader()
        for row in rows:
            writer.writerow({key: text_of(value) for key, value in row.items()})
            yield row


def distribution(values: list[float]) -> dict[str, float]:
    """Least, 5 %, median, 95 %, most."""
    return dict(zip(SHARES, np.percentile(values, list(SHARES.values())).tolist(), strict=True))


def part(rows: list[Row]) -> dict[str, Any]:
    """Counts of every status and refusal, and the figures of the cases that are possible."""
    done = [row for row in rows if row["status"] == "ok"]
    known = {key: [row[key] for row in done if key in row] for key in FIGURES}
    return {
        "cases": len(rows),
        "status": dict(sorted(Counter(row["status"] for row in rows).items())),
        "exo_refusal": dict(sorted(Counter(row["exo_refusal"] for row in rows if row.get("exo_refusal")).items())),
        "figures": {key: distribution(values) for key, values in known.items() if values},
    }


def summarise(study: Study, rows: list[Row]) -> dict[str, Any]:
    """A part for every device, and within it for every group and task."""
    devices = {}
    for exo in study.exoskeletons or ("",):
        mine = [row for row in rows if row["exo"] == exo]
        devices[exo or NO_DEVICE] = part(mine) | {
            "groups": {name: part([row for row in mine if row["group"] == name]) for name in study.groups},
            "tasks": {name: part([row for row in mine if row["task"] == name]) for name in study.tasks},
        }
    return {"name": study.name, "seed": study.seed, "cases": len(rows), "devices": devices}


def print_summary(console: Console, summary: dict[str, Any]) -> None:
    """The same for people, in deg and mm."""
    console.print(Text.assemble((summary["name"] or "Study", "bold"), f"  {summary['cases']} cases"))
    for name, device in summary["devices"].items():
        print_device(console, name, device)


def print_device(console: Console, name: str, device: dict[str, Any]) -> None:
    """Counts by group and task, then ranges."""
    counts = Table(name, "cases", "possible", "refused because", box=None, pad_edge=False)
    parts = [("all", device), *device["groups"].items(), *device["tasks"].items()]
    for label, one in parts:
        reasons = {key: count for key, count in one["status"].items() if key not in ("ok", "ExoInfeasible")}
        words = ", ".join(f"{key} {count}" for key, count in (reasons | one["exo_refusal"]).items())
        share = 100.0 * one["status"].get("ok", 0) / one["cases"]
        counts.add_row(label, str(one["cases"]), f"{share:.1f} %", words)
    console.print(counts)
    figures = device["figures"]
    table = Table("of the possible ones", *SHARES, box=None, pad_edge=False)
    for label, key, factor in lines_of(figures):
        table.add_row(label, *(f"{factor * figures[key][share]:.1f}" for share in SHARES))
    console.print(table)


def lines_of(figures: dict[str, Any]) -> list[tuple[str, str, float]]:
    """Label, figure and factor to the unit of the label, of those that there are."""
    degrees = float(np.rad2deg(1.0))
    lines = [
        ("swivel angle at the end, deg", "swivel_rad", degrees),
        ("nearest joint limit of the person, deg", "limit_margin_rad", degrees),
        ("shoulder centre moves, mm", "misalignment_m", 1e3),
        ("girdle residual, mm", "exo_residual_m", 1e3),
        ("edge of reach, deg", "exo_margin_rad", degrees),
        ("singular, deg", "exo_singularity_rad", degrees),
    ]
    for joint in JOINTS:
        lines += [(f"{joint} {end}, deg", f"exo_{joint}_{end}_rad", degrees) for end in ("least", "most")]
        lines.append((f"{joint} peak, deg/s", f"exo_{joint}_peak_rad_per_s", degrees))
    return [line for line in lines if line[1] in figures]
