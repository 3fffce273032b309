"""What is judged: one function a check, each with its value, its limit and its unit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from glenoid.publisher import STATES
from glenoid.reach import Array
from glenoid.rehearse.motion import Motion
from glenoid.rehearse.record import STATE_NUMBER, Record
from glenoid.rehearse.scenario import FAULTS, Scenario
from glenoid.settings import core_limits

#: below this elevation the plane of elevation is undefined, and its limit does not apply, rad
PLANE_FROM_RAD = float(np.deg2rad(5.0))
#: slower than this a joint is at rest, rad/s
REST_RAD_PER_S = 0.02
UNITS = {
    "completed": "",
    "arrival": "m",
    "tracking_error": "rad",
    "joint_margin": "rad",
    "arm_speed": "rad/s",
    "arm_acceleration": "rad/s2",
    "device_margin": "rad",
    "device_speed": "of the limit",
    "device_acceleration": "of the limit",
    "misalignment": "m",
    "following_error": "rad",
    "motor_torque": "of the rated",
    "jitter": "us",
    "bus_load": "of the bus",
    "losses": "",
    "reaction": "ms",
    "safe_state": "ms",
}
#: these must not fall below their limit; all others must not exceed it
LEAST = ("joint_margin", "device_margin")
#: these cannot be judged where a fault is expected to end the motion
WHOLE = ("completed", "arrival", "losses")
#: there may be nothing to judge
ABSENT = ("motor_torque", "reaction")
SYNC_ID, RPDO_ID, TPDO_ID = 0x080, 0x200, 0x180


@dataclass(frozen=True)
class Finding:
    """Outcome of one check. `value` is None where there was nothing to judge."""

    name: str
    level: str
    value: float | None
    limit: float
    unit: str
    passed: bool
    text: str

    @property
    def outcome(self) -> str:
        """pass, warn, FAIL or off."""
        if self.level == "off":
            return "off"
        return "pass" if self.passed else ("FAIL" if self.level == "error" else "warn")


@dataclass(frozen=True)
class Evidence:
    """What the checks look at.

    Attributes:
        until_ns: motion counts up to here: the first fault where one is expected to end it, else the end.
        reference_rad, measured_rad: of the motion, at the feedback's instants within it; a column a joint.
        in_motion: those rows of the feedback.
        row: of the motion at each of them, fractional.

    """

    scenario: Scenario
    motion: Motion
    record: Record
    until_ns: int
    first_fault_ns: int | None
    in_motion: NDArray[np.bool_]
    row: Array
    reference_rad: Array
    measured_rad: Array


def gather(scenario: Scenario, motion: Motion, record: Record) -> Evidence:
    """Aligns what was measured with what the source wanted: the drives show a setpoint one delay and one SYNC later."""
    config = scenario.config
    times = record.feedback["time_ns"]
    faults = [record.origin_ns + round(1e9 * fault.at_s) for fault in scenario.data.faults]
    first = min(faults) if faults else None
    late_ns = config.delay_ns + config.period_ns
    end = record.origin_ns + round(1e9 * motion.rows * motion.period_s) + late_ns
    until = end if first is None or scenario.data.expect is None else min(first, end)
    row = 1e-9 * (times - late_ns - record.origin_ns) / motion.period_s
    inside = (row >= 0.0) & (row <= motion.rows - 1) & (times < until)
    at = row[inside]
    grid = np.arange(motion.rows, dtype=float)
    exo = motion.samples["exo_q_rad"]
    reference = np.column_stack([np.interp(at, grid, exo[:, j]) for j in range(exo.shape[1])])
    return Evidence(
        scenario, motion, record, until, first, inside, at, reference, record.feedback["position_rad"][inside]
    )


Value = tuple[float | None, str]


def worst(values: Array, names: list[str]) -> tuple[float, str]:
    """Largest of a table, and the column's name."""
    if values.size == 0:
        return float("nan"), "nothing was measured"
    column = int(np.unravel_index(np.argmax(values), values.shape)[1])
    return float(values.max()), names[column]


