"""Targets of measured reaches that a model of the arm cannot quite reach: pulled in a little, and said so.

A measured wrist is off its model by some millimetres (skin, joint centres, the shoulder's prediction), and people do not
end a reach with the arm straight. A measured reach is one whose shoulder centre at the start is known; other targets out
of reach stay refused.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from glenoid import _core
from glenoid.reach import Array

#: targets nearer than this to the edge of the model's reach, m, are pulled in
REACH_MARGIN_M = 0.005
#: towards the shoulder of the start in steps, m; at most, m, where a program asks (plan --batch)
PULL_STEP_M, MOST_PULL_M = 0.005, 0.050
#: refusals that a nearer target may answer
PULLED = (_core.Status.Ok, _core.Status.TargetUnreachable, _core.Status.LimitsInfeasible)
Plan = Callable[[Array], tuple[_core.Status, _core.ReachPlan]]


def plan_within_reach(
    plan: Plan, target_m: Array, shoulder_m: Array, most_m: float = MOST_PULL_M
) -> tuple[_core.Status, _core.ReachPlan, float]:
    """Plans to the target or to the first one towards the shoulder that is REACH_MARGIN_M within reach.

    Returns status, plan and by how much the target was moved, m; where even `most_m` is not enough, the first answer and 0.
    """
    inward = shoulder_m - target_m
    length = float(np.linalg.norm(inward))
    first_status, first_plan = plan(target_m)
    status, planned, steps = first_status, first_plan, 0
    while status != _core.Status.Ok or planned.reach_margin_m < REACH_MARGIN_M:
        steps += 1
        pulled = steps * PULL_STEP_M
        if status not in PULLED or pulled > min(most_m, length) + 1e-9:
            return first_status, first_plan, 0.0
        status, planned = plan(target_m + pulled / length * inward)
    return status, planned, steps * PULL_STEP_M
