"""Glenoid: human-like reference motion for upper-limb exoskeletons that support the shoulder girdle.

SI units and radians; frames and angles as in docs/conventions.md. The mathematics is in `glenoid._core` (C++), which is
loaded with the first name that needs it: files can be read without it.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from glenoid._core import Status
    from glenoid._core import version as __version__
    from glenoid.devices import Device, load_device
    from glenoid.inputs import InputError, ReachInput, SubjectInput, load_reach, load_subject
    from glenoid.reach import Reach, plan_reach

HOMES = {
    "Device": ("glenoid.devices", "Device"),
    "InputError": ("glenoid.inputs", "InputError"),
    "Reach": ("glenoid.reach", "Reach"),
    "ReachInput": ("glenoid.inputs", "ReachInput"),
    "Status": ("glenoid._core", "Status"),
    "SubjectInput": ("glenoid.inputs", "SubjectInput"),
    "__version__": ("glenoid._core", "version"),
    "load_device": ("glenoid.devices", "load_device"),
    "load_reach": ("glenoid.inputs", "load_reach"),
    "load_subject": ("glenoid.inputs", "load_subject"),
    "plan_reach": ("glenoid.reach", "plan_reach"),
}

__all__ = [
    "Device",
    "InputError",
    "Reach",
    "ReachInput",
    "Status",
    "SubjectInput",
    "__version__",
    "load_device",
    "load_reach",
    "load_subject",
    "plan_reach",
]


def __getattr__(name: str) -> Any:
    """A public name, from its module."""
    if name not in HOMES:
        raise AttributeError(f"module 'glenoid' has no attribute {name!r}")
    module, attribute = HOMES[name]
    return getattr(import_module(module), attribute)
