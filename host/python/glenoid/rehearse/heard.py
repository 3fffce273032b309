"""The record of a run in real time, out of the messages that were heard and the bridge's log of frames."""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np

from glenoid.lcm_types import command_v1_t, event_v1_t, feedback_v1_t, setpoint_v1_t, status_v1_t
from glenoid.publisher import COMMAND, EVENT, FEEDBACK, STATES, STATUS, decoded, text_of
from glenoid.rehearse.record import Columns, Record
from glenoid.rehearse.scenario import Scenario
from glenoid.rehearse.stream import Stream

Kind = TypeVar("Kind", setpoint_v1_t, feedback_v1_t, status_v1_t, event_v1_t, command_v1_t)
Heard = list[tuple[int, str, bytes]]
ERROR_FRAME = 0x2000_0000
JOINT_LISTS = ("node_id", "nmt_state", "drive_state", "statusword", "error_code", "heartbeat_age_ns")
BUS_LISTS = ("state", "tx_errors", "rx_errors", "refused", "outstanding", "overruns", "load")


def of(messages: Heard, channel: str, kind: type[Kind]) -> list[Kind]:
    """Messages of one channel that are of its type."""
    found = (decoded(kind, data) for _, name, data in messages if name == channel)
    return [message for message in found if message is not None]


def integers(values: list[int]) -> Any:
    """A column."""
    return np.array(values, dtype=np.int64)


def table(rows: list[Any], joints: int, kind: type = float) -> Any:
    """A column a joint."""
    return np.array([row[:joints] for row in rows], dtype=kind).reshape(len(rows), joints)


def feedback_columns(messages: list[feedback_v1_t], joints: int) -> Columns:
    """Columns as the rig gives them."""
    names = ("sequence", "session", "sync_count", "setpoint_sequence", "state", "valid_mask")
    out: Columns = {"time_ns": integers([m.time_mono_ns for m in messages])}
    out |= {name: integers([getattr(m, name) for m in messages]) for name in names}
    for name in ("position_rad", "velocity_rad_per_s", "effort_Nm", "command_rad"):
        out[name] = table([getattr(m, name) for m in messages], joints)
    return out | {"statusword": table([m.statusword for m in messages], joints, np.int64)}


def setpoint_columns(stream: Stream, sent: list[int], origin_ns: int, session: int) -> Columns:
    """What was sent, at the instants of sending."""
    at = integers(sent)
    rows = np.flatnonzero(at > 0)
    return {
        "due_ns": at[rows],
        "time_ns": stream.stamp_ns[rows] + origin_ns,
        "sequence": stream.sequence[rows],
        "session": stream.session_xor[rows] ^ session,
        "position_rad": stream.position_rad[rows],
        "velocity_rad_per_s": stream.velocity_rad_per_s[rows],
    }


def frame_columns(frames: list[tuple[int, Any]], names: list[str]) -> Columns:
    """Columns as the rig gives them."""
    data = np.zeros((len(frames), 8), dtype=np.uint8)
    for k, (_, message) in enumerate(frames):
        data[k, : len(message.data)] = list(message.data)
    return {
        "time_ns": integers([time_ns for time_ns, _ in frames]),
        "bus": integers([names.index(m.channel) if m.channel in names else 0 for _, m in frames]),
        "id": np.array(
            [m.arbitration_id | (ERROR_FRAME if m.is_error_frame else 0) for _, m in frames], dtype=np.uint32
        ),
        "size": integers([len(m.data) for _, m in frames]),
        "data": data,
    }


def status_row(message: status_v1_t) -> dict[str, Any]:
    """Fields as the rig gives them."""
    names = ("sequence", "session", "state", "fault", "joint_count", "bus_count", "purge_needed", "configured")
    counters = ("cycles", "cycles_skipped", "setpoints_accepted", "setpoints_rejected", "last_rejection")
    row: dict[str, Any] = {name: getattr(message, name) for name in (*names, *counters)}
    row["time_ns"] = message.time_mono_ns
    row |= {f"bus_{name}": list(getattr(message, f"bus_{name}")[: message.bus_count]) for name in BUS_LISTS}
    lists = (*JOINT_LISTS, "missed_feedback", "following_error_rad")
    return row | {name: list(getattr(message, name)[: message.joint_count]) for name in lists}


def event_row(message: event_v1_t) -> dict[str, Any]:
    """Fields as the rig gives them."""
    names = ("sequence", "severity", "code", "bus", "node", "joint", "value", "limit")
    row = {name: getattr(message, name) for name in names}
    return row | {"time_ns": message.time_mono_ns, "text": text_of(message.text)}


def heard_record(
    scenario: Scenario,
    messages: Heard,
    stream: Stream,
    sent: list[int],
    origin_ns: int,
    stages: list[str],
    frames: list[tuple[int, Any]],
    drives: list[dict[str, Any]],
) -> Record:
    """Everything that was heard, in the form of a run in virtual time. The state at the end is that before the shut-down."""
    joints = len(scenario.joints)
    statuses = of(messages, STATUS, status_v1_t)
    requests = of(messages, COMMAND, command_v1_t)
    session = max((status.session for status in statuses), default=0)
    last = statuses[-1] if statuses else None
    return Record(
        origin_ns=origin_ns,
        feedback=feedback_columns(of(messages, FEEDBACK, feedback_v1_t), joints),
        setpoints=setpoint_columns(stream, sent, origin_ns, session),
        commands={
            "time_ns": integers([m.time_mono_ns for m in requests]),
            **{name: integers([getattr(m, name) for m in requests]) for name in ("sequence", "session", "command")},
        },
        frames=frame_columns(frames, [str(bus["name"]) for bus in scenario.config.buses]),
        events=[event_row(event) for event in of(messages, EVENT, event_v1_t)],
        statuses=[status_row(status) for status in statuses],
        truth=None,
        drives=drives,
        stages=stages if last is not None else [*stages, "the bridge was never heard"],
        state=STATES.get(last.state, "?") if last is not None else "IDLE",
        fault=last.fault if last is not None else 0,
    )
