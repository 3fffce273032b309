"""A case becomes a row; many of them on all cores, in the order of the study."""

from __future__ import annotations

import math
import multiprocessing
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from typing import Any

import numpy as np

from glenoid import _core
from glenoid.devices import JOINTS, Device
from glenoid.exo import DeviceMotion, core_exo, follow
from glenoid.inputs import InputError, ReachInput
from glenoid.reach import REFUSALS, Array
from glenoid.settings import make_generator
from glenoid.sweep.study import Case, Study, cases_of, device_by_name, reach_of

SAMPLES = 101
#: cases that a process takes at once: starting one costs as much as hundreds of them
CHUNK = 64
ARM_FIGURES = ("energy_kg_m2", "swivel_rad", "limit_margin_rad", "misalignment_m")
DEVICE_FIGURES = ("exo_margin_rad", "exo_singularity_rad", "exo_residual_m")
JOINT_FIGURES = tuple(
    f"exo_{joint}_{figure}" for joint in JOINTS for figure in ("least_rad", "most_rad", "peak_rad_per_s")
)
FIGURES = (*ARM_FIGURES, *DEVICE_FIGURES, *JOINT_FIGURES)
Row = dict[str, Any]


def arm_figures(generator: _core.MotionGenerator, samples: dict[str, Array]) -> Row:
    """Energy of the path, swivel angle at its end, distance to the nearest limit on the way, way of the shoulder centre."""
    worst = generator.certificate.limits.worst.margin_rad
    return {
        "hessian_positive": generator.certificate.hessian_positive,
        "energy_kg_m2": generator.path.energy_kg_m2,
        "swivel_rad": float(samples["swivel_rad"][-1]),
        "limit_margin_rad": worst,
        "misalignment_m": float(samples["misalignment_m"].max()),
    }


def device_figures(motion: DeviceMotion) -> Row:
    """Least distances to the edge of reach and to singular; what the girdle's drives leave at most."""
    return {
        "exo_margin_rad": motion.check.margin_rad,
        "exo_singularity_rad": motion.check.singularity_rad,
        "exo_residual_m": float(motion.residual_m.max()),
    }


def joint_figures(samples: dict[str, Array]) -> Row:
    """Range and peak speed of every joint of the device."""
    out: Row = {}
    for k, joint in enumerate(JOINTS):
        q, speed = samples["exo_q_rad"][:, k], np.abs(samples["exo_dq_rad_per_s"][:, k])
        out[f"exo_{joint}_least_rad"], out[f"exo_{joint}_most_rad"] = float(q.min()), float(q.max())
        out[f"exo_{joint}_peak_rad_per_s"] = float(speed.max())
    return out


def moved(reach: ReachInput, exo: _core.ExoSettings | None) -> tuple[_core.MotionGenerator, str]:
    """The generator with the reach accepted or refused, and the status: ok or the refusal's name."""
    generator = make_generator(reach, exo)
    generator.command(0.0, np.array(reach.target_m))
    name = _core.MotionStatus(int(generator.sample(np.zeros(1))["status"][0])).name
    return generator, name if name in REFUSALS else "ok"


def followed(
    reach: ReachInput, device: Device, exo: _core.ExoSettings, generator: _core.MotionGenerator
) -> DeviceMotion:
    """The device along the arm's path."""
    lambdas = np.linspace(0.0, 1.0, SAMPLES)
    return follow(device, exo, generator.arm, generator.path, np.array(reach.start_rad), lambdas)


def plan_case(reach: ReachInput, device: Device | None) -> Row:
    """Status and figures of a reach; a device that cannot follow is judged on the arm's own path."""
    exo = core_exo(device, reach.subject) if device is not None else None
    generator, status = moved(reach, exo)
    out: Row = {"status": status, "message": generator.message if status != "ok" else ""}
    refused_by_device = status == "ExoInfeasible"
    if refused_by_device:
        generator, status = moved(reach, None)
    if status != "ok":
        return out
    samples = generator.sample(np.linspace(0.0, reach.duration_s, SAMPLES))
    out |= arm_figures(generator, samples)
    if device is not None and exo is not None:
        motion = followed(reach, device, exo, generator)
        out |= {"exo_refusal": motion.check.refusal.name if refused_by_device else ""} | device_figures(motion)
        out |= {} if refused_by_device else joint_figures(samples)
    return out


def run_case(study: Study, case: Case) -> Row:
    """One row. A case that the core refuses has the status InvalidInput and the core's words."""
    row: Row = {"case": case.number, "group": case.group, "task": case.task, "draw": case.draw, "exo": case.exo or ""}
    try:
        reach = reach_of(study, case.values, f"case {case.number}")
        figures = plan_case(reach, device_by_name(case.exo) if case.exo is not None else None)
    except InputError as error:
        figures = {"status": "InvalidInput", "message": str(error)}
    finite = {key: value for key, value in figures.items() if not isinstance(value, float) or math.isfinite(value)}
    return row | case.values | finite


def run_study(study: Study, jobs: int) -> Iterator[Row]:
    """Rows in the order of the cases, the same ones for every number of processes."""
    cases = list(cases_of(study))
    run = partial(run_case, study)
    workers = min(jobs, math.ceil(len(cases) / CHUNK))
    if workers <= 1:
        yield from map(run, cases)
        return
    with ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("forkserver")) as pool:
        yield from pool.map(run, cases, chunksize=CHUNK)
