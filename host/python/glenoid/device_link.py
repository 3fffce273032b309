"""Whether a bridge drives the device that a motion was made for: joints, side, ranges and geometry, compared before arming."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from glenoid import _core
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


@dataclass(frozen=True)
class Driven:
    """What a bridge drives; joints in the order of every message. `device` and `device_sha256` are empty where it does not say."""

    exoskeleton: str
    device: str
    device_sha256: str
    side: str
    joints: tuple[str, ...]
    lower_rad: tuple[float, ...]
    upper_rad: tuple[float, ...]


def heard(told: device_v1_t) -> Driven:
    """As the bridge tells it."""
    n = told.joint_count
    return Driven(
        exoskeleton=text_of(told.exoskeleton),
        device=text_of(told.device),
        device_sha256=text_of(told.device_sha256),
        side=SIDES.get(told.side, "unknown"),
        joints=tuple(text_of(name) for name in told.joint_name[:n]),
        lower_rad=tuple(told.lower_rad[:n]),
        upper_rad=tuple(told.upper_rad[:n]),
    )


def configured(config: _core.BridgeConfig) -> Driven:
    """As a configuration says it."""
    return Driven(
        exoskeleton=config.name,
        device=config.device,
        device_sha256=config.device_sha256,
        side=config.side,
        joints=tuple(str(joint["name"]) for joint in config.joints),
        lower_rad=tuple(float(joint["lower_rad"]) for joint in config.joints),
        upper_rad=tuple(float(joint["upper_rad"]) for joint in config.joints),
    )


def differences(driven: Driven, device: Device, arm: str) -> Iterator[str]:
    """What the bridge drives and what `device` on a person's `arm` needs, where they differ; a sentence each."""
    if driven.joints != JOINTS:
        yield f"joints: the bridge drives {', '.join(driven.joints)}; the device's are {', '.join(JOINTS)}, in this order"
    if driven.side != arm:
        yield f"side: the bridge drives a {driven.side} device, the motion is for a {arm} arm"
    if driven.device_sha256 and driven.device_sha256 != (own := fingerprint(device)):
        yield (
            f"device: the bridge's configuration is for {driven.device} ({driven.device_sha256[:12]}), this is "
            f"{device.path.stem} ({own[:12]}); a configuration for it says "
            f"device: {{name: {device.path.stem}, sha256: {own}}}"
        )
    figures = geometry(device)
    for k, (name, low, high) in enumerate(zip(driven.joints, driven.lower_rad, driven.upper_rad, strict=True)):
        if k >= len(JOINTS) or name != JOINTS[k]:
            continue
        if low < figures.lower_rad[k] - LIMIT_SLACK_RAD or high > figures.upper_rad[k] + LIMIT_SLACK_RAD:
            yield (
                f"{name}: the bridge allows {low:.4g} to {high:.4g} rad, the device's range is "
                f"{figures.lower_rad[k]:.4g} to {figures.upper_rad[k]:.4g} rad"
            )


def require_same(driven: Driven, device: Device, arm: str) -> None:
    """InputError with every difference, a line each."""
    if found := list(differences(driven, device, arm)):
        raise InputError("\n".join([f"{device.path}: the bridge '{driven.exoskeleton}' drives another device", *found]))


def require_within(driven: Driven, position_rad: Array) -> None:
    """InputError where a motion (rows of joint angles) leaves the bridge's limits: it would be cut off there."""
    lowest, highest = position_rad.min(axis=0), position_rad.max(axis=0)
    limits = zip(driven.joints, driven.lower_rad, driven.upper_rad, lowest, highest, strict=False)
    found = [
        f"{name}: the motion goes from {low:.4g} to {high:.4g} rad, the bridge allows {lower:.4g} to {upper:.4g} rad"
        for name, lower, upper, low, high in limits
        if low < lower - LIMIT_SLACK_RAD or high > upper + LIMIT_SLACK_RAD
    ]
    if found:
        raise InputError("\n".join(found))