def completed(e: Evidence) -> Value:
    """0: every movement was done and the drives were without power afterwards."""
    reasons = list(e.record.stages) + e.motion.refusals
    if e.record.fault:
        reasons.append(f"stopped by {FAULTS[e.record.fault]}")
    if e.record.state != "IDLE":
        reasons.append(f"ended in {e.record.state}")
    states = e.record.feedback["state"][e.in_motion]
    if states.size == 0 or (states != STATE_NUMBER["RUN"]).any():
        others = sorted({STATES[int(s)] for s in states} - {"RUN"})
        reasons.append("did not follow throughout" + (f": {', '.join(others)}" if others else ""))
    return float(len(reasons)), "; ".join(reasons) or "all movements done, drives released"


def arrival(e: Evidence) -> Value:
    """Hand's distance from the target at the end of each movement: of the source, and what the drives' error adds."""
    distances = []
    lengths = 0.6  # m: of an arm; a joint's error moves the hand by no more than that times its angle
    for end, target in zip(e.motion.ends, e.motion.targets_m, strict=True):
        off = float(np.linalg.norm(e.motion.samples["wrist_m"][end] - np.array(target)))
        near = np.abs(e.row - min(end + 25, e.motion.rows - 1)) < 3.0
        error = np.abs(e.measured_rad[near] - e.reference_rad[near])
        distances.append(off + (lengths * float(np.linalg.norm(error, axis=1).max()) if near.any() else np.inf))
    k = int(np.argmax(distances))
    return distances[k], f"movement {k + 1}, at most so far from its target"


def tracking_error(e: Evidence) -> Value:
    """Measured joints against the source's motion, the configured delay later."""
    return worst(np.abs(e.measured_rad - e.reference_rad), e.scenario.joints)


def upto(e: Evidence) -> int:
    """Rows of the motion that were played."""
    return max(1, int(e.row.max()) + 1) if e.row.size else 1


def joint_margin(e: Evidence) -> Value:
    """Least distance of the planned posture from the person's limits."""
    q = e.motion.samples["q_rad"][: upto(e)]
    limits = core_limits(e.scenario.subject)
    angles = np.column_stack([q[:, 0], q[:, 1], q[:, 1] + q[:, 2], q[:, 3]])
    margin = np.minimum(angles - limits.lower_rad, limits.upper_rad - angles)
    margin[q[:, 0] < PLANE_FROM_RAD, 1] = np.inf
    names = ["elevation", "plane", "axial rotation", "elbow flexion"]
    value, name = worst(-margin, names)
    return -value, name


def arm_rates(e: Evidence) -> Array:
    """Speed of the upper arm's rotation and of the elbow, rad/s: a column each."""
    q, dq = e.motion.samples["q_rad"][: upto(e)], e.motion.samples["dq_rad_per_s"][: upto(e)]
    turn = dq[:, 0] ** 2 + dq[:, 1] ** 2 + dq[:, 2] ** 2 + 2.0 * dq[:, 1] * dq[:, 2] * np.cos(q[:, 0])
    return e.motion.factor * np.column_stack([np.sqrt(np.maximum(turn, 0.0)), np.abs(dq[:, 3])])


def arm_speed(e: Evidence) -> Value:
    """Upper arm's angular speed and elbow's rate."""
    return worst(arm_rates(e), ["upper arm", "elbow"])


def arm_acceleration(e: Evidence) -> Value:
    """Change of those speeds."""
    rates = arm_rates(e)
    if len(rates) < 2:
        return None, "too short"
    return worst(np.abs(np.diff(rates, axis=0)) / e.motion.period_s, ["upper arm", "elbow"])


def device_margin(e: Evidence) -> Value:
    """Least distance of a measured joint from the bridge's limits."""
    lower, upper = (np.array([joint[k] for joint in e.scenario.config.joints]) for k in ("lower_rad", "upper_rad"))
    value, name = worst(-np.minimum(e.measured_rad - lower, upper - e.measured_rad), e.scenario.joints)
    return -value, name


