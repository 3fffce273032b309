"""The models that are compared: each predicts a whole movement from start, target, lengths and duration.

An oracle is told more, as its name says; it bounds what a model without that error could reach.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from glenoid import _core
from glenoid.reach import Array
from glenoid.validate.clock import Clock, homing, minimum_jerk, shown_shares
from glenoid.validate.coefficients import Coefficients, hand_progress
from glenoid.validate.geometry import angles_of_points, elbow_on_circle, swivel_of_points
from glenoid.validate.movements import Movement
from glenoid.validate.score import Trajectory
from glenoid.within_reach import plan_within_reach

#: a target out of reach is brought nearer to the start shoulder by so much at most, m; how often and how far is reported
MOST_PULL_M = 0.25
#: a constant swivel angle, rad, the median of the measured ends
CONSTANT_SWIVEL_RAD = np.deg2rad(36.0)
ALMOST_STRAIGHT = 0.999
#: the axial factor (M5, M6) whose paths are nearest to people's
HUMAN_AXIAL_FACTOR = _core.HUMAN_AXIAL_FACTOR


class Course(Protocol):
    """A path over lambda in [0, 1]."""

    def at(self, lambdas: Array) -> Trajectory:
        """Points and angles at these lambdas."""


@dataclass(frozen=True)
class Prediction:
    """A predicted movement: path, its clock (None: progress is told), and by how much the target had to be moved, m."""

    course: Course
    clock: Clock | None
    pulled_m: float = 0.0
    certificate: _core.Certificate | None = None
    told: Array | None = None

    def shares(self, duration_s: float) -> Array:
        """Shares of the path, SAMPLES of them, over the part of the movement that a recording of this duration shows."""
        if self.clock is None:
            assert self.told is not None
            return self.told
        return shown_shares(self.clock, lambda way: self.course.at(way).wrist_m, duration_s)


@dataclass(frozen=True)
class GeodesicCourse:
    """A path of the core about the rhythm's shoulder."""

    path: _core.GeodesicPath
    arm: _core.ArmModel
    start_q_rad: Array

    def at(self, lambdas: Array) -> Trajectory:
        """Points and angles at these lambdas."""
        q, _, _ = self.path.angles(lambdas, self.start_q_rad)
        shoulder, elbow, wrist = self.path.points(self.arm, lambdas)
        return Trajectory(shoulder, elbow, wrist, q)


@dataclass(frozen=True)
class JointLine:
    """A straight line between two postures in (theta, eta, zeta, phi) about a fixed shoulder."""

    start_q_rad: Array
    end_q_rad: Array
    shoulder_m: Array
    upper_m: float
    fore_m: float

    def at(self, lambdas: Array) -> Trajectory:
        """Points and angles at these lambdas."""
        q = self.start_q_rad + lambdas[:, None] * (self.end_q_rad - self.start_q_rad)
        shoulder = np.broadcast_to(self.shoulder_m, (len(q), 3))
        R = np.stack([_core.posture_from_angles(row).R_TU for row in q])
        elbow = shoulder - self.upper_m * R[:, :, 2]
        fore = -np.sin(q[:, 3:]) * R[:, :, 1] + np.cos(q[:, 3:]) * R[:, :, 2]
        return Trajectory(shoulder, elbow, elbow - self.fore_m * fore, q)


@dataclass(frozen=True)
class HandLine:
    """A straight line of the wrist about a fixed shoulder, the swivel angle constant."""

    shoulder_m: Array
    start_wrist_m: Array
    end_wrist_m: Array
    upper_m: float
    fore_m: float
    swivel_rad: float

    def at(self, lambdas: Array) -> Trajectory:
        """Points and angles at these lambdas."""
        wrist = self.start_wrist_m + lambdas[:, None] * (self.end_wrist_m - self.start_wrist_m)
        shoulder = np.broadcast_to(self.shoulder_m, wrist.shape)
        elbow = np.array(
            [elbow_on_circle(self.shoulder_m, w, self.upper_m, self.fore_m, self.swivel_rad) for w in wrist]
        )
        return Trajectory(shoulder, elbow, wrist, angles_of_points(shoulder, elbow, wrist))


