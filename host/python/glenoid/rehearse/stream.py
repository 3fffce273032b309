"""The stream of setpoints of a rehearsal, and what the faults of a source make of it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from glenoid.reach import Array
from glenoid.rehearse.motion import Motion
from glenoid.rehearse.scenario import FaultInput

Integers = NDArray[np.int64]
#: the start posture is held before and after the movements, s
LEAD_S, TRAIL_S = 0.4, 0.3
OLD_BY = 100
FOREIGN_TOKEN = 0x5A


@dataclass(frozen=True)
class Stream:
    """Setpoints in the order in which they are sent. Times are ns from the instant of the motion's first sample.

    `session_xor` is 0 for the right token. Arrays have a row a setpoint; positions and velocities a column a joint.
    """

    due_ns: Integers
    stamp_ns: Integers
    sequence: Integers
    session_xor: Integers
    position_rad: Array
    velocity_rad_per_s: Array

    def take(self, rows: NDArray[np.bool_] | Integers) -> Stream:
        """Some of the rows."""
        return Stream(*(getattr(self, name)[rows] for name in self.__dataclass_fields__))

    def beside(self, other: Stream) -> Stream:
        """Both, by the time they are due."""
        both = Stream(
            *(np.concatenate([getattr(self, name), getattr(other, name)]) for name in self.__dataclass_fields__)
        )
        return both.take(np.argsort(both.due_ns, kind="stable"))

    @property
    def end_ns(self) -> int:
        """When the last one is due."""
        return int(self.due_ns[-1])


def make_stream(motion: Motion, period_ns: int, lead_s: float = LEAD_S) -> Stream:
    """The motion with the start held before it and the end behind it.

    Args:
        motion: of the source, a sample every period; velocities are scaled to the bridge's clock.
        period_ns: between two setpoints.
        lead_s: how long the start is held, s.

    """
    lead, trail = round(lead_s * 1e9 / period_ns), round(TRAIL_S * 1e9 / period_ns)
    rows = np.clip(np.arange(-lead, motion.rows + trail), 0, motion.rows - 1)
    stamp = np.arange(-lead, motion.rows + trail, dtype=np.int64) * period_ns
    held = (stamp < 0) | (stamp > (motion.rows - 1) * period_ns)
    velocity = motion.factor * motion.samples["exo_dq_rad_per_s"][rows]
    velocity[held] = 0.0
    return Stream(
        stamp,
        stamp.copy(),
        np.arange(1, len(rows) + 1, dtype=np.int64),
        np.zeros(len(rows), dtype=np.int64),
        motion.samples["exo_q_rad"][rows],
        velocity,
    )


def window_of(stream: Stream, fault: FaultInput) -> NDArray[np.bool_]:
    """Rows sent while the fault lasts."""
    begin = round(1e9 * fault.at_s)
    end = np.iinfo(np.int64).max if fault.duration_s is None else begin + round(1e9 * fault.duration_s)
    return np.asarray((stream.stamp_ns >= begin) & (stream.stamp_ns < end))


def spoiled(stream: Stream, fault: FaultInput, joint: int) -> Stream:
    """The stream with one fault of its source; other kinds leave it as it is."""
    inside = window_of(stream, fault)
    if not inside.any():
        return stream
    position, sequence, stamp = stream.position_rad.copy(), stream.sequence.copy(), stream.stamp_ns.copy()
    match fault.kind:
        case "stream_stop":
            return stream.take(~inside)
        case "stream_nan":
            position[inside, joint] = np.nan
            return replace(stream, position_rad=position)
        case "stream_jump":
            position[inside, joint] += fault.figure
            return replace(stream, position_rad=position)
        case "stream_repeat":
            last = max(int(np.argmax(inside)) - 1, 0)
            position[inside], sequence[inside], stamp[inside] = position[last], sequence[last], stamp[last]
            return replace(stream, position_rad=position, sequence=sequence, stamp_ns=stamp)
        case "stream_old_sequence":
            sequence[inside] = np.maximum(sequence[inside] - OLD_BY, 1)
            return replace(stream, sequence=sequence)
        case "stream_wrong_token":
            return replace(stream, session_xor=np.where(inside, FOREIGN_TOKEN, stream.session_xor))
        case "stream_second_publisher":
            other = stream.take(inside)
            quarter = int(np.diff(stream.stamp_ns).min()) // 4
            counted = np.arange(1, len(other.sequence) + 1, dtype=np.int64)
            return stream.beside(
                replace(other, due_ns=other.due_ns + quarter, stamp_ns=other.stamp_ns + quarter, sequence=counted)
            )
        case "stream_delay":
            late = stream.due_ns + np.where(inside, round(1e6 * fault.figure), 0)
            return replace(stream, due_ns=late).take(np.argsort(late, kind="stable"))
    return stream


def with_faults(stream: Stream, faults: list[FaultInput], joints: list[str]) -> Stream:
    """The stream with all faults of its source."""
    for fault in faults:
        stream = spoiled(stream, fault, joints.index(fault.joint) if fault.joint is not None else 0)
    return stream
