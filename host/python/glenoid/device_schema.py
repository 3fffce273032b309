"""JSON schema of a device file, for editors: every figure may carry its status, or be left to the user."""

from __future__ import annotations

from typing import Any, get_args

from glenoid.devices import FILL, DeviceInput, StatusName

SECTIONS = ("ShoulderInput", "MountsInput", "GirdleInput", "JointInput")


def figure_schema(value: dict[str, Any]) -> dict[str, Any]:
    """A value, the same with its origin, or the words for a figure that is not known."""
    blank = {"const": FILL}
    text = {"type": "string"}
    stated = {
        "type": "object",
        "properties": {
            "value": {"anyOf": [value, blank]},
            "status": {"enum": list(get_args(StatusName))},
            "source": text,
            "note": text,
        },
        "required": ["value"],
        "additionalProperties": False,
        "if": {"properties": {"status": {"const": "sourced"}}, "required": ["status"]},
        "then": {"required": ["source"]},
    }
    return {"anyOf": [value, blank, stated]}


def device_schema() -> dict[str, Any]:
    """The schema of host/exoskeletons/*.yaml."""
    schema = DeviceInput.model_json_schema()
    for section in SECTIONS:
        properties = schema["$defs"][section]["properties"]
        schema["$defs"][section]["properties"] = {key: figure_schema(value) for key, value in properties.items()}
    return schema
