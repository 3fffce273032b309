"""What people write: subjects and reaches as YAML, checked once. Every key that is not SI or rad says its unit."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
import yaml
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

Vector3 = tuple[float, float, float]
Vector4 = tuple[float, float, float, float]
Range = tuple[float, float]
RhythmName = Literal["Fixed", "SoltaniZarrin2017", "Measured"]
SwivelName = Literal["MinimumEnergy", "Prescribed", "HumanPrior"]
MetricName = Literal["movingShoulder", "fixedShoulder"]
TimingName = Literal["MinimumJerkRiemannian", "MinimumJerkHand", "MinimumJerkHoming"]


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
    stature_m: float = 1.75
    mass_kg: float = 75.0
    sex: Literal["male", "female"] = "male"
    arm: Literal["right", "left"] = "right"
    upper_arm_length_m: float | None = None
    forearm_length_m: float | None = Field(default=None, description="elbow to wrist centre")
    shoulder_distance_m: float | None = Field(default=None, description="sternoclavicular joint to shoulder centre")
    upper_arm_mass_kg: float | None = None
    forearm_mass_kg: float | None = Field(default=None, description="forearm and hand together")
    upper_arm_com_m: float | None = None
    forearm_com_m: float | None = None
    upper_arm_inertia_kg_m2: Vector3 | None = None
    forearm_inertia_kg_m2: Vector3 | None = None
    limits_deg: LimitsInput = LimitsInput()


class MeasuredRhythmInput(Strict):
    """Coefficients of the rhythm Measured, as `glenoid validate --fit` writes them."""

    slope_m: Annotated[list[float], Field(min_length=9, max_length=9)]
    shoulder_distance_m: Annotated[float, Field(gt=0.0)]


class PriorInput(Strict):
    """Coefficients of the swivel mode HumanPrior, as `glenoid validate --fit` writes them."""

    height_rad: float
    lateral_rad: float
    regression: Annotated[float, Field(ge=0.0, le=1.0)]
    common_rad: float
    effort: Annotated[float, Field(ge=0.0)] = 0.02


class RhythmInput(Strict):
    """Shoulder-girdle rhythm."""

    model: RhythmName = "SoltaniZarrin2017"
    gain: float = 1.0
    smoothing_rad: float = 0.1
    measured: MeasuredRhythmInput | None = None


class SwivelInput(Strict):
    """Choice of the final posture."""

    mode: SwivelName = "MinimumEnergy"
    prescribed_rad: float = 0.2
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
    duration_s: Annotated[float, Field(ge=0.05, le=60.0)] = 1.5
    subject: SubjectInput = SubjectInput()
    rhythm: RhythmInput = RhythmInput()
    swivel: SwivelInput = SwivelInput()
    metric: MetricName = "movingShoulder"
    axial_factor: Annotated[float, Field(ge=1.0, le=5.0)] | None = Field(
        default=None, description="price of turning in the metric; 1 = kinetic energy; none = 3 with HumanPrior, else 1"
    )
    timing: TimingName = "MinimumJerkRiemannian"
    measured: MeasuredInput = MeasuredInput()

    @model_validator(mode="after")
    def _one_start(self) -> Self:
        if self.start_q_deg is not None and self.start_q_rad is not None:
            raise ValueError("give start_q_deg or start_q_rad, not both")
        return self

    @property
    def start_rad(self) -> Vector4:
        """Start posture (theta, eta, zeta, phi), rad."""
        if self.start_q_rad is not None:
            return self.start_q_rad
        theta, eta, zeta, phi = np.deg2rad(self.start_q_deg or (15.0, -30.0, 30.0, 60.0))
        return float(theta), float(eta), float(zeta), float(phi)


def explain(error: ValidationError, origin: str) -> InputError:
    """The same error in one line per problem: where, key, value, rule."""
    lines = []
    for item in error.errors():
        key = "".join(f": {part}" if k == 0 else f".{part}" for k, part in enumerate(item["loc"]))
        rule = "unknown key" if item["type"] == "extra_forbidden" else item["msg"].removeprefix("Value error, ")
        value = f" = {item['input']!r}" if item["loc"] and item["type"] != "missing" else ""
        lines.append(f"{origin}{key}{value if len(value) < 120 else ''}: {rule}")
    return InputError("\n".join(lines))


class OnceLoader(yaml.SafeLoader):
    """Plain YAML in which a key that stands twice is an error, not the last one's victory."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        """A mapping whose keys differ."""
        seen: set[Any] = set()
        for key, _ in node.value:
            if key.value in seen:
                raise yaml.constructor.ConstructorError(None, None, f"{key.value} stands twice", key.start_mark)
            seen.add(key.value)
        return super().construct_mapping(node, deep)


def read_mapping(path: Path) -> dict[str, Any]:
    """A YAML file whose top level is a mapping. InputError if it is not."""
    try:
        data = yaml.load(path.read_text(encoding="utf-8"), Loader=OnceLoader)
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: not readable as YAML: {' '.join(str(error).split())}") from error
    if not isinstance(data, dict):
        raise InputError(f"{path}: the top level must be a mapping of keys to values")
    return data


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
