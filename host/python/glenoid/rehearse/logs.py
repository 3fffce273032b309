"""The record as files that other programs read: LCM log, candump log."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, Protocol

import lcm
import numpy as np

from glenoid.lcm_types import command_v1_t, event_v1_t, feedback_v1_t, setpoint_v1_t, status_v1_t
from glenoid.publisher import COMMAND, EVENT, FEEDBACK, MOST_JOINTS, SETPOINT, STATUS
from glenoid.rehearse.record import Record
from glenoid.rehearse.scenario import Scenario

#: statusword bit 12: the drive follows its target
FOLLOWS = 1 << 12
MOST_BUSES = 4


class Encoded(Protocol):
    """A message of lcm_types."""

    def encode(self) -> bytes:
        """Bytes with the fingerprint in front."""


def padded(values: Any, size: int = MOST_JOINTS, rest: float = 0.0) -> list[Any]:
    """The values of a list or row, and zeros behind them."""
    given = values.tolist() if isinstance(values, np.ndarray) else list(values)
    return given + [type(given[0])(rest) if given else rest] * (size - len(given))


def characters(text: str, size: int) -> list[int]:
    """UTF-8 as LCM's signed bytes, with at least one zero at the end."""
    data = text.encode("utf-8")[: size - 1]
    return [byte - 256 if byte > 127 else byte for byte in data] + [0] * (size - len(data))


def setpoints(record: Record) -> Iterator[tuple[int, str, Encoded]]:
    """Setpoints as they reached the bridge."""
    rows = record.setpoints
    joints = rows["position_rad"].shape[1]
    for k, due in enumerate(rows["due_ns"].tolist()):
        out = setpoint_v1_t()
        out.time_mono_ns, out.sequence = int(rows["time_ns"][k]), int(rows["sequence"][k])
        out.session, out.count, out.valid_mask = int(rows["session"][k]), joints, (1 << joints) - 1
        out.position_rad = padded(rows["position_rad"][k])
        out.velocity_rad_per_s = padded(rows["velocity_rad_per_s"][k])
        yield due, SETPOINT, out


def commands(record: Record) -> Iterator[tuple[int, str, Encoded]]:
    """Requests of the operator."""
    rows = record.commands
    for k, time_ns in enumerate(rows["time_ns"].tolist()):
        out = command_v1_t()
        out.time_mono_ns, out.sequence = time_ns, int(rows["sequence"][k])
        out.session, out.command = int(rows["session"][k]), int(rows["command"][k])
        yield time_ns, COMMAND, out


def feedback(record: Record, phase_ns: int) -> Iterator[tuple[int, str, Encoded]]:
    """What the drives answered, told half a period after their SYNC."""
    rows = record.feedback
    joints = rows["position_rad"].shape[1]
    follows = ((rows["statusword"] & FOLLOWS) != 0) @ (1 << np.arange(joints))
    for k, time_ns in enumerate(rows["time_ns"].tolist()):
        out = feedback_v1_t()
        out.time_mono_ns = time_ns
        for name in ("sequence", "session", "sync_count", "setpoint_sequence", "state", "valid_mask"):
            setattr(out, name, int(rows[name][k]))
        out.count, out.tracking_mask = joints, int(follows[k])
        for name in ("position_rad", "velocity_rad_per_s", "effort_Nm", "command_rad", "statusword"):
            setattr(out, name, padded(rows[name][k]))
        yield time_ns + phase_ns, FEEDBACK, out


def events(record: Record) -> Iterator[tuple[int, str, Encoded]]:
    """Events of the bridge."""
    for event in record.events:
        out = event_v1_t()
        out.time_mono_ns = event["time_ns"]
        for name in ("sequence", "severity", "code", "bus", "node", "joint", "value", "limit"):
            setattr(out, name, event[name])
        out.text = characters(event["text"], 160)
        yield event["time_ns"], EVENT, out


def statuses(record: Record, scenario: Scenario) -> Iterator[tuple[int, str, Encoded]]:
    """States of the bridge. Virtual time has no wall clock: time_utc_ns is that of the run."""
    joints = scenario.config.joints
    for status in record.statuses:
        out = status_v1_t()
        out.time_mono_ns = out.time_utc_ns = status["time_ns"]
        out.exoskeleton, out.period_ns = characters(scenario.config.name, 32), scenario.config.period_ns
        for name in ("sequence", "session", "state", "fault", "joint_count", "bus_count", "configured", "purge_needed"):
            setattr(out, name, status[name])
        for name in ("cycles", "cycles_skipped", "setpoints_accepted", "setpoints_rejected", "last_rejection"):
            setattr(out, name, status[name])
        for name in ("state", "tx_errors", "rx_errors", "refused", "outstanding", "overruns", "load"):
            setattr(out, f"bus_{name}", padded(status[f"bus_{name}"], MOST_BUSES))
        for name in ("node_id", "nmt_state", "drive_state", "statusword", "error_code", "heartbeat_age_ns"):
            setattr(out, name, padded(status[name]))
        out.missed_feedback, out.following_error_rad = (
            padded(status["missed_feedback"]),
            padded(status["following_error_rad"]),
        )
        out.velocity_limit_rad_per_s = padded([joint["velocity_rad_per_s"] for joint in joints])
        out.acceleration_limit_rad_per_s2 = padded([joint["acceleration_rad_per_s2"] for joint in joints])
        yield status["time_ns"], STATUS, out


def messages(record: Record, scenario: Scenario) -> list[tuple[int, str, Encoded]]:
    """All messages of the run, oldest first."""
    phase_ns = int(scenario.config.rpdo_phase * scenario.config.period_ns)
    found = [
        *setpoints(record),
        *commands(record),
        *feedback(record, phase_ns),
        *events(record),
        *statuses(record, scenario),
    ]
    return sorted(found, key=lambda message: message[0])


def write_lcm_log(path: Path, record: Record, scenario: Scenario) -> None:
    """An event log as lcm-logger writes it."""
    path.unlink(missing_ok=True)
    log = lcm.EventLog(str(path), "w", overwrite=True)
    for time_ns, channel, message in messages(record, scenario):
        log.write_event(time_ns // 1000, channel, message.encode())
    log.close()


def write_candump(path: Path, record: Record, scenario: Scenario) -> None:
    """All frames of all buses as `candump -L` writes them."""
    names = [str(bus["name"]) for bus in scenario.config.buses]
    frames = record.frames
    columns = (frames[name].tolist() for name in ("time_ns", "bus", "id", "size"))
    with path.open("w", encoding="ascii") as file:
        for (time_ns, bus, identifier, size), data in zip(zip(*columns, strict=True), frames["data"], strict=True):
            digits = f"{identifier:03X}" if identifier < 0x800 else f"{identifier:08X}"
            stamp = f"({time_ns // 1_000_000_000}.{time_ns // 1000 % 1_000_000:06d})"
            file.write(f"{stamp} {names[bus]} {digits}#{bytes(data[:size]).hex().upper()}\n")