def commanded(e: Evidence) -> tuple[Array, Array]:
    """Commands while the bridge led the drives, and their times, s."""
    led = np.isin(e.record.feedback["state"], (STATE_NUMBER["RUN"], STATE_NUMBER["HOLD"]))
    rows = e.in_motion & led
    return e.record.feedback["command_rad"][rows], 1e-9 * e.record.feedback["time_ns"][rows]


def device_speed(e: Evidence) -> Value:
    """Commanded joint speed over its limit."""
    command, times = commanded(e)
    if len(command) < 2:
        return None, "too short"
    limits = np.array([joint["velocity_rad_per_s"] for joint in e.scenario.config.joints])
    dt = np.diff(times)[:, None]
    return worst(np.abs(np.diff(command, axis=0)) / dt / limits, e.scenario.joints)


def device_acceleration(e: Evidence) -> Value:
    """Commanded joint acceleration over its limit."""
    command, times = commanded(e)
    if len(command) < 3:
        return None, "too short"
    limits = np.array([joint["acceleration_rad_per_s2"] for joint in e.scenario.config.joints])
    even = (np.abs(np.diff(times, n=2)) < 1e-6)[:, None]  # a missing message would look like an acceleration
    dt = np.diff(times)[1:, None]
    return worst(np.where(even, np.abs(np.diff(command, n=2, axis=0)), 0.0) / dt**2 / limits, e.scenario.joints)


def misalignment(e: Evidence) -> Value:
    """Device's shoulder centre against the person's: what the girdle drives leave, and their tracking error."""
    if e.row.size == 0:
        return None, "nothing was measured"
    rows = np.clip(np.rint(e.row).astype(int), 0, e.motion.rows - 1)
    off = e.measured_rad[:, :2] - e.reference_rad[:, :2]
    elevation, length = e.reference_rad[:, 1], e.motion.samples["girdle"][rows, 2]
    by_drives = length * np.hypot(np.cos(elevation) * off[:, 0], off[:, 1])
    total = by_drives + e.motion.samples["residual_m"][rows]
    without = 1e3 * float(e.motion.samples["misalignment_m"][rows].max())
    return float(total.max()), f"with a girdle that stands still it would be {without:.0f} mm"


def following_error(e: Evidence) -> Value:
    """Measured joints against the bridge's command of the SYNC before."""
    command, measured = e.record.feedback["command_rad"], e.record.feedback["position_rad"]
    late = np.roll(e.in_motion, -1)
    late[-1:] = False
    both = late[:-1] & e.in_motion[1:]
    return worst(np.abs(measured[1:][both] - command[:-1][both]), e.scenario.joints)


def motor_torque(e: Evidence) -> Value:
    """Torque of the motors over what they are rated for."""
    rated = np.array([joint["rated_torque_Nm"] or np.inf for joint in e.scenario.config.joints])
    if not np.isfinite(rated).any():
        return None, "the configuration knows no rated torque"
    return worst(np.abs(e.record.feedback["effort_Nm"][e.in_motion]) / rated, e.scenario.joints)


def sync_errors_us(record: Record, period_ns: int, until_ns: int) -> Array:
    """Interval of neighbouring SYNCs on the first bus less the period, us."""
    frames = record.frames
    times = frames["time_ns"][(frames["id"] == SYNC_ID) & (frames["bus"] == 0) & (frames["time_ns"] < until_ns)]
    return np.asarray(1e-3 * (np.diff(times) - period_ns), dtype=float)


def jitter(e: Evidence) -> Value:
    """Largest error of an interval between two SYNCs."""
    errors = np.abs(sync_errors_us(e.record, e.scenario.config.period_ns, e.until_ns))
    if errors.size == 0:
        return None, "no SYNC"
    return float(errors.max()), f"99 of 100 within {float(np.quantile(errors, 0.99)):.0f} us"


def bus_load(e: Evidence) -> Value:
    """Worst-case load of the configuration, and the measured one."""
    configured = max(float(bus["worst_case_load"]) for bus in e.scenario.config.buses)
    loads = [max(status["bus_load"]) for status in e.record.statuses if status["time_ns"] < e.until_ns]
    measured = max(loads, default=0.0)
    return max(configured, measured), f"worst case {configured:.2f} with stuff bits, measured at most {measured:.2f}"


