"""A device on the core: settings, how much of a person's postures it reaches, and how it follows a planned reach."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from glenoid import _core
from glenoid.device_geometry import Array, geometry, require_side
from glenoid.devices import JOINTS, Device
from glenoid.inputs import InputError, ReachInput, SubjectInput
from glenoid.settings import core_limits, core_rhythm, core_subject

COVERAGE_SAMPLES = 20_000
COVERAGE_SEED = 20
COVERAGE_MARGIN_RAD = float(np.deg2rad(10.0))
NEAR_SINGULAR_RAD = float(np.deg2rad(5.0))


def core_exo(device: Device, subject: SubjectInput) -> _core.ExoSettings:
    """The device as the core takes it. InputError if it is a template, for the other arm, or refused by the core."""
    require_side(device, subject.arm)
    figures, data = geometry(device), device.data
    out = _core.ExoSettings()
    out.axes, out.base_rad, out.cuff_rad = figures.axes, figures.base_rad, figures.cuff_rad
    out.girdle_order = getattr(_core.GirdleOrder, data.girdle.order)
    out.girdle_drives = getattr(_core.GirdleDrives, data.girdle.drives)
    out.base_follows_girdle = data.girdle.base_follows
    out.girdle_link_m = data.girdle.link_m
    out.min_singularity_rad = float(np.deg2rad(data.shoulder.min_singularity_deg))
    out.lower_rad = np.maximum(figures.lower_rad, -_core.NO_EXO_LIMIT_RAD)
    out.upper_rad = np.minimum(figures.upper_rad, _core.NO_EXO_LIMIT_RAD)
    model_of(device, out, np.array([0.17, 0.0, 0.0]))
    return out


def model_of(device: Device, settings: _core.ExoSettings, centre_m: Array) -> _core.ExoModel:
    """The device's model; InputError names the file."""
    try:
        return _core.ExoModel(settings, centre_m)
    except ValueError as error:
        raise InputError("\n".join(f"{device.path}: {line}" for line in str(error).splitlines())) from error


def random_postures(subject: SubjectInput, count: int, seed: int) -> Array:
    """Postures (theta, eta, zeta, phi), rad, whose four limited angles are uniform within the person's limits."""
    limits = core_limits(subject)
    theta, eta, tau, phi = np.random.default_rng(seed).uniform(limits.lower_rad, limits.upper_rad, (count, 4)).T
    return np.column_stack([theta, eta, tau - eta, phi])


@dataclass(frozen=True)
class Coverage:
    """Shares of random arm postures, 0..1.

    reached: T has a solution; with_margin: and the edge of its reach is at least 10 deg of rotation away;
    within_ranges: and the device's joint ranges hold as well; near_singular: of those reached, less than 5 deg away.
    """

    samples: int
    reached: float
    with_margin: float
    within_ranges: float
    near_singular: float


def coverage(device: Device, subject: SubjectInput, count: int = COVERAGE_SAMPLES) -> Coverage:
    """How much of a person's range of motion the device reaches; random, with a fixed seed."""
    scaled = _core.scale_subject(core_subject(subject))
    rhythm = _core.Rhythm(core_rhythm(ReachInput().rhythm), scaled.shoulder_distance_m)
    start = _core.posture_from_angles(np.array(ReachInput().start_rad))
    model = model_of(device, core_exo(device, subject), rhythm.position(start.R_TU[:, 2]))
    found = _core.map_postures(model, rhythm, random_postures(subject, count, COVERAGE_SEED))
    margin = found["margin_rad"]
    reached = margin >= 0.0
    near = found["singularity_rad"][reached] < NEAR_SINGULAR_RAD
    return Coverage(
        samples=count,
        reached=float(reached.mean()),
        with_margin=float((margin >= COVERAGE_MARGIN_RAD).mean()),
        within_ranges=float((reached & (found["limit_margin_rad"] >= 0.0)).mean()),
        near_singular=float(near.mean()) if reached.any() else 0.0,
    )


@dataclass(frozen=True)
class DeviceMotion:
    """How a device follows one path. Arrays have a row per value of the path parameter.

    status: Ok; ExoInfeasible, and the joints are then those of the edge of reach, and `check` says where and by how much;
    or another one if the path is no motion.
    """

    device: Device
    settings: _core.ExoSettings
    status: _core.Status
    q_rad: Array
    residual_m: Array
    margin_rad: Array
    singularity_rad: Array
    check: _core.ExoPathCheck

    def summary(self, samples: dict[str, Array]) -> dict[str, Any]:
        """Worst values of the whole motion as plain data; mm and rad."""
        limit = self.check.limit_margin_rad
        return {
            "name": self.device.data.name,
            "branch": self.check.guide.branch.name,
            "least_margin_rad": self.check.margin_rad,
            "least_margin_at": self.check.margin_at,
            "least_singularity_rad": self.check.singularity_rad,
            "least_singularity_at": self.check.singularity_at,
            "least_range_margin_rad": limit if limit < _core.NO_EXO_LIMIT_RAD else None,
            "least_range_joint": JOINTS[self.check.limit_joint] if limit < _core.NO_EXO_LIMIT_RAD else None,
            "largest_residual_mm": 1e3 * float(samples["exo_residual_m"].max()),
            "largest_misalignment_mm": 1e3 * float(samples["misalignment_m"].max()),
        }


def follow(
    device: Device,
    settings: _core.ExoSettings,
    arm: _core.ArmModel,
    path: _core.GeodesicPath,
    start_rad: Array,
    progress: Array,
) -> DeviceMotion:
    """The device along a path, at values of its parameter; the arm starts at rest in start_rad."""
    posture = _core.posture_from_angles(start_rad)
    centre = arm.rhythm.position(posture.R_TU[:, 2])
    model = model_of(device, settings, centre)
    _, start = _core.choose_branch(model, posture, centre)
    status, check = _core.check_path(model, path, arm.rhythm, start, False)
    found = _core.map_path(model, path, arm.rhythm, check.guide, progress)
    return DeviceMotion(
        device=device,
        settings=settings,
        status=status,
        q_rad=found["q_rad"],
        residual_m=found["residual_m"],
        margin_rad=found["margin_rad"],
        singularity_rad=found["singularity_rad"],
        check=check,
    )
