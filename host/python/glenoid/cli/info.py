"""`glenoid info`: what this installation has, and how a subject is scaled."""

from __future__ import annotations

import json
from typing import Annotated, Any, Literal

import numpy as np
import typer
from pydantic import BaseModel
from rich.console import Console
from rich.table import Table

from glenoid import _core
from glenoid.cli import options as opt
from glenoid.fmus import FILES, fmu_folder, sha256
from glenoid.inputs import InputError, ReachInput, SubjectInput, load_subject
from glenoid.report import two_columns
from glenoid.settings import core_subject

SCHEMAS: dict[str, type[BaseModel]] = {"reach": ReachInput, "subject": SubjectInput}


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


def scaling_report(subject: SubjectInput) -> list[dict[str, Any]]:
    """Every figure of a person's arm with its source. InputError if the core refuses one."""
    try:
        scaled = _core.scale_subject(core_subject(subject))
    except ValueError as error:
        raise InputError(f"subject: {error}") from error
    return [{"name": e.name, "value": e.value, "unit": e.unit, "source": e.source} for e in scaled.report]


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
        "swivel_modes": {name: swivel_available(name) for name in ("MinimumEnergy", "Prescribed", "HumanPrior")},
        "subject": {"name": subject.name, "arm": subject.arm, "scaling": scaling_report(subject)},
        "limits_deg": {
            name: list(np.asarray(value, dtype=float)) for name, value in subject.limits_deg.model_dump().items()
        },
    }


def info(
    subject: opt.SubjectFile = None,
    schema: Annotated[Literal["reach", "subject"] | None, typer.Option(help="Print the JSON schema of a file.")] = None,
    as_json: opt.AsJson = False,
) -> None:
    """Show version, FMUs with their hashes, models, and which figure of a subject came from where."""
    if schema is not None:
        print(json.dumps(SCHEMAS[schema].model_json_schema(), indent=2))
        return
    data = gather(load_subject(subject) if subject is not None else SubjectInput())
    if as_json:
        print(json.dumps(data, allow_nan=False))
    else:
        print_info(Console(), data)


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
    for name, (lower, upper) in data["limits_deg"].items():
        table.add_row(f"limit {name}", f"{lower:g} .. {upper:g} deg")
    console.print(table, highlight=False)
    scaling = Table("figure", "value", "unit", "source", box=None, pad_edge=False, title_justify="left")
    for entry in data["subject"]["scaling"]:
        scaling.add_row(entry["name"], f"{entry['value']:.5g}", entry["unit"], entry["source"])
    console.print(f"\n[bold]Subject {data['subject']['name']}[/bold] ({data['subject']['arm']} arm)", highlight=False)
    console.print(scaling, highlight=False)
