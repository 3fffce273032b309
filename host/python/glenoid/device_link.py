"""Whether a bridge drives the device that a motion was made for: joints, side, ranges and geometry, compared before arming."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator

import numpy as np

from glenoid.device_geometry import geometry
from glenoid.devices import JOINTS, Device
from glenoid.inputs import InputError
from glenoid.lcm_types import device_v1_t
from glenoid.publisher import text_of
from glenoid.reach import Array

#: digits that count: the angles of a file in degrees and the same in radians are one device
DIGITS = 9
#: rounding of a limit in degrees, rad
LIMIT_SLACK_RAD = 1e-4
SIDES = {device_v1_t.RIGHT: "right", device_v1_t.LEFT: "left"}


def fingerprint(device: Device) -> str:
    """SHA-256 of what turns an arm's motion into this device's joint angles: axes, mounts, girdle, side, ranges.

    Names, notes, origins of figures and gears are left out: the bridge has gears of its own.

    Raises:
        InputError: the device is a template.

    """
    figures, girdle = geometry(device), device.data.girdle
    numbers = {
        name: [f"{value + 0.0:.{DIGITS}g}" for value in np.round(np.ravel(values), DIGITS)]
        for name, values in vars(figures).items()
    }
    told = {"format": 1, "joints": JOINTS, "side": device.data.side, "girdle": girdle.model_dump(mode="json")} | numbers
    return hashlib.sha256(json.dumps(told, sort_keys=True).encode()).hexdigest()


def joint_names(told: device_v1_t) -> list[str]:
    """Of the bridge's configuration, in the order of every message."""
    return [text_of(name) for name in told.joint_name[: told.joint_count]]


def differences(told: device_v1_t, device: Device, arm: str) -> Iterator[str]:
    """What the bridge drives and what `device` on a person's `arm` needs, where they differ; a sentence each."""
    if (names := joint_names(told)) != list(JOINTS):
        yield f"joints: the bridge drives {', '.join(names)}; the device's are {', '.join(JOINTS)}, in this order"
    if (side := SIDES.get(told.side, "unknown")) != arm:
        yield f"side: the bridge drives a {side} device, the motion is for a {arm} arm"
    if (hash_told := text_of(told.device_sha256)) and hash_told != (own := fingerprint(device)):
        yield (
            f"device: the bridge's configuration is for {text_of(told.device)} ({hash_told[:12]}), this is "
            f"{device.path.stem} ({own[:12]}); a configuration for it says "
            f"device: {{name: {device.path.stem}, sha256: {own}}}"
        )
    figures = geometry(device)
    for k, name in enumerate(names):
        if k >= len(JOINTS) or name != JOINTS[k]:
            continue
        low, high = told.lower_rad[k], told.upper_rad[k]
        if low < figures.lower_rad[k] - LIMIT_SLACK_RAD or high > figures.upper_rad[k] + LIMIT_SLACK_RAD:
            yield (
                f"{name}: the bridge allows {low:.4g} to {high:.4g} rad, the device's range is "
                f"{figures.lower_rad[k]:.4g} to {figures.upper_rad[k]:.4g} rad"
            )


def require_same(told: device_v1_t, device: Device, arm: str) -> None:
    """InputError with every difference, a line each."""
    if found := list(differences(told, device, arm)):
        raise InputError(
            "\n".join([f"{device.path}: the bridge '{text_of(told.exoskeleton)}' drives another device", *found])
        )


def require_within(told: device_v1_t, position_rad: Array) -> None:
    """InputError where a motion (rows of joint angles) leaves the bridge's limits: it would be cut off there."""
    names = joint_names(told)
    lowest, highest = position_rad.min(axis=0), position_rad.max(axis=0)
    found = [
        f"{names[k]}: the motion goes from {lowest[k]:.4g} to {highest[k]:.4g} rad, the bridge allows "
        f"{told.lower_rad[k]:.4g} to {told.upper_rad[k]:.4g} rad"
        for k in range(min(len(names), position_rad.shape[1]))
        if lowest[k] < told.lower_rad[k] - LIMIT_SLACK_RAD or highest[k] > told.upper_rad[k] + LIMIT_SLACK_RAD
    ]
    if found:
        raise InputError("\n".join(found))