@dataclass(frozen=True)
class Model:
    """What is compared. `oracle`: told the measured "end" posture, "shoulder" path and "time" course as listed."""

    about: str
    rhythm: str = "Measured"
    swivel: str = "HumanPrior"
    moving: bool = True
    axial_factor: float = 1.0
    lift: bool = False
    homing: bool = False
    line: str = ""
    oracle: tuple[str, ...] = ()


#: what glenoid offers
HUMAN = Model("the same with the homing time course", axial_factor=HUMAN_AXIAL_FACTOR, lift=True, homing=True)
MODELS = {
    "joint-line": Model("straight joint line, fixed shoulder, constant swivel", "Fixed", "Constant", line="joint"),
    "hand-line": Model("straight hand line, fixed shoulder, own start swivel kept", "Fixed", "Start", line="hand"),
    "fixed-shoulder": Model("geodesic of least energy, fixed shoulder", "Fixed", "MinimumEnergy", moving=False),
    "paper": Model("the paper's method: eq. (1), geodesic of least energy", "SoltaniZarrin2017", "MinimumEnergy"),
    "rhythm": Model("measured rhythm, least energy", swivel="MinimumEnergy"),
    "prior": Model("measured rhythm and posture prior"),
    "axial": Model("the same, turning dearer: axial factor 3", axial_factor=HUMAN_AXIAL_FACTOR),
    "lifted": Model("the same, the hand lifted on level ways", axial_factor=HUMAN_AXIAL_FACTOR, lift=True),
    "glenoid": HUMAN,
    "oracle-end": replace(HUMAN, about="glenoid, told the end posture", oracle=("end",)),
    "oracle-end-shoulder": replace(HUMAN, about="and the shoulder's path", oracle=("end", "shoulder")),
    "oracle-all": replace(HUMAN, about="and the hand's progress", oracle=("end", "shoulder", "time")),
    "oracle-geodesic": Model("fixed-shoulder metric, told end and shoulder", moving=False, oracle=("end", "shoulder")),
    "oracle-geodesic-fixed": Model("fixed shoulder, told the end", "Fixed", moving=False, oracle=("end",)),
    "oracle-joint-line": Model("straight joint line, told end and shoulder", line="joint", oracle=("end", "shoulder")),
}


