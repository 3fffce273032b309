"""`glenoid sweep`: a population study."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Annotated

import typer

from glenoid.cli.options import AsJson, quantity, whole_number
from glenoid.report import Printer
from glenoid.sweep.report import print_summary, summarise, write_rows
from glenoid.sweep.run import run_study
from glenoid.sweep.study import load_study
from glenoid.tables import to_text


def sweep(
    study: Annotated[Path, typer.Argument(help="Study as YAML (docs/sweep.md).", metavar="FILE.yaml")],
    out: Annotated[
        Path | None, typer.Option("--out", help="Folder of the results; default build/sweeps/NAME OF THE FILE.")
    ] = None,
    jobs: Annotated[
        int | None,
        quantity("--jobs", "Processes, 1..1024; default one for each processor.", 1, 1024, whole_number),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Plan many reaches: persons, tasks and devices, fixed or drawn; which are possible, and which ranges they need.

    Leaves cases.csv with a row for every case and summary.json. A refused reach is a result, no error.

    Example: glenoid sweep host/examples/sweep_shoulder_ranges.yaml
    """
    checked = load_study(study)
    folder = out if out is not None else Path("build/sweeps") / study.stem
    workers = jobs if jobs is not None else len(os.sched_getaffinity(0))
    folder.mkdir(parents=True, exist_ok=True)
    written = folder / "summary.json"
    written.unlink(
        missing_ok=True
    )  # of an earlier study: it is written last, so that rows without it are known as cut short
    summary = summarise(checked, list(write_rows(run_study(checked, workers), checked, folder / "cases.csv")))
    written.write_text(json.dumps(summary, indent=2, allow_nan=False) + "\n", encoding="utf-8")
    if as_json:
        print(to_text(summary))
    else:
        console = Printer()
        print_summary(console, summary)
        console.print(f"rows: {folder / 'cases.csv'}", soft_wrap=True)
