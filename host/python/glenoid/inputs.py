"""What people write: subjects and reaches as YAML, checked once. Every key that is not SI or rad says its unit."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
import yaml
from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator, model_validator

#: numbers and truth values as they are: `true` is no 1, "1" no number, 1 no `true`
Real = Annotated[float, Field(strict=True)]
Whole = Annotated[int, Field(strict=True)]
Truth = Annotated[bool, Field(strict=True)]
Vector3 = tuple[Real, Real, Real]
Vector4 = tuple[Real, Real, Real, Real]
Range = tuple[Real, Real]
RhythmName = Literal["Fixed", "SoltaniZarrin2017", "Measured"]
SwivelName = Literal["MinimumEnergy", "Prescribed", "HumanPrior"]
MetricName = Literal["movingShoulder", "fixedShoulder"]
TimingName = Literal["MinimumJerkRiemannian", "MinimumJerkHand", "MinimumJerkHoming"]
#: coordinates of a target lie within this, m, as in the FMU: farther than any arm, and nearer than millimetres taken for metres
MOST_TARGET_M = 5.0


class InputError(ValueError):
    """An input is refused; the text says where, the key, its value and the broken rule, a line each."""


class Strict(BaseModel):
    """A section in which unknown keys and non-finite numbers are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class LimitsInput(Strict):
    """Joint limits of a person in degrees: what a goniometer shows."""

    elevation: Range = (0.0, 150.0)
    plane: Range = (-135.0, 45.0)
    axial_rotation: Range = (-90.0, 80.0)
    elbow_flexion: Range = (0.0, 145.0)

    def as_rad(self) -> tuple[Vector4, Vector4]:
        """Lower and upper limits on (theta, eta, eta + zeta, phi), rad."""
        ranges = np.deg2rad([self.elevation, self.plane, self.axial_rotation, self.elbow_flexion])
        lower, upper = (tuple(float(value) for value in column) for column in ranges.T)
        return lower, upper  # type: ignore[return-value]


class SubjectInput(Strict):
    """A person; what is not given is scaled from stature and mass (de Leva 1996)."""

    name: str = ""
    note: str = ""
    stature_m: Real = 1.75
    mass_kg: Real = 75.0
    sex: Literal["male", "female"] = "male"
    arm: Literal["right", "left"] = "right"
    upper_arm_length_m: Real | None = None
    forearm_length_m: Real | None = Field(default=None, description="elbow to wrist centre")
    shoulder_distance_m: Real | None = Field(default=None, description="sternoclavicular joint to shoulder centre")
    upper_arm_mass_kg: Real | None = None
    forearm_mass_kg: Real | None = Field(default=None, description="forearm and hand together")
    upper_arm_com_m: Real | None = None
    forearm_com_m: Real | None = None
    upper_arm_inertia_kg_m2: Vector3 | None = None
    forearm_inertia_kg_m2: Vector3 | None = None
    limits_deg: LimitsInput = LimitsInput()


class MeasuredRhythmInput(Strict):
    """Coefficients of the rhythm Measured, as `glenoid validate --fit` writes them."""

    slope_m: Annotated[list[Real], Field(min_length=9, max_length=9)]
    shoulder_distance_m: Annotated[Real, Field(gt=0.0)]


class PriorInput(Strict):
    """Coefficients of the swivel mode HumanPrior, as `glenoid validate --fit` writes them."""

    height_rad: Real
    lateral_rad: Real
    regression: Annotated[Real, Field(ge=0.0, le=1.0)]
    common_rad: Real
    effort: Annotated[Real, Field(ge=0.0)] = 0.02
    lift_per_m: Annotated[Real, Field(ge=0.0)] = 2.0


class RhythmInput(Strict):
    """Shoulder-girdle rhythm."""

    model: RhythmName = "SoltaniZarrin2017"
    gain: Real = 1.0
    smoothing_rad: Real = 0.1
    measured: MeasuredRhythmInput | None = None


class SwivelInput(Strict):
    """Choice of the final posture."""

    mode: SwivelName = "MinimumEnergy"
    prescribed_rad: Real = 0.2
    prior: PriorInput | None = None


class MeasuredInput(Strict):
    """What was measured, for comparison in plots; it does not enter the plan."""

    end_q_deg: Vector4 | None = None
    shoulder_m: Vector3 | None = None
    elbow_m: Vector3 | None = None
    wrist_m: Vector3 | None = None
    wrist_path_m: list[Vector3] = []


class ReachInput(Strict):
    """One reach: who, from which posture, where to, how."""

    name: str = ""
    source: str = ""
    start_q_deg: Vector4 | None = Field(default=None, description="(theta, eta, zeta, phi), deg")
    start_q_rad: Vector4 | None = Field(default=None, description="the same, rad; give one of the two")
    start_shoulder_m: Vector3 | None = Field(default=None, description="measured shoulder centre at the start, in T")
    target_m: Vector3 = Field(default=(0.20, 0.42, 0.25), description="wrist target in the thorax frame T")
    duration_s: Annotated[Real, Field(ge=0.05, le=60.0)] = 1.5
    subject: SubjectInput = SubjectInput()
    rhythm: RhythmInput = RhythmInput()
    swivel: SwivelInput = SwivelInput()
    metric: MetricName = "movingShoulder"
    axial_factor: Annotated[Real, Field(ge=1.0, le=5.0)] | None = Field(
        default=None, description="price of turning in the metric; 1 = kinetic energy; none = 3 with HumanPrior, else 1"
    )
    timing: TimingName = "MinimumJerkRiemannian"
    measured: MeasuredInput = MeasuredInput()

    @model_validator(mode="after")
    def _one_start(self) -> Self:
        if self.start_q_deg is not None and self.start_q_rad is not None:
            raise ValueError("give start_q_deg or start_q_rad, not both")
        return self

    @field_validator("target_m")
    @classmethod
    def _within_a_room(cls, target_m: Vector3) -> Vector3:
        if max(map(abs, target_m)) > MOST_TARGET_M:
            raise ValueError(f"must lie within -{MOST_TARGET_M:g} to {MOST_TARGET_M:g} m; millimetres?")
        return target_m

    @property
    def start_rad(self) -> Vector4:
        """Start posture (theta, eta, zeta, phi), rad."""
        if self.start_q_rad is not None:
            return self.start_q_rad
        theta, eta, zeta, phi = np.deg2rad(self.start_q_deg or (15.0, -30.0, 30.0, 60.0))
        return float(theta), float(eta), float(zeta), float(phi)


