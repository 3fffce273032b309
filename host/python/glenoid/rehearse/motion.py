"""The FMU as the source of a rehearsal: stepped once per setpoint, its targets set when a movement begins."""

from __future__ import annotations

import ctypes
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
from fmpy.simulation import apply_start_values, instantiate_fmu
from numpy.typing import NDArray

from glenoid import _core
from glenoid.device_link import configured, require_same
from glenoid.devices import Device, load_device
from glenoid.fmus import fmu_path, sha256
from glenoid.inputs import InputError
from glenoid.reach import REFUSALS, Array
from glenoid.rehearse.scenario import Scenario
from glenoid.simulate import start_values, words_of

#: what is read every step: key, variable, size
OUTPUTS = (
    ("exo_q_rad", "exo.q", 6),
    ("exo_dq_rad_per_s", "exo.dq", 6),
    ("q_rad", "q", 4),
    ("dq_rad_per_s", "dq", 4),
    ("ddq_rad_per_s2", "ddq", 4),
    ("wrist_m", "wrist", 3),
    ("girdle", "girdle", 3),
    ("misalignment_m", "misalignment", 0),
    ("residual_m", "exo.residual", 0),
)


@dataclass(frozen=True)
class Motion:
    """What the source gives: rows at `step_s`, from the instant at which the first target is set.

    Attributes:
        step_s: period of the setpoints on the source's clock, s.
        factor: how fast that clock runs against that of the bridge.
        samples: arrays by the keys of OUTPUTS; `residual_m` is what the girdle drives leave.
        status: number of the FMU's status, a row each.
        begins: row at which each movement's target was set.
        ends: row at which it must have arrived.
        targets_m: of each movement.
        fmu: the archive, and its SHA-256.

    """

    step_s: float
    factor: float
    samples: dict[str, Array]
    status: NDArray[np.int64]
    begins: list[int]
    ends: list[int]
    targets_m: list[tuple[float, float, float]]
    fmu: Path
    fmu_sha256: str
    messages: list[str]

    @property
    def period_s(self) -> float:
        """Between two samples on the bridge's clock, s."""
        return self.step_s / self.factor

    @property
    def rows(self) -> int:
        """Number of samples."""
        return len(self.status)

    @property
    def refusals(self) -> list[str]:
        """Movements that the FMU refused, in words."""
        names = [_core.MotionStatus(int(self.status[end])).name for end in self.ends]
        said = next((text for text in reversed(self.messages) if "target" in text or "limit" in text), "")
        return [f"movement {k}: {name} {said}".strip() for k, name in enumerate(names, 1) if name in REFUSALS]


class FmuSource:
    """An FMI 3.0 instance of Glenoid with the scenario's parameters."""

    def __init__(self, scenario: Scenario, device: Device, fmu: Path, step_s: float) -> None:
        self.messages: list[str] = []
        self._step_s, self._steps = step_s, 0
        self._folder = Path(fmpy.extract(str(fmu)))
        try:
            description = fmpy.read_model_description(str(self._folder), validate=False)
            references = {v.name: v.valueReference for v in description.modelVariables}
            first = scenario.data.movements[0]
            values = start_values(scenario.reach(first), np.zeros(3), device)
            self._fmu: Any = instantiate_fmu(
                str(self._folder),
                description,
                "CoSimulation",
                logger=lambda *arguments: self.messages.append(words_of(arguments[-1])),
                debug_logging=True,
            )
            apply_start_values(self._fmu, description, values)
            self._fmu.enterInitializationMode(startTime=0.0)
            self._fmu.exitInitializationMode()
        except Exception as error:
            shutil.rmtree(self._folder, ignore_errors=True)
            if isinstance(error, InputError):
                raise
            raise InputError("\n".join([f"{fmu.name}: {error}", *self.messages])) from error
        names = [n for _, name, size in OUTPUTS for n in ([f"{name}[{k}]" for k in range(1, size + 1)] or [name])]
        self._references = (ctypes.c_uint32 * len(names))(*[references[name] for name in names])
        self._values = (ctypes.c_double * len(names))()
        self._status = (ctypes.c_uint32 * 1)(references["status"])
        self._status_value = (ctypes.c_int64 * 1)()
        self._targets = [references[f"target[{k}]"] for k in (1, 2, 3)]
        self._duration = references["motion.duration"]

    def begin(self, target_m: tuple[float, float, float], duration_s: float) -> None:
        """Sets what the next step starts."""
        self._fmu.setFloat64([self._duration], [duration_s])
        self._fmu.setFloat64(self._targets, list(target_m))

    def read(self) -> tuple[list[float], int]:
        """All outputs of now in the order of OUTPUTS, and the status."""
        fmu, n = self._fmu, len(self._values)
        fmu.fmi3GetFloat64(fmu.component, self._references, n, self._values, n)
        fmu.fmi3GetInt64(fmu.component, self._status, 1, self._status_value, 1)
        return list(self._values), int(self._status_value[0])

    def step(self) -> None:
        """One period."""
        self._fmu.doStep(currentCommunicationPoint=self._steps * self._step_s, communicationStepSize=self._step_s)
        self._steps += 1

    def close(self) -> None:
        """Ends the FMU and removes what was unpacked."""
        self._fmu.terminate()
        self._fmu.freeInstance()
        shutil.rmtree(self._folder, ignore_errors=True)


def run_source(
    scenario: Scenario, period_s: float, factor: float = 1.0, tell: Callable[[float], None] = lambda _share: None
) -> Motion:
    """Steps the FMU through all movements.

    Nothing flows back from the bridge into the FMU, so its steps may be taken before the bridge's: the bits are those of
    stepping both in turn.

    Args:
        scenario: what to do.
        period_s: between two setpoints, s.
        factor: how fast the source's clock runs.
        tell: is told the share done.

    Raises:
        InputError: the FMU refuses a parameter.

    """
    fmu = fmu_path("3")
    device = load_device(scenario.data.exoskeleton)
    require_same(configured(scenario.config), device, scenario.subject.arm)
    step_s = factor * period_s
    source = FmuSource(scenario, device, fmu, step_s)
    rows: list[list[float]] = []
    status: list[int] = []
    begins, ends, targets = [], [], []

    def take() -> None:
        values, state = source.read()
        rows.append(values)
        status.append(state)

    movements = scenario.data.movements
    try:
        take()
        for k, movement in enumerate(movements):
            targets.append(scenario.target_m(movement))
            begins.append(len(rows) - 1)
            source.begin(targets[-1], movement.duration_s)
            moving = round(movement.duration_s / step_s) + 2
            for _ in range(moving + round(movement.pause_s / step_s)):
                source.step()
                take()
            ends.append(begins[-1] + moving)
            tell((k + 1) / len(movements))
    except Exception as error:
        if isinstance(error, InputError):
            raise
        raise InputError("\n".join([f"{fmu.name}: {error}", *source.messages])) from error
    finally:
        source.close()
    samples = columns(np.array(rows, dtype=float))
    return Motion(
        step_s=step_s,
        factor=factor,
        samples=samples,
        status=np.array(status, dtype=np.int64),
        begins=begins,
        ends=ends,
        targets_m=targets,
        fmu=fmu,
        fmu_sha256=sha256(fmu),
        messages=source.messages,
    )


def columns(rows: Array) -> dict[str, Array]:
    """The rows by key."""
    out, at = {}, 0
    for key, _, size in OUTPUTS:
        width = max(size, 1)
        out[key] = rows[:, at : at + width] if size else rows[:, at]
        at += width
    return out
