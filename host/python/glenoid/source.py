"""The FMU as a source of setpoints in real time."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
from fmpy.simulation import apply_start_values, instantiate_fmu

from glenoid.devices import Device
from glenoid.inputs import InputError, ReachInput
from glenoid.reach import Array
from glenoid.simulate import VECTORS, shoulder_shift, start_values, words_of

#: after the movement, s
AFTER_S = 0.2


class FmuMotion:
    """The reach, computed by the FMU step by step while it is streamed; see `glenoid.streaming.Motion`.

    Args:
        reach: what to do; the FMU starts at its start posture.
        device: the exoskeleton whose joints are wanted.
        fmu: the archive, FMI 3.0.
        step_s: communication step, s: the period of the setpoints.

    Raises:
        InputError: a setting that the FMU lacks, or the FMU refused; its messages are in the text.

    """

    def __init__(self, reach: ReachInput, device: Device, fmu: Path, step_s: float) -> None:
        self.duration_s = reach.duration_s + AFTER_S
        self._step_s, self._steps = step_s, 0
        self._messages: list[str] = []
        self._folder = Path(fmpy.extract(str(fmu)))
        try:
            values = start_values(reach, shoulder_shift(reach), device)
            self._description = fmpy.read_model_description(str(self._folder), validate=False)
            if self._description.fmiVersion != "3.0":
                raise InputError(f"{fmu}: FMI {self._description.fmiVersion}: must be 3.0")
            self._references = {v.name: v.valueReference for v in self._description.modelVariables}
            self._fmu = self._initialised(values)
        except BaseException:
            shutil.rmtree(self._folder, ignore_errors=True)
            raise

    def _initialised(self, values: dict[str, Any]) -> Any:
        fmu = instantiate_fmu(
            str(self._folder),
            self._description,
            "CoSimulation",
            logger=lambda *arguments: self._messages.append(words_of(arguments[-1])),
            debug_logging=True,
        )
        apply_start_values(fmu, self._description, values)
        fmu.enterInitializationMode(startTime=0.0)
        fmu.exitInitializationMode()
        return fmu

    def read(self, key: str) -> Array:
        """A vector output by its key in `glenoid.simulate.VECTORS`."""
        name, size = VECTORS[key]
        return np.array(
            self._fmu.getFloat64([self._references[f"{name}[{k}]"] for k in range(1, size + 1)]), dtype=float
        )

    def at(self, time_s: float) -> tuple[Array, Array]:
        """Joints of the device at the step nearest to a time that does not fall."""
        while self._steps < round(time_s / self._step_s):
            self._fmu.doStep(currentCommunicationPoint=self._steps * self._step_s, communicationStepSize=self._step_s)
            self._steps += 1
        return self.read("exo_q_rad"), self.read("exo_dq_rad_per_s")

    def close(self) -> None:
        """Ends the FMU and removes what was unpacked."""
        self._fmu.terminate()
        self._fmu.freeInstance()
        shutil.rmtree(self._folder, ignore_errors=True)
