"""Subjects and devices as parameters of the FMU; needs no compiled module."""

from __future__ import annotations

from typing import Any

import numpy as np

from glenoid.device_geometry import geometry
from glenoid.devices import Device
from glenoid.inputs import SubjectInput

GIRDLE_ORDER = {"ProtractionFirst": 1, "ElevationFirst": 2}
#: items of the FMU; a device's file calls the last one NoDrives
GIRDLE_DRIVES = {"Full": 1, "NoLength": 2, "VerticalOnly": 3, "None": 4}
#: a range that begins or ends here is none, rad; as kNoExoLimit of the core
NO_RANGE_RAD = 1e9
LENGTHS = {
    "subject.upperArmLength": "upper_arm_length_m",
    "subject.forearmLength": "forearm_length_m",
    "subject.shoulderDistance": "shoulder_distance_m",
}


def numbered(name: str, values: Any) -> dict[str, float]:
    """Scalars of a vector variable: name[1], name[2], ..."""
    return {f"{name}[{k}]": float(value) for k, value in enumerate(values, start=1)}


def subject_parameters(subject: SubjectInput) -> dict[str, Any]:
    """Every subject.* and limits.* parameter; a length of 0 is scaled by the FMU."""
    values: dict[str, Any] = {
        "subject.stature": subject.stature_m,
        "subject.mass": subject.mass_kg,
        "subject.female": subject.sex == "female",
        "subject.leftArm": subject.arm == "left",
    }
    values |= {name: getattr(subject, field) or 0.0 for name, field in LENGTHS.items()}
    lower, upper = subject.limits_deg.as_rad()
    return values | numbered("limits.lower", lower) | numbered("limits.upper", upper)


def subject_lacks(subject: SubjectInput) -> list[str]:
    """Given figures that the FMU has no parameter for."""
    fields = subject.model_dump(exclude_none=True)
    return [name for name in fields if name.endswith(("_arm_mass_kg", "forearm_mass_kg", "_com_m", "_inertia_kg_m2"))]


def device_parameters(device: Device) -> dict[str, Any]:
    """Every exo.* parameter. InputError for a template."""
    figures, girdle = geometry(device), device.data.girdle
    values: dict[str, Any] = {}
    for number, axis in enumerate(figures.axes, start=1):
        values |= numbered(f"exo.axis{number}", axis)
    values |= numbered("exo.base", figures.base_rad) | numbered("exo.cuff", figures.cuff_rad)
    values |= {
        "exo.girdleOrder": GIRDLE_ORDER[girdle.order],
        "exo.girdleDrives": GIRDLE_DRIVES["None" if girdle.drives == "NoDrives" else girdle.drives],
        "exo.girdleLink": girdle.link_m,
        "exo.baseFollowsGirdle": girdle.base_follows,
        "exo.minSingularity": float(np.deg2rad(device.data.shoulder.min_singularity_deg)),
    }
    values |= numbered("exo.lower", np.maximum(figures.lower_rad, -NO_RANGE_RAD))
    return values | numbered("exo.upper", np.minimum(figures.upper_rad, NO_RANGE_RAD))
