"""What happened in a rehearsal, the same whether time was virtual or real."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from glenoid.publisher import STATES

Columns = dict[str, NDArray[Any]]
STATE_NUMBER = {name: number for number, name in STATES.items()}


@dataclass(frozen=True)
class Record:
    """Columns have a row each, oldest first; times are ns of the clock of the run.

    Attributes:
        origin_ns: instant of the motion's first sample.
        feedback: columns of feedback_v1_t.
        setpoints: columns of setpoint_v1_t and due_ns.
        commands: columns of command_v1_t.
        frames: time_ns, bus, id (bit 29: error frame), size, data.
        events: fields of event_v1_t, text as words.
        statuses: fields of status_v1_t.
        truth: of virtual time: state of each cycle and where the joints truly are; else None.
        drives: counters of the drive models, a joint each.
        stages: what of the start-up was not reached, in words; empty: everything.
        state: at the end.
        fault: latched at the end.

    """

    origin_ns: int
    feedback: Columns
    setpoints: Columns
    commands: Columns
    frames: Columns
    events: list[dict[str, Any]]
    statuses: list[dict[str, Any]]
    truth: Columns | None
    drives: list[dict[str, Any]]
    stages: list[str]
    state: str
    fault: int
    extra: dict[str, Any] = field(default_factory=dict)

    def seconds(self, time_ns: Any) -> Any:
        """Instants as s from the origin."""
        return 1e-9 * (np.asarray(time_ns, dtype=np.int64) - self.origin_ns).astype(float)

    def first_status(self, state: str, since_ns: int) -> int | None:
        """When the bridge was first seen in a state, ns; None: never."""
        number = STATE_NUMBER[state]
        return next(
            (int(s["time_ns"]) for s in self.statuses if s["time_ns"] >= since_ns and s["state"] == number), None
        )
