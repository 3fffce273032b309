"""A rehearsal in real time: the programs glenoid-bridge and glenoid-drives as they run in earnest."""

from __future__ import annotations

from collections.abc import Callable

from glenoid.inputs import InputError
from glenoid.rehearse.motion import Motion
from glenoid.rehearse.record import Record
from glenoid.rehearse.scenario import Scenario


def run_real_time(scenario: Scenario, motion: Motion, tell: Callable[[str, float], None]) -> Record:
    """TEMP."""
    raise InputError("mode = real_time")
