"""Synthetic movements whose truth is known, and where the measured reaches are."""

import os
from pathlib import Path

import numpy as np
from glenoid import _core
from glenoid.validate.movements import STERNUM_TO_JOINT_M, make_movement

UPPER_M, FORE_M = 0.29, 0.25
REACHES = Path(
    os.environ.get("GLENOID_REACHES", Path(__file__).parents[2] / ".." / "shared" / "data" / "reaches_public.npz")
)


def points_of(q, shoulder_m, upper_m=UPPER_M, fore_m=FORE_M):
    """Elbow and wrist of postures (n, 4) about shoulders (n, 3)."""
    R = np.stack([_core.posture_from_angles(row).R_TU for row in q])
    elbow = shoulder_m - upper_m * R[:, :, 2]
    fore = -np.sin(q[:, 3:]) * R[:, :, 1] + np.cos(q[:, 3:]) * R[:, :, 2]
    return elbow, elbow - fore_m * fore


def synthetic(
    name, subject, q0, q1, *, slope_m=None, duration_s=1.0, task="reach_forward", samples=120, part=(0.0, 1.0)
):
    """A part of a movement straight in joint angles with a minimum-jerk time law; the shoulder follows u with a given slope."""
    u = np.linspace(*part, samples)
    s = u**3 * (10 - 15 * u + 6 * u**2)
    q = np.asarray(q0) + s[:, None] * (np.asarray(q1) - np.asarray(q0))
    direction = -np.stack([_core.posture_from_angles(row).R_TU[:, 2] for row in q])
    shoulder = (
        np.array([0.15, -0.06, -0.02])
        + (direction - direction[0]) @ (np.zeros((3, 3)) if slope_m is None else slope_m).T
    )
    elbow, wrist = points_of(q, shoulder)
    return make_movement(
        shoulder, elbow, wrist, name=name, subject=subject, arm="R", task=task, phase="level", duration_s=duration_s
    )


def crowd(people=4, each=6, slope_m=None, seed=None):
    """Synthetic movements of several persons."""
    random = np.random.default_rng(int(os.environ.get("GLENOID_TEST_SEED", "1712")) if seed is None else seed)
    out = []
    for person in range(people):
        for k in range(each):
            q0 = np.deg2rad([20, -40, 45, 75]) + random.uniform(-0.15, 0.15, 4)
            q1 = np.deg2rad([60, -20, 25, 50]) + random.uniform(-0.3, 0.3, 4)
            out.append(
                synthetic(f"P{person}-{k}", f"P{person}", q0, q1, slope_m=slope_m, duration_s=random.uniform(0.7, 2.0))
            )
    return out


def write_npz(path, movements):
    """The movements in the layout of the public reaches."""
    rows = [np.hstack([m.shoulder_m, m.elbow_m, m.wrist_m]) + np.tile(STERNUM_TO_JOINT_M, 3) for m in movements]
    columns = [f"{p}_{a}" for p in ("gh", "el", "wr") for a in "xyz"]
    np.savez(
        path,
        data=np.concatenate(rows),
        columns=columns,
        offsets=np.cumsum([0, *(len(r) for r in rows)]),
        meta_subject=[m.subject for m in movements],
        meta_arm=[m.arm for m in movements],
        meta_task=[m.task for m in movements],
        meta_phase=[m.phase for m in movements],
        meta_duration_s=[m.duration_s for m in movements],
    )
