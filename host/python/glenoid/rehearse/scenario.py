"""Scenarios as YAML, checked once: who, which device and bridge, what to do, what goes wrong, and what must hold."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal, Self

import yaml
from pydantic import Field, ValidationError, model_validator

from glenoid import _core
from glenoid.inputs import (
    InputError,
    MetricName,
    ReachInput,
    Real,
    RhythmInput,
    Strict,
    SubjectInput,
    SwivelInput,
    TimingName,
    Vector3,
    Vector4,
    Whole,
    explain,
    load_subject,
    read_mapping,
)
from glenoid.settings import core_subject

#: wrist targets in T, m, for the right arm of a man of 1.75 m; nominal, docs/rehearsal.md says where each comes from
ACTIVITIES: dict[str, Vector3] = {
    "reach_high": (0.20, 0.38, 0.33),
    "comb_hair": (0.10, 0.07, 0.30),
    "drink": (0.05, 0.20, 0.15),
    "reach_across": (-0.10, 0.38, 0.05),
}
#: the bridge's configuration in the folder of a rehearsal
BRIDGE_COPY = "bridge.yaml"
ActivityName = Literal["reach_high", "comb_hair", "drink", "reach_across"]
StateName = Literal["IDLE", "READY", "RUN", "HOLD", "STOP", "FAULT"]
Level = Literal["off", "warn", "error"]
#: faults of the bridge by number
FAULTS = (
    "None",
    "EStop",
    "StaleSetpoints",
    "LoopStalled",
    "TwoPublishers",
    "LimitExceeded",
    "FollowingError",
    "MeasuredOutOfRange",
    "DriveFault",
    "DriveEmergency",
    "DriveLeftOperation",
    "DriveNotFollowing",
    "DriveRebooted",
    "DriveLeftNmt",
    "HeartbeatLost",
    "FeedbackLost",
    "BusSilent",
    "BusOff",
    "LinkDown",
    "TransmitStalled",
    "StartUpFailed",
    "EnableTimeout",
    "CountOverflow",
    "ForeignMaster",
    "DriveKeepsPower",
)
FaultKind = Literal[
    "stream_stop",
    "stream_nan",
    "stream_jump",
    "stream_repeat",
    "stream_old_sequence",
    "stream_wrong_token",
    "stream_second_publisher",
    "stream_delay",
    "estop",
    "estop_input",
    "drive_emcy",
    "drive_vanish",
    "drive_reboot",
    "drive_stuck_encoder",
    "drive_jam",
    "drive_drop",
    "drive_delay",
    "drive_bus_off",
    "drive_heartbeat_lost",
    "master_heartbeat_lost",
    "bus_silent",
    "bus_stalled",
    "link_down",
]
#: which figure a kind of fault takes beside its time, and its default
FIGURES: dict[str, tuple[str, float]] = {
    "stream_jump": ("jump_rad", 0.3),
    "stream_delay": ("delay_ms", 20.0),
    "drive_emcy": ("code", 0x2310),
    "drive_drop": ("loss_per_mille", 200.0),
    "drive_delay": ("delay_ms", 2.0),
}


class MovementInput(Strict):
    """One movement: a wrist target in T, or an activity by name."""

    target_m: Vector3 | None = None
    activity: ActivityName | None = None
    duration_s: Annotated[Real, Field(ge=0.3, le=30.0)] = 2.0
    pause_s: Annotated[Real, Field(ge=0.0, le=30.0)] = 0.3

    @model_validator(mode="after")
    def _one_target(self) -> Self:
        if (self.target_m is None) == (self.activity is None):
            raise ValueError("give target_m or activity, one of the two")
        return self

    @property
    def name(self) -> str:
        """What it is called in the report."""
        return self.activity or "({:.2f}, {:.2f}, {:.2f}) m".format(*(self.target_m or (0.0, 0.0, 0.0)))


class BridgeInput(Strict):
    """Configuration file of glenoid-bridge, and which exoskeleton of it."""

    file: str
    exoskeleton: str = ""


class DrivesInput(Strict):
    """Simulated drives."""

    profile: str = "nominal"
    load: Literal["none", "arm"] = Field(default="none", description="arm: of the subject, in the exoskeleton")
    seed: Annotated[Whole, Field(ge=1, lt=2**31)] = 1


class RealTimeInput(Strict):
    """The real programs instead of virtual time."""

    factor: Annotated[Real, Field(gt=0.05, le=1.0)] = Field(
        default=1.0, description="clock of the source; 0.5: half as fast"
    )
    bus: str = Field(default="auto", description="in place of the configuration's bus; auto: udp on a port of this run")
    lcm_url: str = Field(
        default="auto", description="auto: multicast that stays on this machine, on a port of this run"
    )
    priority: Annotated[Whole, Field(ge=0, le=90)] = Field(
        default=80,
        description="SCHED_FIFO of the bridge, where that is permitted; drives and source stay below; 0: ordinary",
    )

    def placed(self, port: int) -> RealTimeInput:
        """With the places of `auto` filled in: nobody else on this machine hears or disturbs the run."""
        bus = f"udp:239.74.163.2:{port}" if self.bus == "auto" else self.bus
        url = f"udpm://239.255.76.67:{port}?ttl=0" if self.lcm_url == "auto" else self.lcm_url
        return self.model_copy(update={"bus": bus, "lcm_url": url})


class FaultInput(Strict):
    """Something that goes wrong, so long after the first movement began."""

    kind: FaultKind
    at_s: Annotated[Real, Field(ge=0.0, le=3600.0)]
    duration_s: Annotated[Real, Field(gt=0.0, le=3600.0)] | None = Field(default=None, description="none: to the end")
    joint: str | None = Field(default=None, description="of the configuration; none: the first, drives: all")
    jump_rad: Real | None = None
    delay_ms: Annotated[Real, Field(gt=0.0)] | None = None
    code: Annotated[Whole, Field(gt=0, le=0xFFFF)] | None = None
    loss_per_mille: Annotated[Whole, Field(gt=0, le=1000)] | None = None

    @model_validator(mode="after")
    def _own_figures(self) -> Self:
        own = FIGURES.get(self.kind, ("", 0.0))[0]
        for name in ("jump_rad", "delay_ms", "code", "loss_per_mille"):
            if name != own and getattr(self, name) is not None:
                raise ValueError(f"{name} does not belong to {self.kind}")
        return self

    @property
    def figure(self) -> float:
        """The figure of its kind, 0 where it has none."""
        name, default = FIGURES.get(self.kind, ("", 0.0))
        given = getattr(self, name) if name else None
        return float(given if given is not None else default)


class ExpectInput(Strict):
    """The safe state that the faults must lead to. Times count from the first fault."""

    state: StateName
    fault: str | list[str] = Field(default="None", description="what the bridge must latch; one of several")
    within_ms: Annotated[Real, Field(gt=0.0)]
    at_rest_within_ms: Annotated[Real, Field(gt=0.0)] | None = Field(
        default=None, description="every joint slower than 0.02 rad/s"
    )
    unpowered_within_ms: Annotated[Real, Field(gt=0.0)] | None = None
    moves_at_most_rad: Annotated[Real, Field(gt=0.0)] | None = Field(
        default=None, description="how far any joint may still go, truly where that is known"
    )

    @property
    def faults(self) -> list[str]:
        """The faults of which one is expected."""
        return [self.fault] if isinstance(self.fault, str) else self.fault

    @model_validator(mode="after")
    def _known(self) -> Self:
        if unknown := [name for name in self.faults if name not in FAULTS]:
            raise ValueError(f"fault {unknown[0]!r} must be one of {', '.join(FAULTS)}")
        return self


class CheckInput(Strict):
    """One check: whether it decides, and its limit."""

    level: Level
    limit: Real


def check(level: Level, limit: float) -> Any:
    """A check with its defaults, of which a file may give one or both."""
    return Field(default=CheckInput(level=level, limit=limit))


class ChecksInput(Strict):
    """What is judged. The unit of each limit stands in `glenoid.rehearse.checks.UNITS`."""

    completed: CheckInput = check("error", 0.0)
    arrival: CheckInput = check("error", 0.005)
    tracking_error: CheckInput = check("error", 0.02)
    joint_margin: CheckInput = check("error", 0.0)
    arm_speed: CheckInput = check("error", 6.0)
    arm_acceleration: CheckInput = check("error", 60.0)
    device_margin: CheckInput = check("error", 0.02)
    device_speed: CheckInput = check("error", 0.95)
    device_acceleration: CheckInput = check("error", 0.95)
    misalignment: CheckInput = check("error", 0.005)
    following_error: CheckInput = check("error", 0.05)
    motor_torque: CheckInput = check("error", 1.0)
    jitter: CheckInput = check("error", 500.0)
    bus_load: CheckInput = check("error", 0.8)
    losses: CheckInput = check("error", 0.0)
    reaction: CheckInput = check("error", 60.0)

    @model_validator(mode="before")
    @classmethod
    def _over_the_defaults(cls, data: Any) -> Any:
        if not isinstance(data, dict):
            return data
        defaults = {name: field.default.model_dump() for name, field in cls.model_fields.items()}
        words = {name: "off" if value is False else value for name, value in data.items()}  # YAML reads off as false
        short = {name: {"level": value} if isinstance(value, str) else value for name, value in words.items()}
        return {
            name: defaults[name] | value if name in defaults and isinstance(value, dict) else value
            for name, value in short.items()
        }


class ScenarioInput(Strict):
    """One rehearsal."""

    name: str
    note: str = ""
    subject: SubjectInput | str = SubjectInput()
    exoskeleton: str = "generic_75_75"
    bridge: BridgeInput
    drives: DrivesInput = DrivesInput()
    start_q_deg: Vector4 = (15.0, -30.0, 30.0, 60.0)
    rhythm: RhythmInput = RhythmInput()
    swivel: SwivelInput = SwivelInput()
    metric: MetricName = "movingShoulder"
    axial_factor: Annotated[Real, Field(ge=1.0, le=5.0)] | None = None
    timing: TimingName = "MinimumJerkRiemannian"
    movements: Annotated[list[MovementInput], Field(min_length=1, max_length=1000)]
    mode: Literal["virtual_time", "real_time"] = "virtual_time"
    real_time: RealTimeInput = RealTimeInput()
    faults: Annotated[list[FaultInput], Field(max_length=100)] = Field(default=[])
    expect: ExpectInput | None = None
    checks: ChecksInput = ChecksInput()

    @model_validator(mode="after")
    def _expectation_needs_a_fault(self) -> Self:
        if self.expect is not None and not self.faults:
            raise ValueError("expect: without faults there is no safe state to be reached")
        return self


class Scenario:
    """A checked scenario with everything it names.

    Attributes:
        path: of the file.
        data: the file; the subject is in it, whole.
        subject: the person.
        bridge_yaml: text of the bridge's configuration.
        config: the same, checked.
        joints: names in the order of the drives.

    """

    def __init__(self, path: Path, data: ScenarioInput) -> None:
        self.path = path
        self.subject = data.subject if isinstance(data.subject, SubjectInput) else load_subject(self.near(data.subject))
        self.data = data.model_copy(update={"subject": self.subject})
        self.bridge_file = self.near(data.bridge.file)
        try:
            self.bridge_yaml = self.bridge_file.read_text(encoding="utf-8")
            self.config = _core.BridgeConfig.parse(self.bridge_yaml, data.bridge.exoskeleton)
        except OSError as error:
            raise InputError(f"{path}: bridge.file = {data.bridge.file!r}: {error.strerror}") from error
        except ValueError as error:
            raise InputError(f"{self.bridge_file}: {error}") from error
        self.joints = [str(joint["name"]) for joint in self.config.joints]
        for k, fault in enumerate(data.faults):
            if fault.joint is not None and fault.joint not in self.joints:
                raise InputError(f"{path}: faults.{k}.joint = {fault.joint!r}: must be one of {', '.join(self.joints)}")

    def near(self, name: str) -> Path:
        """A file named in the scenario, relative to it."""
        return (self.path.resolve().parent / name).resolve()

    @property
    def activity_scale(self) -> float:
        """Length of this person's arm over that of a man of 1.75 m."""
        own, man = (_core.scale_subject(core_subject(subject)) for subject in (self.subject, SubjectInput()))
        return float((own.upper_arm.length_m + own.forearm.length_m) / (man.upper_arm.length_m + man.forearm.length_m))

    def target_m(self, movement: MovementInput) -> Vector3:
        """Wrist target in T, m; that of an activity is scaled and, for a left arm, mirrored."""
        if movement.target_m is not None:
            return movement.target_m
        x, y, z = ACTIVITIES[movement.activity or "reach_high"]
        scale = self.activity_scale
        side = -1.0 if self.subject.arm == "left" else 1.0
        return side * scale * x, scale * y, scale * z

    def reach(self, movement: MovementInput) -> ReachInput:
        """A movement as a reach from the start posture."""
        data = self.data
        return ReachInput(
            name=movement.name,
            start_q_deg=data.start_q_deg,
            target_m=self.target_m(movement),
            duration_s=movement.duration_s,
            subject=self.subject,
            rhythm=data.rhythm,
            swivel=data.swivel,
            metric=data.metric,
            axial_factor=data.axial_factor,
            timing=data.timing,
        )

    def resolved(self) -> str:
        """Everything that was run, as YAML with every default written out; to be run again beside BRIDGE_COPY."""
        data = self.data.model_copy(update={"bridge": BridgeInput(file=BRIDGE_COPY, exoskeleton=self.config.name)})
        return yaml.safe_dump(data.model_dump(mode="json"), sort_keys=False, allow_unicode=True)


def parse_scenario(data: dict[str, Any], path: Path) -> Scenario:
    """A scenario from plain data. InputError with file, key, value and rule, a line each."""
    try:
        return Scenario(path, ScenarioInput.model_validate(data))
    except ValidationError as error:
        raise explain(error, str(path)) from error


def load_scenario(path: Path) -> Scenario:
    """A scenario from a YAML file."""
    return parse_scenario(read_mapping(path), path)
