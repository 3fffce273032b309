"""What a person must be told about a planned reach, in words."""

from __future__ import annotations

import numpy as np

from glenoid import _core
from glenoid.reach import Reach

ANGLE_NAMES = ("elevation theta", "plane eta", "axial rotation eta + zeta", "elbow flexion phi")
#: the source of the rhythm measured elevations up to here, rad
RHYTHM_RANGE_RAD = np.deg2rad(150.0)
HAND_TOLERANCE_M = 1e-6


def describe_margin(margin: _core.LimitMargin) -> str:
    """One limit and how far away it is, deg."""
    side = "upper" if margin.at_upper else "lower"
    degrees = np.rad2deg(margin.margin_rad)
    where = "inside" if degrees >= 0 else "OUTSIDE"
    return f"{ANGLE_NAMES[margin.angle]}, {abs(degrees):.2f} deg {where} its {side} limit"


def describe_refusal(reach: Reach) -> str:
    """Why there is no motion."""
    text = reach.message or reach.status
    if reach.status == "TargetUnreachable":
        text += f" (beyond reach by {-1e3 * reach.reach_margin_m:.1f} mm)"
    if reach.status == "LimitsInfeasible":
        text += f" (best posture: {describe_margin(reach.best_margin)})"
    return text


def warnings_for(reach: Reach) -> list[str]:
    """Everything about the motion that a user must not overlook; empty if there is nothing."""
    if not reach.ok:
        return []
    certificate = reach.certificate
    out = []
    if certificate.limits.any:
        out.append(
            f"the path leaves the joint limits on the way: {describe_margin(certificate.limits.worst)} "
            f"at lambda = {certificate.limits.at_lambda:.3f}; a geodesic knows no limits"
        )
    if not certificate.hessian_positive:
        out.append("the path was not shown to be a minimum: its second variation is not positive definite")
    if certificate.long_way:
        angle = np.rad2deg(certificate.rotation_angle_rad)
        out.append(f"the path turns the long way round (the short rotation would be {angle:.1f} deg)")
    if certificate.hand_error_m > HAND_TOLERANCE_M:
        out.append(f"the wrist ends {1e6 * certificate.hand_error_m:.2f} um from the target")
    if certificate.swivel_at_limit:
        out.append("the swivel angle lies at a joint limit; less energy would need postures beyond it")
    if reach.samples["q_rad"][:, 0].max() > RHYTHM_RANGE_RAD:
        out.append("elevation goes beyond 150 deg, outside the range in which the shoulder rhythm was measured")
    return out
