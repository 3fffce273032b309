"""`glenoid plan`: one reach, or many."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from glenoid.batch import read_tasks, run_batch
from glenoid.cli import options as opt
from glenoid.device_report import print_motion, print_scaling, scaling_report
from glenoid.devices import JOINTS, load_device
from glenoid.exo import DeviceMotion, core_exo, follow
from glenoid.inputs import InputError, ReachInput
from glenoid.reach import Reach, Verification, plan_reach, verify
from glenoid.report import Printer, print_reach
from glenoid.tables import device_columns, motion_columns, reach_to_json, to_text, write_csv


@opt.of_a_reach
def plan(
    asked: opt.Asked,
    exo: opt.ExoName = None,
    rate_hz: Annotated[float, opt.quantity("--rate-hz", "Samples per second, 1..1e5 Hz.", 1.0, 1e5)] = 100.0,
    check: Annotated[bool, typer.Option("--verify", help="Shoot the path with CVODE; exit 1 if it misses.")] = False,
    batch: Annotated[Path | None, typer.Option(help="JSON list of tasks; prints a JSON list of answers.")] = None,
    as_json: opt.AsJson = False,
    csv: opt.CsvFile = None,
    plot: opt.PlotFile = None,
) -> None:
    """Plan a reach: posture and wrist target in, human-like motion and its certificate out.

    With `--exo` the device's joints too; exit 1 says where and by how much it cannot follow.

    Example: glenoid plan host/examples/reach_to_head.yaml --exo generic_75_75 --verify --plot reach.png
    """
    given = asked.reach
    if batch is not None:
        plan_batch(batch, given, exo, check or csv is not None or plot is not None)
        return
    planned, motion = plan_with_device(given, rate_hz, exo)
    verification = verify(planned) if check and planned.ok else None
    write_outputs(planned, csv, plot, motion)
    if as_json:
        data = reach_to_json(planned, verification) | {"subject": {"scaling": scaling_report(given.subject)}}
        print(to_text(data | ({"exo": device_motion_to_json(planned, motion)} if motion is not None else {})))
    else:
        print_everything(planned, verification, motion, asked.subject_file is not None)
    if not planned.ok or (verification is not None and not verification.passed):
        raise typer.Exit(1)


def plan_batch(tasks: Path, common: ReachInput, exo: str | None, single_only: bool) -> None:
    """Prints the answers to a list of tasks; refused tasks carry their status and are no error of the command."""
    if single_only:
        raise InputError("--batch: --verify, --csv and --plot are for a single reach")
    print(to_text(run_batch(read_tasks(tasks), common, load_device(exo) if exo is not None else None)))


def plan_with_device(given: ReachInput, rate_hz: float, exo: str | None) -> tuple[Reach, DeviceMotion | None]:
    """The reach, and how the device follows it; a reach that the device refuses has no motion."""
    if exo is None:
        return plan_reach(given, rate_hz), None
    device = load_device(exo)
    settings = core_exo(device, given.subject)
    planned = plan_reach(given, rate_hz, settings)
    if not planned.ok:
        return planned, None
    arm, path = planned.generator.arm, planned.generator.path
    motion = follow(device, settings, arm, path, np.array(given.start_rad), planned.samples["progress"])
    extra = {"exo_margin_rad": motion.margin_rad, "exo_singularity_rad": motion.singularity_rad}
    return replace(planned, samples=planned.samples | extra), motion


def device_motion_to_json(planned: Reach, motion: DeviceMotion) -> dict[str, Any]:
    """The device's joints as plain data."""
    names = [name for name in planned.samples if name.startswith("exo_")]
    return motion.summary(planned.samples) | {
        "joints": list(JOINTS),
        "motion": {name: planned.samples[name].tolist() for name in names},
    }


def print_everything(
    planned: Reach, verification: Verification | None, motion: DeviceMotion | None, subject_given: bool
) -> None:
    """Reach, device and, for a subject from a file, where its figures come from."""
    console = Printer()
    print_reach(console, planned, verification)
    if motion is not None:
        print_motion(console, motion, planned.samples)
    if subject_given:
        print_scaling(console, planned.given.subject)


def write_outputs(planned: Reach, csv: Path | None, plot: Path | None, motion: DeviceMotion | None = None) -> None:
    """The files asked for, if there is a motion."""
    if not planned.ok:
        return
    if csv is not None:
        columns = motion_columns(planned.time_s, planned.samples)
        write_csv(columns | (device_columns(planned.samples) if motion is not None else {}), csv)
    if plot is not None:
        from glenoid.plot import draw_reach

        draw_reach(planned, plot)
    if plot is not None and motion is not None:
        from glenoid.device_plot import draw_motion

        draw_motion(planned, motion, plot.with_stem(plot.stem + "_exo"))