def losses(e: Evidence) -> Value:
    """Setpoints rejected, cycles left out, answers missing, frames refused."""
    if not e.record.statuses:
        return None, "no status"
    armed = [status for status in e.record.statuses if status["session"] != 0]  # before and after, they are refused
    last = armed[-1] if armed else e.record.statuses[-1]
    before = next((s for s in armed if s["time_ns"] >= e.record.origin_ns), last)
    rejected = last["setpoints_rejected"] - before["setpoints_rejected"]
    missed = sum(last["missed_feedback"]) - sum(before["missed_feedback"])
    skipped = last["cycles_skipped"] - before["cycles_skipped"]
    refused = sum(last["bus_refused"]) - sum(before["bus_refused"])
    text = (
        f"{rejected} setpoints rejected, {skipped} cycles left out, {missed} answers missing, {refused} frames refused"
    )
    return float(rejected + missed + skipped + refused), text


def stop_on_wire_ns(record: Record, since_ns: int) -> int | None:
    """First RPDO that does not ask for "enable operation", ns."""
    frames = record.frames
    rpdo = ((frames["id"] & ~np.uint32(0x7F)) == RPDO_ID) & (frames["time_ns"] >= since_ns) & (frames["size"] >= 2)
    found = np.flatnonzero(rpdo & ((frames["data"][:, 0] & 0x0F) != 0x0F))
    return int(frames["time_ns"][found[0]]) if found.size else None


def reaction(e: Evidence) -> Value:
    """From the first fault to the first RPDO that no longer asks for operation; nothing where the motion went on."""
    if e.first_fault_ns is None:
        return None, "no fault"
    at = stop_on_wire_ns(e.record, e.first_fault_ns)
    ended_by_stop = e.record.fault != 0
    if at is None or not ended_by_stop:
        return None, "the motion was not stopped"
    return 1e-6 * (at - e.first_fault_ns), f"to the quick stop on the bus, {FAULTS[e.record.fault]}"


CHECKS: dict[str, Callable[[Evidence], Value]] = {
    "completed": completed,
    "arrival": arrival,
    "tracking_error": tracking_error,
    "joint_margin": joint_margin,
    "arm_speed": arm_speed,
    "arm_acceleration": arm_acceleration,
    "device_margin": device_margin,
    "device_speed": device_speed,
    "device_acceleration": device_acceleration,
    "misalignment": misalignment,
    "following_error": following_error,
    "motor_torque": motor_torque,
    "jitter": jitter,
    "bus_load": bus_load,
    "losses": losses,
    "reaction": reaction,
}


def judge(e: Evidence, name: str) -> Finding:
    """One check of the scenario."""
    given: Any = getattr(e.scenario.data.checks, name)
    level = given.level
    if level == "off" or (e.scenario.data.expect is not None and name in WHOLE):
        why = "off" if level == "off" else "not judged: a fault is expected"
        return Finding(name, "off", None, given.limit, UNITS[name], True, why)
    value, text = CHECKS[name](e)
    if value is None:
        absent_is_fine = name in ABSENT or e.scenario.data.expect is not None
        return Finding(name, level, None, given.limit, UNITS[name], absent_is_fine, text)
    passed = value >= given.limit if name in LEAST else value <= given.limit  # NaN passes neither
    return Finding(name, level, value, given.limit, UNITS[name], bool(passed), text)


def judge_all(e: Evidence) -> list[Finding]:
    """Every check, and the expected safe state where there is one."""
    from glenoid.rehearse.safe_state import judge_safe_state  # it builds on this file

    findings = [judge(e, name) for name in CHECKS]
    return findings + judge_safe_state(e)


def verdict(findings: list[Finding]) -> str:
    """PASS, or FAIL where a check of level error does not hold."""
    return "FAIL" if any(finding.outcome == "FAIL" for finding in findings) else "PASS"
