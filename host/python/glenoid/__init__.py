"""Glenoid: human-like reference motion for upper-limb exoskeletons that support the shoulder girdle.

SI units and radians; frames and angles as in docs/conventions.md. The mathematics is in `glenoid._core` (C++).
"""

from glenoid._core import Status
from glenoid._core import version as __version__
from glenoid.inputs import InputError, ReachInput, SubjectInput, load_reach, load_subject
from glenoid.reach import Reach, plan_reach

__all__ = [
    "InputError",
    "Reach",
    "ReachInput",
    "Status",
    "SubjectInput",
    "__version__",
    "load_reach",
    "load_subject",
    "plan_reach",
]
