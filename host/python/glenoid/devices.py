"""Devices as YAML: geometry, ranges and gears of an exoskeleton, with the origin of every figure; docs/exoskeletons.md."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
import yaml
from pydantic import Field, ValidationError, ValidationInfo, field_validator

from glenoid.inputs import (
    InputError,
    Range,
    Real,
    Strict,
    Truth,
    Vector3,
    Whole,
    parse_mapping,
    read_text,
    rule_of,
)

FILL = "user must fill in"
FOLDER = Path(__file__).parent / "data" / "exoskeletons"
#: joints in the order of exo.q and of the drives on the bus
JOINTS = ("girdle_protraction", "girdle_elevation", "shoulder_1", "shoulder_2", "shoulder_3", "elbow")
UNITS = {"_deg": "deg", "_rad": "rad", "_m": "m"}
UNIT_TOLERANCE = 1e-6
StatusName = Literal["given", "sourced", "nominal", "assumed"]
STATED_KEYS = {"value", "status", "source", "note"}
Axes = tuple[Vector3, Vector3, Vector3]


class ShoulderInput(Strict):
    """Three axes through one point: unit vectors, or the angles between them."""

    axes: Axes | None = Field(default=None, description="unit vectors of joints 1..3 in the base frame at zero")
    a12_deg: Real | None = Field(default=None, ge=1.0, le=179.0, description="angle between axes 1 and 2")
    a12_rad: Real | None = Field(default=None, ge=np.deg2rad(1.0), le=np.deg2rad(179.0))
    a23_deg: Real | None = Field(default=None, ge=1.0, le=179.0, description="angle between axes 2 and 3")
    a23_rad: Real | None = Field(default=None, ge=np.deg2rad(1.0), le=np.deg2rad(179.0))
    twist_deg: Real | None = Field(default=None, description="turn of axis 3 about axis 2 out of the plane of 1 and 2")
    twist_rad: Real | None = None
    min_singularity_deg: Real = Field(default=0.0, ge=0.0, lt=90.0, description="paths nearer to singular are refused")

    @field_validator("axes")
    @classmethod
    def _unit(cls, axes: Axes | None) -> Axes | None:
        for number, axis in enumerate(axes or (), start=1):
            length = float(np.linalg.norm(axis))
            if abs(length - 1.0) > UNIT_TOLERANCE:
                raise ValueError(f"axis {number} has length {length:.6g}, must be 1 within {UNIT_TOLERANCE:g}")
        return axes


class MountsInput(Strict):
    """Constant rotations as rotation vectors: B of the base in the trunk, C of the upper arm in the last link."""

    base_deg: Vector3 | None = None
    base_rad: Vector3 | None = None
    cuff_deg: Vector3 | None = None
    cuff_rad: Vector3 | None = None


class GirdleInput(Strict):
    """How the device follows the shoulder girdle."""

    drives: Literal["Full", "NoLength", "VerticalOnly", "NoDrives"] = "Full"
    order: Literal["ProtractionFirst", "ElevationFirst"] = "ProtractionFirst"
    base_follows: Truth = Field(default=False, description="the girdle turns the shoulder axes; false: parallelogram")
    link_m: Real = Field(default=0.0, ge=0.0, le=1.0, description="fixed length; 0 = that of the start posture")


class GearInput(Strict):
    """From drive counts to a joint angle: angle = sign * 2 pi * counts / (counts per turn * ratio) + offset."""

    ratio: Real = Field(gt=0.0, description="turns of the encoder per turn of the joint")
    sign: Literal[-1, 1]
    encoder_counts_per_turn: Whole = Field(gt=0)
    offset_rad: Real = 0.0

    @field_validator("sign", mode="before")
    @classmethod
    def _number(cls, sign: Any) -> Any:
        if isinstance(sign, bool):
            raise ValueError("must be -1 or 1")
        return sign


class JointInput(Strict):
    """Range and gear of one joint."""

    range_deg: Range | None = None
    range_rad: Range | None = None
    gear: GearInput | None = None

    @field_validator("range_deg", "range_rad")
    @classmethod
    def _ordered(cls, value: Range | None, info: ValidationInfo) -> Range | None:
        if value is not None and value[0] >= value[1]:
            raise ValueError("the lower end must be below the upper one")
        turn = 720.0 if info.field_name == "range_deg" else np.deg2rad(720.0)
        if value is not None and max(abs(value[0]), abs(value[1])) > turn:
            raise ValueError("must lie within two turns")
        return value


class JointsInput(Strict):
    """The six joints in the order of exo.q."""

    girdle_protraction: JointInput = JointInput()
    girdle_elevation: JointInput = JointInput()
    shoulder_1: JointInput = JointInput()
    shoulder_2: JointInput = JointInput()
    shoulder_3: JointInput = JointInput()
    elbow: JointInput = JointInput()


class DeviceInput(Strict):
    """One exoskeleton."""

    name: str
    note: str = ""
    side: Literal["either", "right", "left"] = Field(
        default="either", description="either: twins, drawn as the right one"
    )
    shoulder: ShoulderInput = ShoulderInput()
    mounts: MountsInput = MountsInput()
    girdle: GirdleInput = GirdleInput()
    joints: JointsInput = JointsInput()


@dataclass(frozen=True)
class Figure:
    """One figure of a file and where it comes from."""

    key: str
    value: Any
    status: str
    source: str
    line: int


@dataclass(frozen=True)
class Device:
    """A checked file. `missing` holds the keys that the user must fill in before anything is planned."""

    path: Path
    data: DeviceInput
    figures: tuple[Figure, ...]

    @property
    def missing(self) -> tuple[Figure, ...]:
        """Figures that nobody has given yet."""
        return tuple(figure for figure in self.figures if figure.status == FILL)

    def require_complete(self) -> None:
        """InputError naming every missing key."""
        if self.missing:
            keys = "\n".join(f"{self.path}:{figure.line}: {figure.key}: {FILL}" for figure in self.missing)
            raise InputError(f"{self.path}: {self.data.name} is a template; nothing is planned for it before\n{keys}")


class Reader:
    """Takes the statuses off a YAML tree and remembers keys, lines and what is missing."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.lines: dict[str, int] = {}
        self.figures: list[Figure] = []

    def fail(self, key: str, rule: str) -> InputError:
        """An error at a key."""
        return InputError(f"{self.path}:{self.line(key)}: {key or 'file'}: {rule}")

    def line(self, key: str) -> int:
        """Line of a key, or of the section around it."""
        while key and key not in self.lines:
            key = key.rpartition(".")[0]
        return self.lines.get(key, 1)

    def number_lines(self, node: yaml.Node | None, key: str = "") -> None:
        """Line of every key of a tree that parse_mapping took."""
        if not isinstance(node, yaml.MappingNode):
            return
        for name, value in node.value:
            inner = key if name.value == "value" else f"{key}.{name.value}".lstrip(".")
            self.lines.setdefault(inner, name.start_mark.line + 1)
            self.number_lines(value, inner)

    def plain(self, data: Any, key: str = "") -> Any:
        """The tree without statuses; FILL where a figure is missing."""
        if isinstance(data, Mapping) and "value" in data:
            return self.stated(data, key)
        if isinstance(data, Mapping):
            return {name: self.plain(value, f"{key}.{name}".lstrip(".")) for name, value in data.items()}
        if key.count("."):
            status = FILL if data == FILL else "given"
            self.figures.append(Figure(key, data, status, "", self.line(key)))
        return data

    def stated(self, data: Mapping[str, Any], key: str) -> Any:
        """A figure with its origin."""
        if extra := sorted(set(data) - STATED_KEYS):
            raise self.fail(f"{key}.{extra[0]}", f"unknown key; a figure takes {', '.join(sorted(STATED_KEYS))}")
        value, source = data["value"], str(data.get("source") or data.get("note") or "")
        status = FILL if value == FILL else data.get("status", "given")
        if status != FILL and status not in get_args(StatusName):
            raise self.fail(f"{key}.status", f"{status!r} must be one of {', '.join(get_args(StatusName))}")
        if status == "sourced" and not data.get("source"):
            raise self.fail(key, "a sourced figure needs its source")
        self.figures.append(Figure(key, value, status, source, self.line(key)))
        return value


