"""Many reaches in one call, for programs: `glenoid plan --batch TASKS.json --json`."""

from __future__ import annotations

import json
import math
import time
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from glenoid import _core
from glenoid.devices import Device
from glenoid.exo import core_exo, follow
from glenoid.inputs import MOST_TARGET_M, InputError, ReachInput, Real, Vector3, Vector4, Whole, explain, read_text
from glenoid.reach import Array
from glenoid.settings import core_limits, core_prior, core_rhythm, core_subject, mirrored_if_left, with_axial_factor
from glenoid.within_reach import plan_within_reach

SAMPLES = 101
#: no angle of a posture is written as more than this, whatever the turns of eta and zeta
MOST_ANGLE_RAD = 4.0 * math.pi
ANSWER_KEYS = ("q", "shoulder", "elbow", "wrist", "swivel", "energy", "iterations", "solve_us", "pulled_m")
#: only with a device: joints, rad (rows of exo.q), residual, m, distances to the edge of reach and to singular, rad
EXO_KEYS = ("exo_q", "exo_residual", "exo_margin", "exo_singularity", "exo_worst")


class TaskSubject(BaseModel):
    """What a task knows of its person beyond the common subject."""

    model_config = ConfigDict(extra="forbid")
    upper_arm_length_m: Real | None = None
    forearm_length_m: Real | None = None
    shoulder_distance_m: Real | None = None
    shoulder_start_m: Vector3 | None = None


class Task(BaseModel):
    """One reach of a batch; SI units and rad, points in T. A number that is not finite gives the status NotFinite."""

    model_config = ConfigDict(extra="forbid")
    id: str | Whole
    q0: Vector4
    target: Vector3
    q1: Vector4 | None = None
    subject: TaskSubject = TaskSubject()
    gh_path_m: list[Vector3] | None = Field(default=None, min_length=2)

    def is_finite(self) -> bool:
        """Whether every number of the task is."""
        rows = (self.q0, self.target, self.q1 or (), self.subject.shoulder_start_m or (), *(self.gh_path_m or ()))
        return all(math.isfinite(value) for row in rows for value in row)

    def refused(self) -> tuple[str, str] | None:
        """Status and message of a task that is not planned at all; None for the others."""
        if not self.is_finite():
            return "NotFinite", ""
        for name, angles in (("q0", self.q0), ("q1", self.q1 or ())):
            for k, value in enumerate(angles, start=1):
                if abs(value) > MOST_ANGLE_RAD:
                    rule = "must be within -4 pi to 4 pi; degrees in the file?"
                    return "OutOfRange", f"task {self.id!r}: {name}[{k}] = {value:g} rad: {rule}"
        if max(map(abs, self.target)) > MOST_TARGET_M:
            point = ", ".join(f"{value:g}" for value in self.target)
            rule = f"must lie within -{MOST_TARGET_M:g} to {MOST_TARGET_M:g} m; millimetres in the file?"
            return "OutOfRange", f"task {self.id!r}: target = ({point}) m: {rule}"
        return None


def each_once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """A JSON object whose keys differ. ValueError names one that stands twice."""
    out = dict(pairs)
    if len(out) < len(pairs):
        names = [name for name, _ in pairs]
        raise ValueError(f"{next(name for name in names if names.count(name) > 1)} stands twice in an object")
    return out


def read_tasks(path: Path) -> list[Any]:
    """The list of tasks, unchecked. InputError if the file does not hold a list."""
    text = read_text(path)
    try:
        data = json.loads(text, object_pairs_hook=each_once)
    except ValueError as error:
        raise InputError(f"{path}: not readable as JSON: {error}") from error
    except RecursionError as error:
        raise InputError(f"{path}: not readable as JSON: lists within lists without end") from error
    if not isinstance(data, list):
        raise InputError(f"{path}: the top level must be a list of tasks")
    return data


