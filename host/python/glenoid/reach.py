"""One reach, planned by the core: the motion in time, the family it was chosen from, and what was shown about it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from glenoid import _core
from glenoid.inputs import ReachInput
from glenoid.settings import make_generator, mirrored_if_left

Array = NDArray[np.float64]
FAMILY_COUNT = 180
#: a shot with the refined path's own initial rates must arrive this near, rad (CVODE runs at 1e-11)
ARRIVAL_TOLERANCE_RAD = 1e-7
#: the planned path may lie this far from the shot, rad: ten times the tail at which the solver stops refining
DEVIATION_TOLERANCE_RAD = 1e-5
REFINED_TAIL = 1e-12
REFUSALS = ("TargetUnreachable", "LimitsInfeasible", "ExoInfeasible", "SolverFailed")


@dataclass(frozen=True)
class Verification:
    """Outcome of shooting the initial rates of the refined path with CVODE.

    arrival_rad: distance of the shot from the end posture. deviation_rad: largest distance of the planned path from the
    shot on the way. energy_drift: of the shot, relative.
    """

    arrival_rad: float
    deviation_rad: float
    energy_drift: float

    @property
    def passed(self) -> bool:
        """Whether the shot arrived and the plan lies on it."""
        return self.arrival_rad < ARRIVAL_TOLERANCE_RAD and self.deviation_rad < DEVIATION_TOLERANCE_RAD


@dataclass(frozen=True)
class Reach:
    """A planned reach. Arrays have a row per time; points in the thorax frame T, m; angles (theta, eta, zeta, phi)."""

    given: ReachInput
    status: str
    message: str
    time_s: Array
    samples: dict[str, Array]
    family: dict[str, Array]
    certificate: _core.Certificate
    generator: _core.MotionGenerator
    reach_margin_m: float
    best_margin: _core.LimitMargin

    @property
    def ok(self) -> bool:
        """Whether a motion was found."""
        return self.status == "ok"


def target_for_core(reach: ReachInput) -> Array:
    """Target in the frame of the core's right-arm models, m."""
    return mirrored_if_left(np.array(reach.target_m), reach.subject)


def plan_reach(reach: ReachInput, rate_hz: float = 100.0, exo: _core.ExoSettings | None = None) -> Reach:
    """Plans a reach and samples it.

    Args:
        reach: what to do; SI units and rad.
        rate_hz: samples per second, > 0.
        exo: the device that must follow; without one, a device that reaches everything.

    Raises:
        InputError: the core refuses a setting; the text names variable, value, unit and rule.

    """
    generator = make_generator(reach, exo)
    generator.command(0.0, np.array(reach.target_m))
    time_s = np.linspace(0.0, reach.duration_s, max(2, round(reach.duration_s * rate_hz) + 1))
    samples = generator.sample(time_s)
    name = _core.MotionStatus(int(samples["status"][0])).name
    start = _core.posture_from_angles(np.array(reach.start_rad))
    planner = _core.ReachPlanner()
    _, plan = planner.plan_minimum_energy(generator.arm, start, target_for_core(reach))
    _, family = planner.sample_family(generator.arm, start, target_for_core(reach), FAMILY_COUNT)
    return Reach(
        given=reach,
        status=name if name in REFUSALS else "ok",
        message=generator.message,
        time_s=time_s,
        samples=samples,
        family=family,
        certificate=generator.certificate,
        generator=generator,
        reach_margin_m=plan.reach_margin_m,
        best_margin=plan.best_margin,
    )


def rotation_between(first: Array, second: Array) -> float:
    """Angle of the rotation between two (3, 3) matrices, rad; accurate near 0."""
    return float(2.0 * np.arcsin(min(1.0, np.linalg.norm(first - second) / np.sqrt(8.0))))


def distance(first: _core.Posture, second: _core.Posture) -> float:
    """Larger of the angle between two upper arms and the difference of the elbow angles, rad."""
    return max(rotation_between(first.R_TU, second.R_TU), abs(first.phi_rad - second.phi_rad))


def verify(reach: Reach) -> Verification:
    """Integrates the equation of the path, with its lift, by SUNDIALS CVODE from the path's initial rates, and compares.

    The rates are those of the same path on a finer grid: a derivative at the end of a polynomial is the least accurate
    thing about it, and what is to be judged is the path.
    """
    arm, path = reach.generator.arm, reach.generator.path
    refined_status, refined = _core.refine_path(arm, path, REFINED_TAIL)
    options = _core.FollowOptions()
    options.lift_m = path.lift_m
    status, shot = _core.follow_geodesic(arm, path.posture(0.0), refined.start_rates(), options)
    if refined_status != _core.Status.Ok or status != _core.Status.Ok:
        return Verification(float("inf"), float("inf"), float("inf"))
    lambdas = np.linspace(0.0, 1.0, len(shot.postures))
    off = [distance(posture, path.posture(value)) for posture, value in zip(shot.postures, lambdas, strict=True)]
    return Verification(off[-1], max(off), shot.energy_drift)