def without_missing(data: Any) -> Any:
    """The tree without the figures that the user must fill in."""
    if isinstance(data, dict):
        return {key: without_missing(value) for key, value in data.items() if value != FILL}
    return data


def key_of(location: tuple[int | str, ...]) -> str:
    """section.key[index] of a pydantic location."""
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in location)
    return text.lstrip(".")


def unit_of(key: str) -> str:
    """Unit that a key's name says, with a blank in front."""
    name = key.partition("[")[0]
    return next((f" {unit}" for suffix, unit in UNITS.items() if name.endswith(suffix)), "")


def problems_of(error: ValidationError, reader: Reader) -> Iterator[str]:
    """File, line, key, value, unit and rule, a line per problem."""
    for item in error.errors():
        key = key_of(item["loc"])
        value = "" if item["type"] == "missing" else f" = {item['input']!r}{unit_of(key)}"
        yield f"{reader.path}:{reader.line(key.partition('[')[0])}: {key}{value if len(value) < 120 else ''}: {rule_of(item)}"


def rules_between(data: DeviceInput, missing: set[str]) -> Iterator[tuple[str, str]]:
    """Key and rule of what single figures cannot show."""
    for section, name, keys in (
        ("shoulder", "a12", ("deg", "rad")),
        ("shoulder", "a23", ("deg", "rad")),
        ("shoulder", "twist", ("deg", "rad")),
        ("mounts", "base", ("deg", "rad")),
        ("mounts", "cuff", ("deg", "rad")),
    ):
        if all(getattr(getattr(data, section), f"{name}_{unit}") is not None for unit in keys):
            yield f"{section}.{name}_rad", f"give {name}_deg or {name}_rad, not both"
    for joint in JOINTS:
        entry: JointInput = getattr(data.joints, joint)
        if entry.range_deg is not None and entry.range_rad is not None:
            yield f"joints.{joint}.range_rad", "give range_deg or range_rad, not both"
    angles = [in_rad(data.shoulder, name) is not None for name in ("a12", "a23")]
    if data.shoulder.axes is not None and any(angles):
        yield "shoulder.axes", "give axes or the angles a12 and a23, not both"
    if data.shoulder.axes is None and not all(angles) and not any(key.startswith("shoulder.a") for key in missing):
        yield "shoulder", "needs axes, or a12 and a23"