class Predictor:
    """Predicts movements with one core planner. Lengths and the start are the movement's own; masses are scaled."""

    def __init__(self, limits: _core.JointLimits | None = None) -> None:
        self.planner = _core.ReachPlanner()
        self.limits = limits if limits is not None else measured_limits()

    def arm(self, model: Model, movement: Movement, fitted: Coefficients) -> _core.ArmModel:
        """The movement's arm, its rhythm anchored at the shoulder of the start (or of the end where that is told)."""
        subject = _core.Subject()
        subject.upper_arm_length_m = movement.upper_arm_length_m
        subject.forearm_length_m = movement.forearm_length_m
        subject.shoulder_distance_m = float(np.linalg.norm(movement.shoulder_m[0]))
        scaled = _core.scale_subject(subject)
        _core.apply_axial_factor(scaled, model.axial_factor)
        told = "shoulder" in model.oracle
        settings = _core.RhythmSettings()
        settings.model = _core.RhythmModel.Fixed if told else getattr(_core.RhythmModel, model.rhythm)
        settings.measured = fitted.measured()
        rhythm = _core.Rhythm(settings, scaled.shoulder_distance_m)
        start = _core.posture_from_angles(movement.q_rad[0])
        rhythm.anchor(start.R_TU[:, 2], movement.shoulder_m[-1 if told else 0])
        return _core.make_arm_model(scaled, rhythm, self.limits, model.moving and not told)

    def predict(self, model: Model, movement: Movement, fitted: Coefficients) -> Prediction:
        """The whole movement. RuntimeError if no posture is found even for a target pulled in by MOST_PULL_M."""
        if model.line == "hand" or (model.line == "joint" and not model.oracle):
            return straight_line(model, movement)
        if model.line == "joint":
            ends = movement.q_rad[0], movement.q_rad[-1]
            lengths = movement.upper_arm_length_m, movement.forearm_length_m
            return Prediction(JointLine(*ends, movement.shoulder_m[0], *lengths), minimum_jerk)
        arm = self.arm(model, movement, fitted)
        plan, pulled = self.plan(model, movement, arm, fitted)
        course = GeodesicCourse(plan.path, arm, movement.q_rad[0])
        told = hand_progress(movement) if "time" in model.oracle else None
        clock = None if told is not None else homing(fitted.tail) if model.homing else minimum_jerk
        return Prediction(course, clock, pulled, plan.certificate, told)

    def plan(
        self, model: Model, movement: Movement, arm: _core.ArmModel, fitted: Coefficients
    ) -> tuple[_core.ReachPlan, float]:
        """The path, and by how much the target had to be pulled in, m."""
        start = _core.posture_from_angles(movement.q_rad[0])
        prior = _core.PosturePrior(fitted.prior(model.lift), arm, start)
        if "end" in model.oracle:
            end = _core.posture_from_angles(movement.q_rad[-1])
            lift_m = prior.lift(movement.wrist_m[0], movement.wrist_m[-1])
            status, plan = self.planner.plan_between(arm, start, end, lift_m)
            if status != _core.Status.Ok:
                raise RuntimeError(f"{movement.name}: {status.name}")
            return plan, 0.0

        def plan_to(target_m: Array) -> tuple[_core.Status, _core.ReachPlan]:
            if model.swivel == "HumanPrior":
                return self.planner.plan_human_prior(arm, start, target_m, prior)
            return self.planner.plan_minimum_energy(arm, start, target_m)

        status, plan, pulled = plan_within_reach(plan_to, movement.wrist_m[-1], movement.shoulder_m[0], MOST_PULL_M)
        if status != _core.Status.Ok:
            raise RuntimeError(f"{movement.name}: {status.name}")
        return plan, pulled


def straight_line(model: Model, movement: Movement) -> Prediction:
    """Baselines about the shoulder of the start, without the core; a target out of reach is pulled in."""
    shoulder, wrist = movement.shoulder_m[0], movement.wrist_m[-1]
    upper, fore = movement.upper_arm_length_m, movement.forearm_length_m
    length = float(np.linalg.norm(wrist - shoulder))
    most = ALMOST_STRAIGHT * (upper + fore)
    end = shoulder + (wrist - shoulder) * min(1.0, most / length)
    pulled = max(0.0, length - most)
    if model.line == "hand":
        own = swivel_of_points(shoulder, movement.elbow_m[0], movement.wrist_m[0])
        return Prediction(HandLine(shoulder, movement.wrist_m[0], end, upper, fore, own), minimum_jerk, pulled)
    elbow = elbow_on_circle(shoulder, end, upper, fore, float(CONSTANT_SWIVEL_RAD))
    start = shoulder, movement.elbow_m[0], movement.wrist_m[0]
    both = angles_of_points(*(np.stack(pair) for pair in zip(start, (shoulder, elbow, end), strict=True)))
    last = both[1] + (movement.q_rad[0] - both[0])
    return Prediction(JointLine(movement.q_rad[0], last, shoulder, upper, fore), minimum_jerk, pulled)


def measured_limits() -> _core.JointLimits:
    """Limits of healthy adults with room for what their markers show: the default box widened by 10 deg."""
    limits = _core.JointLimits()
    room = np.deg2rad([0.0, 10.0, 10.0, 0.0]), np.deg2rad([10.0, 10.0, 10.0, 10.0])
    limits.lower_rad = limits.lower_rad - room[0]
    limits.upper_rad = limits.upper_rad + room[1]
    return limits
