"""`glenoid plan`: one reach, or many."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from glenoid.batch import read_tasks, run_batch
from glenoid.cli import options as opt
from glenoid.inputs import InputError, ReachInput
from glenoid.reach import Reach, plan_reach, verify
from glenoid.report import print_reach
from glenoid.tables import motion_columns, reach_to_json, to_text, write_csv


def plan(
    reach: opt.ReachFile = None,
    subject: opt.SubjectFile = None,
    start_deg: opt.StartDeg = None,
    start_rad: opt.StartRad = None,
    target: opt.Target = None,
    duration: opt.Duration = None,
    rhythm: opt.Rhythm = None,
    gain: opt.Gain = None,
    smoothing: opt.Smoothing = None,
    metric: opt.Metric = None,
    swivel: opt.Swivel = None,
    swivel_rad: opt.SwivelRad = None,
    timing: opt.Timing = None,
    limits: opt.Limits = None,
    rate_hz: Annotated[float, typer.Option("--rate-hz", min=1.0, max=1e5, help="Samples per second.")] = 100.0,
    check: Annotated[bool, typer.Option("--verify", help="Shoot the path with CVODE; exit 1 if it misses.")] = False,
    batch: Annotated[Path | None, typer.Option(help="JSON list of tasks; prints a JSON list of answers.")] = None,
    as_json: opt.AsJson = False,
    csv: opt.CsvFile = None,
    plot: opt.PlotFile = None,
) -> None:
    """Plan a reach: posture and wrist target in, human-like motion and its certificate out.

    Example: glenoid plan host/examples/reach_to_head.yaml --verify --plot reach.png
    """
    given = opt.assemble(
        reach,
        subject,
        limits,
        opt.reach_options(
            start_deg=start_deg,
            start_rad=start_rad,
            target=target,
            duration=duration,
            rhythm=rhythm,
            gain=gain,
            smoothing=smoothing,
            metric=metric,
            swivel=swivel,
            swivel_rad=swivel_rad,
            timing=timing,
        ),
    )
    if batch is not None:
        plan_batch(batch, given, check or csv is not None or plot is not None)
        return
    planned = plan_reach(given, rate_hz)
    verification = verify(planned) if check and planned.ok else None
    write_outputs(planned, csv, plot)
    if as_json:
        print(to_text(reach_to_json(planned, verification)))
    else:
        print_reach(Console(), planned, verification)
    if not planned.ok or (verification is not None and not verification.passed):
        raise typer.Exit(1)


def plan_batch(tasks: Path, common: ReachInput, single_only: bool) -> None:
    """Prints the answers to a list of tasks; refused tasks carry their status and are no error of the command."""
    if single_only:
        raise InputError("--batch: --verify, --csv and --plot are for a single reach")
    print(to_text(run_batch(read_tasks(tasks), common)))


def write_outputs(planned: Reach, csv: Path | None, plot: Path | None) -> None:
    """The files asked for, if there is a motion."""
    if not planned.ok:
        return
    try:
        if csv is not None:
            write_csv(motion_columns(planned.time_s, planned.samples), csv)
        if plot is not None:
            from glenoid.plot import draw_reach

            draw_reach(planned, plot)
    except OSError as error:
        raise InputError(f"{error.filename}: {error.strerror}") from error
