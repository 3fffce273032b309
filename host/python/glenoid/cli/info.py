"""`glenoid info`: what this installation has, and how a subject is scaled."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import typer
from pydantic import BaseModel
from rich.console import Console

from glenoid import _core
from glenoid.cli import options as opt
from glenoid.device_report import device_to_json, print_device, print_scaling, scaling_report
from glenoid.device_schema import device_schema
from glenoid.devices import device_names, load_device
from glenoid.fmus import FILES, fmu_folder, sha256
from glenoid.inputs import InputError, ReachInput, SubjectInput, load_subject
from glenoid.report import Printer, two_columns
from glenoid.settings import check_subject
from glenoid.sweep.study import Study

SCHEMAS: dict[str, type[BaseModel]] = {"reach": ReachInput, "subject": SubjectInput, "study": Study}
SchemaName = Literal["reach", "subject", "exoskeleton", "study"]


def rhythm_available(name: str) -> bool:
    """Whether this version has the rhythm."""
    settings = _core.RhythmSettings()
    settings.model = getattr(_core.RhythmModel, name)
    try:
        _core.Rhythm(settings, 0.17)
    except ValueError:
        return False
    return True


def swivel_available(name: str) -> bool:
    """Whether this version has the choice of the final posture."""
    settings = _core.MotionSettings()
    settings.swivel_mode = getattr(_core.SwivelMode, name)
    try:
        _core.MotionGenerator(settings)
    except ValueError:
        return False
    return True


def gather(subject: SubjectInput) -> dict[str, Any]:
    """Everything that the command tells."""
    folder = fmu_folder()
    fmus = [
        {
            "fmi": version,
            "path": str(folder / name),
            "sha256": sha256(folder / name) if (folder / name).is_file() else None,
        }
        for version, name in FILES.items()
    ]
    return {
        "version": _core.version,
        "fmus": fmus,
        "rhythms": {name: rhythm_available(name) for name in ("Fixed", "SoltaniZarrin2017", "Measured")},
        "exoskeletons": device_names(),
        "swivel_modes": {name: swivel_available(name) for name in ("MinimumEnergy", "Prescribed", "HumanPrior")},
        "subject": {"name": subject.name, "arm": subject.arm, "scaling": scaling_report(subject)},
        "limits_deg": {
            name: list(np.asarray(value, dtype=float)) for name, value in subject.limits_deg.model_dump().items()
        },
    }


def info(
    subject: opt.SubjectFile = None,
    exo: opt.ExoName = None,
    schema: Annotated[SchemaName | None, typer.Option(help="Print the JSON schema of a file.")] = None,
    plot: Annotated[
        Path | None, typer.Option("--plot", callback=opt.picture, help="With --exo: draw the axes (.png, .svg, .pdf).")
    ] = None,
    as_json: opt.AsJson = False,
) -> None:
    """Show version, FMUs, models, and which figure of a subject, or with --exo of a device, came from where."""
    if schema is not None:
        found = device_schema() if schema == "exoskeleton" else SCHEMAS[schema].model_json_schema()
        print(json.dumps(found, indent=2))
        return
    if plot is not None and exo is None:
        raise InputError("--plot: draws the axes of a device; give it with --exo")
    person = load_subject(subject) if subject is not None else SubjectInput()
    check_subject(person)
    if exo is not None:
        show_device(exo, person, plot, as_json)
        return
    data = gather(person)
    if as_json:
        print(json.dumps(data, allow_nan=False))
    else:
        print_info(Printer(), data)
        print_scaling(Printer(), person)


def show_device(exo: str, person: SubjectInput, plot: Path | None, as_json: bool) -> None:
    """One device: figures, coverage of the person's postures, and a picture of its axes."""
    device = load_device(exo)
    if plot is not None:
        from glenoid.device_plot import draw_axes

        draw_axes(device, plot)
    if as_json:
        print(json.dumps(device_to_json(device, person), allow_nan=False))
    else:
        print_device(Printer(), device, person)


def names(available: dict[str, bool]) -> str:
    """Models of a kind; those that this version lacks are marked."""
    return ", ".join(name if there else f"({name}: not in this version)" for name, there in available.items())


def print_info(console: Console, data: dict[str, Any]) -> None:
    """The same for people."""
    table = two_columns()
    table.add_row("glenoid", data["version"])
    for fmu in data["fmus"]:
        table.add_row(f"FMI {fmu['fmi']}", fmu["path"])
        table.add_row("", f"sha256 {fmu['sha256']}" if fmu["sha256"] else "not built")
    table.add_row("rhythms", names(data["rhythms"]))
    table.add_row("swivel modes", names(data["swivel_modes"]))
    table.add_row("exoskeletons", ", ".join(data["exoskeletons"]))
    for name, (lower, upper) in data["limits_deg"].items():
        table.add_row(f"limit {name}", f"{lower:g} .. {upper:g} deg")
    console.print(table)