def in_rad(section: Strict, name: str) -> Any:
    """A figure that may stand in deg or in rad, rad; None if it stands in neither."""
    value = getattr(section, f"{name}_rad")
    degrees = getattr(section, f"{name}_deg")
    return np.deg2rad(degrees) if degrees is not None else value


def parse_device(text: str, path: Path) -> Device:
    """A device from YAML text. InputError with file, line, key, value, unit and rule, a line per problem."""
    reader = Reader(path)
    data = parse_mapping(text, path)
    try:
        reader.number_lines(yaml.compose(text, Loader=yaml.SafeLoader))
        plain = reader.plain(data)
    except RecursionError as error:
        raise InputError(f"{path}: a section must not contain itself") from error
    try:
        device = DeviceInput.model_validate(without_missing(plain))
    except ValidationError as error:
        raise InputError("\n".join(problems_of(error, reader))) from error
    missing = {figure.key for figure in reader.figures if figure.status == FILL}
    if broken := [str(reader.fail(key, rule)) for key, rule in rules_between(device, missing)]:
        raise InputError("\n".join(broken))
    return Device(path, device, tuple(reader.figures))


def device_names() -> list[str]:
    """Devices that come with the package."""
    return sorted(path.stem for path in FOLDER.glob("*.yaml"))


def load_device(name_or_file: str | Path) -> Device:
    """A device by the name of a shipped one or from a file. InputError if there is none, or as parse_device."""
    path = Path(name_or_file)
    if path.suffix not in (".yaml", ".yml"):
        path = FOLDER / f"{name_or_file}.yaml"
        if not path.is_file():
            raise InputError(f"exo = {str(name_or_file)!r}: must be a YAML file or one of {', '.join(device_names())}")
    return parse_device(read_text(path), path)
