"""Options that several commands share, and the reach they describe together."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer

from glenoid.inputs import InputError, ReachInput, build_reach, laid_over, load_subject, merged, read_mapping

PICTURES = (".png", ".svg", ".pdf")
UNITS = ("-s", "-rad", "-hz")


def picture(path: Path | None) -> Path | None:
    """The path of a picture. InputError for a format that is not drawn, before anything else is done."""
    if path is not None and path.suffix.lower() not in PICTURES:
        raise InputError(f"picture {str(path)!r}: must end in {', '.join(PICTURES)}")
    return path


def number(text: str) -> float:
    """A number of an option. ValueError for words."""
    try:
        return float(text)
    except ValueError:
        raise ValueError(f"= {text!r}: must be a number") from None


def whole_number(text: str) -> int:
    """A whole number of an option. ValueError for anything else."""
    try:
        return int(text)
    except ValueError:
        raise ValueError(f"= {text!r}: must be a whole number") from None


def within(least: float, most: float) -> Callable[[typer.CallbackParam, float | None], float | None]:
    """A callback that refuses what is not in a range, and NaN; the option's name says the unit."""

    def check(option: typer.CallbackParam, value: float | None) -> float | None:
        if value is not None and not least <= value <= most:
            name = option.opts[0]
            unit = f" {name.rpartition('-')[2]}" if name.endswith(UNITS) else ""
            raise InputError(f"{name} = {value:g}{unit}: must be {least:g} to {most:g}{unit}")
        return value

    return check


def quantity(
    name: str,
    help_text: str,
    least: float = -math.inf,
    most: float = math.inf,
    parser: Callable[[str], float] = number,
) -> Any:
    """An option that takes a number; where the range is given here, NaN and what lies outside are refused."""
    check = within(least, most) if math.isfinite(most - least) else None
    return typer.Option(name, parser=parser, callback=check, metavar="NUMBER", help=help_text)


ReachFile = Annotated[Path | None, typer.Argument(help="Reach as YAML (host/examples); options go over it.")]
SubjectFile = Annotated[Path | None, typer.Option("--subject", help="Subject as YAML (host/subjects).")]
StartDeg = Annotated[str | None, typer.Option("--start-q-deg", help="Start posture theta,eta,zeta,phi in deg.")]
StartRad = Annotated[str | None, typer.Option("--start-q-rad", help="Start posture theta,eta,zeta,phi in rad.")]
Target = Annotated[str | None, typer.Option("--target-m", help="Wrist target x,y,z in the thorax frame, m.")]
Duration = Annotated[float | None, quantity("--duration-s", "Duration of the movement, 0.05..60 s.")]
Rhythm = Annotated[str | None, typer.Option(help="Shoulder rhythm: Fixed, SoltaniZarrin2017, Measured.")]
Gain = Annotated[float | None, quantity("--gain", "Scale of the rhythm's displacement, 0..1.5.")]
Smoothing = Annotated[float | None, quantity("--smoothing-rad", "Smoothing at the hanging arm, 0..0.3 rad.")]
Metric = Annotated[str | None, typer.Option(help="Kinetic energy with movingShoulder or fixedShoulder.")]
AxialFactor = Annotated[
    float | None,
    quantity(
        "--axial-factor",
        "Price of turning in the metric, 1..5; 1 = kinetic energy. Default: 3 with HumanPrior, else 1.",
    ),
]
Swivel = Annotated[str | None, typer.Option(help="Final posture: MinimumEnergy, Prescribed, HumanPrior.")]
SwivelRad = Annotated[float | None, quantity("--swivel-prescribed-rad", "Swivel angle of Prescribed, rad.")]
Timing = Annotated[str | None, typer.Option(help="MinimumJerkRiemannian, MinimumJerkHand or MinimumJerkHoming.")]
ExoName = Annotated[str | None, typer.Option("--exo", help="Exoskeleton: NAME of a shipped one, or FILE.yaml.")]
Limits = Annotated[
    list[str] | None,
    typer.Option("--limits-deg", help="NAME=lower,upper in deg; NAME elevation, plane, axial_rotation, elbow_flexion."),
]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON and nothing else.")]
CsvFile = Annotated[Path | None, typer.Option("--csv", help="Write the motion as CSV.")]
PlotFile = Annotated[
    Path | None,
    typer.Option("--plot", callback=picture, help="Draw the picture (.png, .svg, .pdf); with --exo a second, *_exo."),
]

METRICS = {
    "movingshoulder": "movingShoulder",
    "moving": "movingShoulder",
    "fixedshoulder": "fixedShoulder",
    "fixed": "fixedShoulder",
}


def numbers(text: str | None, count: int, option: str) -> list[float] | None:
    """Comma-separated numbers. InputError names the option."""
    if text is None:
        return None
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = []
    if len(values) != count:
        raise InputError(f"{option} = {text!r}: must be {count} numbers with commas between")
    return values


def limit_ranges(entries: list[str] | None) -> dict[str, Any]:
    """NAME=lower,upper entries as a mapping."""
    ranges: dict[str, Any] = {}
    for entry in entries or []:
        name, _, text = entry.partition("=")
        if name in ranges:
            raise InputError(f"--limits-deg {name}: stands twice")
        ranges[name] = numbers(text, 2, f"--limits-deg {name}")
    return ranges


@dataclass(frozen=True)
class Asked:
    """What the options of a reach describe together."""

    reach: ReachInput
    subject_file: Path | None


def asked(
    reach: ReachFile = None,
    subject: SubjectFile = None,
    start_deg: StartDeg = None,
    start_rad: StartRad = None,
    target: Target = None,
    duration: Duration = None,
    rhythm: Rhythm = None,
    gain: Gain = None,
    smoothing: Smoothing = None,
    metric: Metric = None,
    axial_factor: AxialFactor = None,
    swivel: Swivel = None,
    swivel_rad: SwivelRad = None,
    timing: Timing = None,
    limits: Limits = None,
) -> Asked:
    """The reach of a file, with a subject's file over its subject, and options over both."""
    options = {
        "start_q_deg": numbers(start_deg, 4, "--start-q-deg"),
        "start_q_rad": numbers(start_rad, 4, "--start-q-rad"),
        "target_m": numbers(target, 3, "--target-m"),
        "duration_s": duration,
        "rhythm": {"model": rhythm, "gain": gain, "smoothing_rad": smoothing},
        "metric": None if metric is None else METRICS.get(metric.lower(), metric),
        "swivel": {"mode": swivel, "prescribed_rad": swivel_rad},
        "axial_factor": axial_factor,
        "timing": timing,
        "subject": {"limits_deg": limit_ranges(limits)},
    }
    data = read_mapping(reach) if reach is not None else {}
    origin = str(reach) if reach is not None else "command line"
    build_reach(data, origin)
    if subject is not None:
        person = load_subject(subject)
        data = merged(data, {"subject": person.model_dump(include=person.model_fields_set)})
    given = build_reach(laid_over(data, options), f"{origin} with options" if reach is not None else origin)
    return Asked(given, subject)


def of_a_reach(command: Callable[..., None]) -> Callable[..., None]:
    """Puts the options of a reach before those of a command, whose first argument becomes what they describe."""
    shared = inspect.signature(asked, eval_str=True).parameters
    _, *own = inspect.signature(command, eval_str=True).parameters.values()

    def with_options(**values: Any) -> None:
        described = asked(**{name: values.pop(name) for name in shared})
        command(described, **values)

    with_options.__name__, with_options.__doc__ = command.__name__, command.__doc__
    with_options.__signature__ = inspect.Signature([*shared.values(), *own])  # type: ignore[attr-defined]
    return with_options
