"""The arm of the scenario's person in its exoskeleton, as the load that couples the drives; docs/drives.md."""

from __future__ import annotations

from typing import Any

import yaml

from glenoid import _core
from glenoid.devices import load_device
from glenoid.exo import core_exo
from glenoid.inputs import InputError
from glenoid.rehearse.motion import Motion
from glenoid.rehearse.scenario import Scenario
from glenoid.settings import core_subject


def parts(scenario: Scenario, motion: Motion) -> tuple[_core.ScaledArm, _core.ExoSettings, float]:
    """Segments, device, and how far its shoulder stands from the fixed trunk point, m: its link, or as at the start."""
    exo = core_exo(load_device(scenario.data.exoskeleton), scenario.subject)
    fixed = exo.girdle_drives == _core.GirdleDrives.NoLength and exo.girdle_link_m > 0.0
    length_m = exo.girdle_link_m if fixed else float(motion.samples["girdle"][0][2])
    return _core.scale_subject(core_subject(scenario.subject)), exo, length_m


def arm_load(scenario: Scenario, motion: Motion) -> _core.ArmLoad | None:
    """The load in virtual time; None where the scenario has none. InputError where the model lacks the device's girdle."""
    if scenario.data.drives.load == "none":
        return None
    try:
        return _core.ArmLoad(*parts(scenario, motion))
    except ValueError as error:
        raise InputError(f"{scenario.path}: drives.load = 'arm': {error}") from error


def segment_of(segment: _core.Segment) -> dict[str, Any]:
    """One segment in plain data."""
    return {
        "length_m": segment.length_m,
        "mass_kg": segment.mass_kg,
        "com_m": segment.com_m,
        "inertia_kg_m2": segment.inertia_kg_m2.tolist(),
    }


def load_yaml(scenario: Scenario, motion: Motion) -> str | None:
    """The same as the file that `glenoid-drives --load` reads; None where the scenario has no load."""
    load = arm_load(scenario, motion)
    if load is None:
        return None
    arm, exo, length_m = parts(scenario, motion)
    data = {
        "upper_arm": segment_of(arm.upper_arm),
        "forearm": segment_of(arm.forearm),
        "exoskeleton": {
            **{f"axis_{k}": axis.tolist() for k, axis in enumerate(exo.axes, start=1)},
            "base_rad": exo.base_rad.tolist(),
            "cuff_rad": exo.cuff_rad.tolist(),
            "girdle_order": exo.girdle_order.name,
            "girdle_drives": exo.girdle_drives.name,
            "base_follows_girdle": exo.base_follows_girdle,
        },
        "girdle_length_m": length_m,
        "gravity_m_per_s2": load.gravity_m_per_s2,
        "joints": [
            {"node": joint["node"], "sign": joint["sign"], "offset_rad": joint["offset_rad"]}
            for joint in scenario.config.joints
        ],
    }
    return yaml.safe_dump(data, sort_keys=False)
