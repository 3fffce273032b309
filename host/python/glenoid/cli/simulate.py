"""`glenoid simulate`: the same reach through the FMU."""

from __future__ import annotations

import sys
from dataclasses import replace
from typing import Annotated, Literal

import typer

from glenoid.cli import options as opt
from glenoid.cli.plan import plan_with_device, write_outputs
from glenoid.devices import load_device
from glenoid.exo import DeviceMotion
from glenoid.fmus import fmu_path, sha256
from glenoid.inputs import InputError, ReachInput
from glenoid.reach import REFUSALS, Reach
from glenoid.report import Printer, degrees, metres, two_columns
from glenoid.simulate import Simulation, difference_from_core
from glenoid.simulate import simulate as run_fmu
from glenoid.tables import device_columns, motion_columns, to_text, write_csv

NAMES = (
    "q_rad",
    "dq_rad_per_s",
    "ddq_rad_per_s2",
    "shoulder_m",
    "elbow_m",
    "wrist_m",
    "swivel_rad",
    "progress",
    "exo_q_rad",
    "exo_dq_rad_per_s",
    "exo_residual_m",
)


#: whose rows fit into memory; a minute at the least step is six times as many
MOST_STEPS = 1_000_000


@opt.of_a_reach
def simulate(
    asked: opt.Asked,
    exo: opt.ExoName = None,
    fmi: Annotated[Literal["2", "3"], typer.Option(help="Version of FMI.")] = "3",
    step_s: Annotated[float, opt.quantity("--step-s", "Communication step, 1e-5..10 s.", 1e-5, 10.0)] = 0.01,
    stop_s: Annotated[
        float | None, opt.quantity("--stop-s", "End, 0..3600 s; else 0.2 s after the movement.", 0.0, 3600.0)
    ] = None,
    as_json: opt.AsJson = False,
    csv: opt.CsvFile = None,
    plot: opt.PlotFile = None,
) -> None:
    """Run a reach through the FMU with FMPy and compare it with the core.

    Example: glenoid simulate host/examples/reach_to_head.yaml --fmi 2 --csv reach.csv
    """
    given = asked.reach
    end_s = stop_s if stop_s is not None else given.duration_s + 0.2
    if end_s / step_s > MOST_STEPS:
        raise InputError(f"--step-s = {step_s:g} s: {end_s / step_s:.0f} steps to {end_s:g} s, at most {MOST_STEPS}")
    device = load_device(exo) if exo is not None else None
    done = run_fmu(given, fmu_path(fmi), step_s, end_s, device)
    difference = difference_from_core(given, done, device)
    if csv is not None:
        columns = motion_columns(done.time_s, done.samples)
        write_csv(columns | (device_columns(done.samples) if device is not None else {}), csv)
    if plot is not None and done.status not in REFUSALS:
        planned, motion = with_plan(given, exo, done)
        write_outputs(planned, None, plot, motion)
    if as_json:
        print(to_text(simulation_to_json(done, difference)))
    else:
        print_simulation(done, difference)
    if done.status in REFUSALS:
        print("\n".join(f"glenoid: REFUSED  {text}" for text in done.messages), file=sys.stderr)
        raise typer.Exit(1)


def with_plan(given: ReachInput, exo: str | None, done: Simulation) -> tuple[Reach, DeviceMotion | None]:
    """The plan with its family and device, as the pictures want it, over the FMU's own motion."""
    planned, motion = plan_with_device(given, 100.0, exo)
    return replace(planned, time_s=done.time_s, samples=done.samples), motion


def simulation_to_json(done: Simulation, difference_rad: float) -> dict[str, object]:
    """A simulation as plain data."""
    out: dict[str, object] = {
        "fmu": done.fmu.name,
        "sha256": sha256(done.fmu),
        "fmi_version": done.fmi_version,
        "status": done.status,
        "largest_difference_from_core_rad": difference_rad,
        "time_s": done.time_s.tolist(),
    }
    return out | {name: done.samples[name].tolist() for name in NAMES}


def print_simulation(done: Simulation, difference_rad: float) -> None:
    """The end of a simulation for people."""
    table = two_columns()
    table.add_row("FMU", f"{done.fmu} (FMI {done.fmi_version})")
    table.add_row("steps", f"{len(done.time_s) - 1} to {done.time_s[-1]:.3f} s")
    table.add_row("status at end", done.status)
    table.add_row("posture at end (deg)", degrees(done.samples["q_rad"][-1]))
    table.add_row("wrist at end (m)", metres(done.samples["wrist_m"][-1]))
    table.add_row("largest difference from core", f"{difference_rad:.1e} rad")
    Printer().print(table)