class BatchPlanner:
    """Plans tasks with common settings; the core's right-arm models see a left arm's task mirrored."""

    def __init__(self, common: ReachInput, device: Device | None = None) -> None:
        self.common = common
        self.device = device
        self.exo = core_exo(device, common.subject) if device is not None else None
        self.planner = _core.ReachPlanner()

    def own_side(self, points_m: Any) -> Array:
        """Points of T in the frame of a right arm, and back; the two are the same operation."""
        return mirrored_if_left(np.asarray(points_m, dtype=float), self.common.subject)

    def arm(self, task: Task) -> _core.ArmModel:
        """The arm of a task. A measured shoulder path replaces the rhythm; its end is the final posture's shoulder."""
        lengths = task.subject.model_dump(exclude={"shoulder_start_m"}, exclude_none=True)
        subject = self.common.subject.model_copy(update=lengths)
        scaled = with_axial_factor(_core.scale_subject(core_subject(subject)), self.common)
        settings = core_rhythm(self.common.rhythm)
        moving = self.common.metric == "movingShoulder"
        anchor = task.subject.shoulder_start_m
        if task.gh_path_m is not None:
            settings.model, moving, anchor = _core.RhythmModel.Fixed, False, task.gh_path_m[-1]
        rhythm = _core.Rhythm(settings, scaled.shoulder_distance_m)
        if anchor is not None:
            start = _core.posture_from_angles(np.array(task.q0))
            rhythm.anchor(start.R_TU[:, 2], self.own_side(anchor))
        return _core.make_arm_model(scaled, rhythm, core_limits(subject), moving)

    def plan(self, task: Task, arm: _core.ArmModel) -> tuple[_core.Status, _core.ReachPlan, float]:
        """To the given end posture, or with the common choice of the swivel angle; last, by how much the target was pulled in, m.

        Only targets of measured reaches are: those with the shoulder's centre at the start.
        """
        start = _core.posture_from_angles(np.array(task.q0))
        if task.q1 is not None:
            return *self.planner.plan_between(arm, start, _core.posture_from_angles(np.array(task.q1))), 0.0
        target, shoulder = self.own_side(task.target), task.subject.shoulder_start_m
        if shoulder is None or task.gh_path_m is not None:
            return *self.plan_to(arm, start, target), 0.0
        return plan_within_reach(lambda point: self.plan_to(arm, start, point), target, self.own_side(shoulder))

    def plan_to(
        self, arm: _core.ArmModel, start: _core.Posture, target_m: Array
    ) -> tuple[_core.Status, _core.ReachPlan]:
        """With the common choice of the swivel angle; the target in the frame of a right arm."""
        swivel = self.common.swivel
        if swivel.mode == "MinimumEnergy":
            return self.planner.plan_minimum_energy(arm, start, target_m)
        if swivel.mode == "Prescribed":
            return self.planner.plan_prescribed(arm, start, target_m, swivel.prescribed_rad)
        prior = _core.PosturePrior(core_prior(self.common), arm, start)
        return self.planner.plan_human_prior(arm, start, target_m, prior)

    def points(self, task: Task, arm: _core.ArmModel, path: _core.GeodesicPath, lambdas: Array) -> list[Array]:
        """Shoulder, elbow and wrist along the path in T, about the measured shoulder path where one is given."""
        points = [self.own_side(rows) for rows in path.points(arm, lambdas)]
        if task.gh_path_m is None:
            return points
        given = np.array(task.gh_path_m)
        known = np.linspace(0.0, 1.0, len(given))
        shift = np.column_stack([np.interp(lambdas, known, given[:, k]) for k in range(3)]) - points[0]
        return [rows + shift for rows in points]

    def answer(self, task: Task) -> dict[str, Any]:
        """Status and motion of a checked task; null where there is none."""
        arm = self.arm(task)
        begin_ns = time.perf_counter_ns()
        status, plan, pulled_m = self.plan(task, arm)
        solve_us = (time.perf_counter_ns() - begin_ns) / 1e3
        if status != _core.Status.Ok:
            return self.refusal(task.id, status.name)
        lambdas = np.linspace(0.0, 1.0, SAMPLES)
        q, _, _ = plan.path.angles(lambdas, np.array(task.q0))
        shoulder, elbow, wrist = (rows.tolist() for rows in self.points(task, arm, plan.path, lambdas))
        swivel = _core.swivel_angle(_core.forward_kinematics(arm, plan.path.posture(1.0)))
        values = (q.tolist(), shoulder, elbow, wrist, swivel, plan.path.energy_kg_m2, plan.certificate.iterations)
        out = {"id": task.id, "status": "ok"} | dict(zip(ANSWER_KEYS, (*values, solve_us, pulled_m), strict=True))
        return out | self.exo_answer(task, arm, plan.path, lambdas)

    def exo_answer(self, task: Task, arm: _core.ArmModel, path: _core.GeodesicPath, lambdas: Array) -> dict[str, Any]:
        """How the device follows the arm's path, if there is one; the joints are null where it cannot.

        A measured shoulder path gives no rhythm for the girdle to follow: its exo_status is Unsupported.
        """
        if self.device is None or self.exo is None:
            return {}
        nothing = dict.fromkeys(EXO_KEYS)
        if task.gh_path_m is not None:
            return {"exo_status": "Unsupported"} | nothing
        motion = follow(self.device, self.exo, arm, path, np.array(task.q0), lambdas)
        if motion.status not in (_core.Status.Ok, _core.Status.ExoInfeasible):
            return {"exo_status": motion.status.name} | nothing
        shoulder = path.points(arm, lambdas)[0]
        misalignment = np.linalg.norm(shoulder - shoulder[0], axis=1)
        worst = motion.summary({"exo_residual_m": motion.residual_m, "misalignment_m": misalignment})
        refused = motion.status == _core.Status.ExoInfeasible
        worst |= {"refusal": motion.check.refusal.name if refused else None}
        if refused:
            return {"exo_status": motion.status.name} | nothing | {"exo_worst": worst}
        arrays = (motion.q_rad, motion.residual_m, motion.margin_rad, motion.singularity_rad)
        values = (*(rows.tolist() for rows in arrays), worst)
        return {"exo_status": "ok"} | dict(zip(EXO_KEYS, values, strict=True))

    def refusal(self, task_id: Any, status: str, message: str = "") -> dict[str, Any]:
        """The answer to a task without a motion."""
        out = {"id": task_id, "status": status} | dict.fromkeys(ANSWER_KEYS)
        out |= dict.fromkeys(("exo_status", *EXO_KEYS)) if self.device is not None else {}
        return out | {"message": message} if message else out


def run_batch(tasks: list[Any], common: ReachInput, device: Device | None = None) -> list[dict[str, Any]]:
    """One answer per task, in order; a bad task is answered with a status and disturbs no other.

    Raises:
        InputError: the device is a template, for the other arm, or refused by the core.

    """
    planner = BatchPlanner(common, device)
    answers = []
    for index, data in enumerate(tasks):
        name = data.get("id", index) if isinstance(data, dict) else index
        try:
            task = Task.model_validate(data)
            refused = task.refused()
            answers.append(planner.refusal(name, *refused) if refused is not None else planner.answer(task))
        except ValidationError as error:
            answers.append(planner.refusal(name, "InvalidInput", str(explain(error, f"task {name!r}"))))
        except ValueError as error:
            answers.append(planner.refusal(name, "InvalidInput", f"task {name!r}: {error}"))
    return answers
