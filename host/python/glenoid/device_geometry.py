"""A device's axes, mounts and ranges as numbers in the frame of a right arm; needs no compiled module."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from glenoid.devices import JOINTS, Device, JointInput, ShoulderInput, in_rad
from glenoid.inputs import InputError

Array = NDArray[np.float64]
#: a rotation axis is an axial vector: its mirror image in x -> -x
MIRROR_AXIAL = np.array([1.0, -1.0, -1.0])


@dataclass(frozen=True)
class Geometry:
    """What T needs; a left device as its right-hand twin (docs/equations.md, X1).

    axes: (3, 3), a unit row per shoulder joint, base frame at zero. base_rad, cuff_rad: rotation vectors.
    lower_rad, upper_rad: (6,), infinite where the file states no range.
    """

    axes: Array
    base_rad: Array
    cuff_rad: Array
    lower_rad: Array
    upper_rad: Array


def rotation(vector_rad: Array) -> Array:
    """Rotation matrix of a rotation vector."""
    angle = float(np.linalg.norm(vector_rad))
    if angle == 0.0:
        return np.eye(3)
    x, y, z = vector_rad / angle
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross, dtype=float)


def axes_of(shoulder: ShoulderInput) -> Array:
    """Unit axes, rows.

    From angles: axis 1 is z; axis 2 is z turned by a12 about y (90 deg: x); axis 3 is axis 2 turned back by a23 about y
    and then by the twist about axis 2. So a12 = a23 = 90 deg without twist is (z, x, z).
    """
    if shoulder.axes is not None:
        return np.array(shoulder.axes)
    a12, a23, twist = (float(in_rad(shoulder, name) or 0.0) for name in ("a12", "a23", "twist"))
    second = np.array([np.sin(a12), 0.0, np.cos(a12)])
    third = np.array([np.sin(a12 - a23), 0.0, np.cos(a12 - a23)])
    return np.array([[0.0, 0.0, 1.0], second, rotation(twist * second) @ third])


def range_of(joint: JointInput) -> tuple[float, float]:
    """Range of a joint, rad; infinite where none is stated."""
    given = in_rad(joint, "range")
    return (-np.inf, np.inf) if given is None else (float(given[0]), float(given[1]))


def geometry(device: Device) -> Geometry:
    """The figures of a complete device. InputError names what is missing."""
    device.require_complete()
    data = device.data
    mirror = MIRROR_AXIAL if data.side == "left" else np.ones(3)
    mounts = [in_rad(data.mounts, name) for name in ("base", "cuff")]
    base, cuff = (np.zeros(3) if mount is None else np.array(mount, dtype=float) * mirror for mount in mounts)
    lower, upper = np.array([range_of(getattr(data.joints, joint)) for joint in JOINTS]).T
    return Geometry(axes_of(data.shoulder) * mirror, base, cuff, lower, upper)


def require_side(device: Device, arm: str) -> None:
    """InputError if the device is for the other arm."""
    if device.data.side not in ("either", arm):
        raise InputError(f"{device.path}: side = {device.data.side}: the subject's arm is the {arm} one")
