"""The same reach through the FMU, by FMPy."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import fmpy
import numpy as np

from glenoid import _core
from glenoid.inputs import InputError, ReachInput
from glenoid.reach import Array
from glenoid.settings import make_generator, mirrored_if_left

RHYTHM_NUMBER = {"Fixed": 1, "SoltaniZarrin2017": 2, "Measured": 3}
SWIVEL_NUMBER = {"MinimumEnergy": 1, "Prescribed": 2, "HumanPrior": 3}
SUBJECT_PARAMETERS = {
    "subject.upperArmLength": "upper_arm_length_m",
    "subject.forearmLength": "forearm_length_m",
    "subject.shoulderDistance": "shoulder_distance_m",
}
VECTORS = {
    "q_rad": ("q", 4),
    "dq_rad_per_s": ("dq", 4),
    "ddq_rad_per_s2": ("ddq", 4),
    "shoulder_m": ("shoulder", 3),
    "elbow_m": ("elbow", 3),
    "wrist_m": ("wrist", 3),
    "girdle": ("girdle", 3),
}
SCALARS = {
    "swivel_rad": "swivel",
    "progress": "progress",
    "energy_kg_m2": "energy",
    "misalignment_m": "misalignment",
    "status": "status",
}


@dataclass(frozen=True)
class Simulation:
    """What the FMU answered; arrays as in `glenoid.reach.Reach`, on the grid of the steps."""

    fmu: Path
    fmi_version: str
    time_s: Array
    samples: dict[str, Array]

    @property
    def status(self) -> str:
        """Status at the end."""
        return _core.MotionStatus(int(self.samples["status"][-1])).name


def shoulder_shift(reach: ReachInput) -> Array:
    """From the shoulder centre that the FMU's rhythm gives at the start to the measured one, m in T.

    The FMU knows no measured shoulder. Moving the whole reach by a constant changes nothing else: an anchored rhythm is
    the same rhythm plus a constant, and neither energy nor limits depend on it.
    """
    if reach.start_shoulder_m is None:
        return np.zeros(3)
    plain = make_generator(reach.model_copy(update={"start_shoulder_m": None}))
    start = _core.posture_from_angles(np.array(reach.start_rad))
    modelled = mirrored_if_left(plain.arm.rhythm.position(start.R_TU[:, 2]), reach.subject)
    return np.asarray(np.array(reach.start_shoulder_m) - modelled, dtype=float)


def numbered(name: str, values: Any) -> dict[str, float]:
    """Scalars of a vector variable: name[1], name[2], ..."""
    return {f"{name}[{k}]": float(value) for k, value in enumerate(values, start=1)}


def refuse_what_the_fmu_lacks(reach: ReachInput) -> None:
    """InputError for settings that the FMU has no parameter for."""
    extra = [
        name
        for name, value in reach.subject.model_dump(exclude_none=True).items()
        if name.endswith(("_mass_kg", "_com_m", "_inertia_kg_m2")) and value is not None
    ]
    if extra:
        raise InputError(f"subject.{extra[0]}: the FMU has no such parameter; use `glenoid plan`")
    if reach.timing != "MinimumJerkRiemannian":
        raise InputError(f"timing = {reach.timing}: the FMU has MinimumJerkRiemannian only; use `glenoid plan`")


def start_values(reach: ReachInput, shift: Array) -> dict[str, Any]:
    """Parameters and inputs of the FMU for a reach."""
    refuse_what_the_fmu_lacks(reach)
    subject = reach.subject
    values: dict[str, Any] = {
        "subject.stature": subject.stature_m,
        "subject.mass": subject.mass_kg,
        "subject.female": subject.sex == "female",
        "subject.leftArm": subject.arm == "left",
        "rhythm.model": RHYTHM_NUMBER[reach.rhythm.model],
        "rhythm.gain": reach.rhythm.gain,
        "rhythm.smoothing": reach.rhythm.smoothing_rad,
        "metric.movingShoulder": reach.metric == "movingShoulder",
        "swivel.mode": SWIVEL_NUMBER[reach.swivel.mode],
        "swivel.prescribed": reach.swivel.prescribed_rad,
        "motion.duration": reach.duration_s,
    }
    lengths = {name: getattr(subject, field) for name, field in SUBJECT_PARAMETERS.items()}
    values |= {name: length for name, length in lengths.items() if length is not None}
    lower, upper = subject.limits_deg.as_rad()
    values |= numbered("limits.lower", lower) | numbered("limits.upper", upper)
    return values | numbered("start.q", reach.start_rad) | numbered("target", np.array(reach.target_m) - shift)


def output_names() -> list[str]:
    """Outputs of the FMU that are recorded."""
    vectors = [f"{name}[{k}]" for name, size in VECTORS.values() for k in range(1, size + 1)]
    return vectors + list(SCALARS.values())


def words_of(message: bytes | str) -> str:
    """What the FMU said, as text."""
    return message.decode("utf-8", "replace") if isinstance(message, bytes) else str(message)


def simulate(reach: ReachInput, fmu: Path, step_s: float, stop_s: float) -> Simulation:
    """Runs the FMU with constant inputs and reads every step.

    Args:
        reach: what to do.
        fmu: the archive, FMI 2.0 or 3.0.
        step_s: communication step, s, > 0.
        stop_s: end of the simulation, s.

    Raises:
        InputError: a setting that the FMU lacks, or the FMU refused; its messages are in the text.

    """
    shift = shoulder_shift(reach)
    messages: list[str] = []
    try:
        result = fmpy.simulate_fmu(
            str(fmu),
            validate=False,
            fmi_type="CoSimulation",
            stop_time=stop_s,
            output_interval=step_s,
            step_size=step_s,
            start_values=start_values(reach, shift),
            output=output_names(),
            debug_logging=True,
            logger=lambda *arguments: messages.append(words_of(arguments[-1])),
        )
    except Exception as error:
        raise InputError("\n".join([f"{fmu.name}: {error}", *messages])) from error
    samples = {key: np.column_stack([result[f"{n}[{k}]"] for k in range(1, s + 1)]) for key, (n, s) in VECTORS.items()}
    samples |= {key: np.array(result[name], dtype=float) for key, name in SCALARS.items()}
    for point in ("shoulder_m", "elbow_m", "wrist_m"):
        samples[point] = samples[point] + shift
    version = fmpy.read_model_description(str(fmu), validate=False).fmiVersion
    return Simulation(fmu, version, np.array(result["time"], dtype=float), samples)


def difference_from_core(reach: ReachInput, simulation: Simulation) -> float:
    """Largest difference in q between the FMU and the core with the FMU's own inputs, rad; 0 is expected.

    Up to the last bit: the FMU sees the reach moved by `shoulder_shift`, and so does the core here.
    """
    moved = np.array(reach.target_m) - shoulder_shift(reach)
    target = (float(moved[0]), float(moved[1]), float(moved[2]))
    same = reach.model_copy(update={"start_shoulder_m": None, "target_m": target})
    generator = make_generator(same)
    generator.command(0.0, np.array(same.target_m))
    core = generator.sample(simulation.time_s)
    return float(np.abs(core["q_rad"] - simulation.samples["q_rad"]).max())