#: pydantic's kinds of error whose own words speak of Python
RULES = {
    "extra_forbidden": "unknown key",
    "missing": "is missing",
    "tuple_type": "must be a list of numbers",
    "list_type": "must be a list",
    "dict_type": "must be a section of keys",
    "model_type": "must be a section of keys",
    "invalid_key": "a key must be text",
    "float_type": "must be a number",
    "int_type": "must be a whole number",
    "bool_type": "must be true or false",
    "string_type": "must be text",
    "recursion_loop": "must not contain itself",
}


def rule_of(problem: Any) -> str:
    """What a problem of pydantic's breaks, in words of the file."""
    return RULES.get(problem["type"]) or str(problem["msg"]).removeprefix("Value error, ")


def explain(error: ValidationError, origin: str) -> InputError:
    """The same error in one line per problem: where, key, value, rule."""
    lines = []
    for item in error.errors():
        key = "".join(f": {part}" if k == 0 else f".{part}" for k, part in enumerate(item["loc"]))
        value = f" = {item['input']!r}" if item["loc"] and item["type"] != "missing" else ""
        lines.append(f"{origin}{key}{value if len(value) < 120 else ''}: {rule_of(item)}")
    return InputError("\n".join(lines))


class OnceLoader(yaml.SafeLoader):
    """Plain YAML in which a key that stands twice is an error, not the last one's victory, and 1e-3 is a number."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        """A mapping whose keys are plain and differ."""
        seen: set[Any] = set()
        for key, _ in node.value:
            if not isinstance(key, yaml.ScalarNode):
                raise yaml.constructor.ConstructorError(None, None, "a key must be plain text", key.start_mark)
            if key.value in seen:
                raise yaml.constructor.ConstructorError(None, None, f"{key.value} stands twice", key.start_mark)
            seen.add(key.value)
        return super().construct_mapping(node, deep)


OnceLoader.add_implicit_resolver(
    "tag:yaml.org,2002:float", re.compile(r"[-+]?(\.\d+|\d+(\.\d*)?)[eE][-+]?\d+\Z"), list("-+.0123456789")
)


def parse_mapping(text: str, path: Path) -> dict[str, Any]:
    """YAML text whose top level is a mapping. InputError names `path` if it is not."""
    try:
        data = yaml.load(text, Loader=OnceLoader)
    except (yaml.YAMLError, ValueError) as error:
        mark, problem = getattr(error, "problem_mark", None), getattr(error, "problem", None)
        line = f":{mark.line + 1}" if mark is not None else ""
        raise InputError(f"{path}{line}: not readable as YAML: {problem or error}") from error
    except RecursionError as error:
        raise InputError(f"{path}: not readable as YAML: sections within sections without end") from error
    if not isinstance(data, dict):
        raise InputError(f"{path}: the top level must be a mapping of keys to values")
    return data


def read_text(path: Path) -> str:
    """A text file in UTF-8, with or without a byte order mark. InputError names it if it cannot be read."""
    try:
        return path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: is no text in UTF-8: {error.reason} at byte {error.start}") from error


def read_mapping(path: Path) -> dict[str, Any]:
    """A YAML file whose top level is a mapping. InputError if it is not."""
    return parse_mapping(read_text(path), path)


def merged(base: Mapping[str, Any], extra: Mapping[str, Any]) -> dict[str, Any]:
    """`base` with the values of `extra` put over it, section by section; None in `extra` means not given."""
    out = dict(base)
    for key, value in extra.items():
        if isinstance(value, Mapping):
            section = out.get(key, {})
            out[key] = merged(section if isinstance(section, Mapping) else {}, value)
        elif value is not None:
            out[key] = value
    return {key: value for key, value in out.items() if not (isinstance(value, dict) and not value)}


def laid_over(base: Mapping[str, Any], extra: Mapping[str, Any]) -> dict[str, Any]:
    """Keys of a reach over others; a start posture replaces one in the other unit."""
    starts = [key for key in ("start_q_deg", "start_q_rad") if extra.get(key) is not None]
    kept = {key: value for key, value in base.items() if not (starts and key.startswith("start_q_"))}
    return merged(kept, extra)


def build_reach(data: Mapping[str, Any], origin: str) -> ReachInput:
    """A checked reach; InputError names `origin`."""
    try:
        return ReachInput.model_validate(data)
    except ValidationError as error:
        raise explain(error, origin) from error


def load_reach(path: Path) -> ReachInput:
    """A reach from a YAML file."""
    return build_reach(read_mapping(path), str(path))


def load_subject(path: Path) -> SubjectInput:
    """A subject from a YAML file."""
    try:
        return SubjectInput.model_validate(read_mapping(path))
    except ValidationError as error:
        raise explain(error, str(path)) from error
