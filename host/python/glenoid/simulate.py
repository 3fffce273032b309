"""The same reach through the FMU, by FMPy."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import fmpy
import numpy as np

from glenoid import _core
from glenoid.device_geometry import require_side
from glenoid.devices import Device
from glenoid.exo import core_exo
from glenoid.inputs import InputError, ReachInput
from glenoid.parameters import device_parameters, numbered, subject_lacks, subject_parameters
from glenoid.reach import Array
from glenoid.settings import make_generator, mirrored_if_left

VECTORS = {
    "q_rad": ("q", 4),
    "dq_rad_per_s": ("dq", 4),
    "ddq_rad_per_s2": ("ddq", 4),
    "shoulder_m": ("shoulder", 3),
    "elbow_m": ("elbow", 3),
    "wrist_m": ("wrist", 3),
    "girdle": ("girdle", 3),
    "exo_q_rad": ("exo.q", 6),
    "exo_dq_rad_per_s": ("exo.dq", 6),
}
SCALARS = {
    "swivel_rad": "swivel",
    "progress": "progress",
    "energy_kg_m2": "energy",
    "misalignment_m": "misalignment",
    "exo_residual_m": "exo.residual",
    "status": "status",
}


@dataclass(frozen=True)
class Simulation:
    """What the FMU answered; arrays as in `glenoid.reach.Reach`, on the grid of the steps. `messages`: what it said."""

    fmu: Path
    fmi_version: str
    time_s: Array
    samples: dict[str, Array]
    messages: tuple[str, ...]

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


def refuse_what_the_fmu_lacks(reach: ReachInput) -> None:
    """InputError for settings that the FMU has no parameter for."""
    if extra := subject_lacks(reach.subject):
        raise InputError(f"subject.{extra[0]}: the FMU has no such parameter; use `glenoid plan`")
    for name, fitted in (("rhythm.measured", reach.rhythm.measured), ("swivel.prior", reach.swivel.prior)):
        if fitted is not None:
            raise InputError(f"{name}: the FMU has the core's own coefficients only; use `glenoid plan`")


def start_values(reach: ReachInput, shift: Array, device: Device | None = None) -> dict[str, Any]:
    """Parameters and inputs of the FMU for a reach."""
    refuse_what_the_fmu_lacks(reach)
    if device is not None:
        require_side(device, reach.subject.arm)
    values: dict[str, Any] = {
        "rhythm.model": _core.RhythmModel[reach.rhythm.model].value,
        "rhythm.gain": reach.rhythm.gain,
        "rhythm.smoothing": reach.rhythm.smoothing_rad,
        "metric.movingShoulder": reach.metric == "movingShoulder",
        "metric.axialFactor": reach.axial_factor or 0.0,
        "swivel.mode": _core.SwivelMode[reach.swivel.mode].value,
        "swivel.prescribed": reach.swivel.prescribed_rad,
        "motion.duration": reach.duration_s,
        "motion.timing": _core.TimingLaw[reach.timing].value,
    }
    values |= subject_parameters(reach.subject) | (device_parameters(device) if device is not None else {})
    return values | numbered("start.q", reach.start_rad) | numbered("target", np.array(reach.target_m) - shift)


def output_names() -> list[str]:
    """Outputs of the FMU that are recorded."""
    vectors = [f"{name}[{k}]" for name, size in VECTORS.values() for k in range(1, size + 1)]
    return vectors + list(SCALARS.values())


def words_of(message: bytes | str) -> str:
    """What the FMU said, as text. An FMI 2 message is a format, in which a percent sign is written twice."""
    text = message.decode("utf-8", "replace") if isinstance(message, bytes) else str(message)
    return text.replace("%%", "%")


def simulate(reach: ReachInput, fmu: Path, step_s: float, stop_s: float, device: Device | None = None) -> Simulation:
    """Runs the FMU with constant inputs and reads every step.

    Args:
        reach: what to do.
        fmu: the archive, FMI 2.0 or 3.0.
        step_s: communication step, s, > 0.
        stop_s: end of the simulation, s.
        device: the exoskeleton whose joints are wanted.

    Raises:
        InputError: a setting that the FMU lacks, or the FMU refused; its messages are in the text.

    """
    shift = shoulder_shift(reach)
    values = start_values(reach, shift, device)
    messages: list[str] = []
    with TemporaryDirectory(prefix="glenoid-") as folder:  # FMPy's own stays behind when the FMU refuses
        try:
            fmpy.extract(str(fmu), folder)
            description = fmpy.read_model_description(folder, validate=False)
            result = fmpy.simulate_fmu(
                folder,
                validate=False,
                model_description=description,
                fmi_type="CoSimulation",
                stop_time=stop_s,
                output_interval=step_s,
                step_size=step_s,
                start_values=values,
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
    return Simulation(fmu, description.fmiVersion, np.array(result["time"], dtype=float), samples, tuple(messages))


def core_samples(reach: ReachInput, time_s: Array, device: Device | None = None) -> dict[str, Array]:
    """What the core gives for the FMU's inputs at the times of FMPy's rows, as `Simulation.samples`.

    The first row is before the first step, so before the command. FMPy names the next point of its grid; the FMU adds a step
    to the last one, which may be another number.
    """
    generator = make_generator(reach, core_exo(device, reach.subject) if device is not None else None)
    first = generator.sample(time_s[:1])
    generator.command(float(time_s[0]), np.array(reach.target_m))
    steps = generator.sample(time_s[:-1] + np.diff(time_s))
    return {name: np.concatenate([first[name], steps[name]]) for name in first}


def difference_from_core(reach: ReachInput, simulation: Simulation, device: Device | None = None) -> float:
    """Largest difference in q, exo.q and exo.residual between the FMU and the core with the FMU's own inputs, rad or m.

    0 is expected: the FMU sees the reach moved by `shoulder_shift`, and so does the core here.
    """
    moved = np.array(reach.target_m) - shoulder_shift(reach)
    target = (float(moved[0]), float(moved[1]), float(moved[2]))
    same = reach.model_copy(update={"start_shoulder_m": None, "target_m": target})
    core = core_samples(same, simulation.time_s, device)
    names = ("q_rad", "exo_q_rad", "exo_residual_m")
    return max(float(np.abs(core[name] - simulation.samples[name]).max()) for name in names)
