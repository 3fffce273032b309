"""The record as MCAP: JSON messages, each channel with its JSON schema, so that a reader needs nothing else."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from mcap.writer import CompressionType, Writer

from glenoid.publisher import STATES
from glenoid.rehearse.motion import OUTPUTS, Motion
from glenoid.rehearse.record import Record
from glenoid.rehearse.scenario import FAULTS, Scenario

Message = tuple[int, str, dict[str, Any]]
INTEGER, NUMBER, TEXT = {"type": "integer"}, {"type": "number"}, {"type": "string"}
#: NaN is null: JSON has none
JOINTS = {
    "type": "array",
    "items": {"type": ["number", "null"]},
    "description": "a value a joint, in the order of exo.q",
}
NUMBERS = {"type": "array", "items": {"type": "number"}}
TOKEN = TEXT | {"description": "decimal; 63 bits do not fit every reader's number"}
SCHEMAS: dict[str, dict[str, Any]] = {
    "setpoint": {
        "time_ns": INTEGER,
        "sequence": INTEGER,
        "session": TOKEN,
        "position_rad": JOINTS,
        "velocity_rad_per_s": JOINTS,
    },
    "command": {"time_ns": INTEGER, "sequence": INTEGER, "session": TOKEN, "command": INTEGER},
    "feedback": {
        "time_ns": INTEGER | {"description": "of the SYNC"},
        "sync_count": INTEGER,
        "setpoint_sequence": INTEGER,
        "session": TOKEN,
        "state": TEXT,
        "valid_mask": INTEGER,
        "position_rad": JOINTS,
        "velocity_rad_per_s": JOINTS,
        "effort_Nm": JOINTS,
        "command_rad": JOINTS,
        "statusword": {"type": "array", "items": INTEGER},
    },
    "status": {
        "time_ns": INTEGER,
        "state": TEXT,
        "fault": TEXT,
        "configured": INTEGER,
        "setpoints_accepted": INTEGER,
        "setpoints_rejected": INTEGER,
        "cycles": INTEGER,
        "cycles_skipped": INTEGER,
        "bus_load": NUMBERS,
        "following_error_rad": JOINTS,
    },
    "event": {
        "time_ns": INTEGER,
        "severity": INTEGER | {"description": "0 information, 1 warning, 2 error"},
        "code": INTEGER,
        "joint": INTEGER,
        "value": NUMBER,
        "limit": NUMBER,
        "text": TEXT,
    },
    "source": {"time_ns": INTEGER}
    | {key: (NUMBERS if size else NUMBER) | {"description": f"FMU output {name}"} for key, name, size in OUTPUTS},
    "can": {
        "time_ns": INTEGER,
        "bus": TEXT,
        "id": INTEGER | {"description": "bit 29: error frame"},
        "data": TEXT | {"description": "hexadecimal"},
    },
}


def plain(value: Any) -> Any:
    """Arrays as lists, NaN as None, the token as text elsewhere."""
    if isinstance(value, np.ndarray):
        return [plain(item) for item in value.tolist()]
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value.item() if isinstance(value, np.generic) else value


def rows_of(columns: dict[str, Any], names: list[str]) -> Iterator[dict[str, Any]]:
    """Rows of a table as plain data."""
    lists = [columns[name].tolist() for name in names]
    for values in zip(*lists, strict=True):
        row = dict(zip(names, values, strict=True))
        for name, value in row.items():
            if isinstance(value, list) and any(item != item for item in value):  # NaN differs from itself
                row[name] = [None if item != item else item for item in value]
        yield row


def with_token(row: dict[str, Any]) -> dict[str, Any]:
    """The token as text."""
    return row | {"session": str(row["session"])}


def all_messages(record: Record, scenario: Scenario, motion: Motion) -> Iterator[Message]:
    """Every message of the run with its time and channel, channel by channel."""
    setpoint = list(SCHEMAS["setpoint"])
    for due, row in zip(record.setpoints["due_ns"].tolist(), rows_of(record.setpoints, setpoint), strict=True):
        yield due, "setpoint", with_token(row)
    for row in rows_of(record.commands, list(SCHEMAS["command"])):
        yield row["time_ns"], "command", with_token(row)
    for row in rows_of(record.feedback, list(SCHEMAS["feedback"])):
        yield row["time_ns"], "feedback", with_token(row) | {"state": STATES[row["state"]]}
    for status in record.statuses:
        row = {name: plain(status[name]) for name in SCHEMAS["status"]}
        yield status["time_ns"], "status", row | {"state": STATES[status["state"]], "fault": FAULTS[status["fault"]]}
    for event in record.events:
        yield event["time_ns"], "event", {name: plain(event[name]) for name in SCHEMAS["event"]}
    names = [str(bus["name"]) for bus in scenario.config.buses]
    data = record.frames["data"].astype(np.uint8)
    for k, row in enumerate(rows_of(record.frames, ["time_ns", "bus", "id", "size"])):
        text = data[k, : row["size"]].tobytes().hex()
        yield (
            row["time_ns"],
            "can",
            {"time_ns": row["time_ns"], "bus": names[row["bus"]], "id": row["id"], "data": text},
        )
    step_ns = round(1e9 * motion.period_s)
    for k, row in enumerate(rows_of(motion.samples, [key for key, _, _ in OUTPUTS])):
        yield record.origin_ns + k * step_ns, "source", {"time_ns": record.origin_ns + k * step_ns} | row


def write_mcap(path: Path, record: Record, scenario: Scenario, motion: Motion) -> None:
    """All channels in the order of time."""
    with path.open("wb") as file:
        writer = Writer(file, compression=CompressionType.ZSTD)
        writer.start(profile="", library="glenoid")
        channels = {}
        for name, properties in SCHEMAS.items():
            schema = {
                "type": "object",
                "title": f"glenoid.{name}",
                "properties": properties,
                "required": list(properties),
            }
            number = writer.register_schema(f"glenoid.{name}", "jsonschema", json.dumps(schema).encode())
            channels[name] = writer.register_channel(f"/glenoid/{name}", "json", number)
        for k, (time_ns, name, row) in enumerate(
            sorted(all_messages(record, scenario, motion), key=lambda message: message[0])
        ):
            text = json.dumps(row, allow_nan=False, separators=(",", ":")).encode()
            writer.add_message(channels[name], log_time=time_ns, publish_time=time_ns, data=text, sequence=k)
        writer.finish()  # type: ignore[no-untyped-call]
