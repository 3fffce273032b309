"""Whether the faults led to the safe state that the scenario names, and in the time it allows."""

from __future__ import annotations

import numpy as np

from glenoid.rehearse.checks import REST_RAD_PER_S, Evidence, Finding
from glenoid.rehearse.record import Record
from glenoid.rehearse.scenario import FAULTS


def last_ns(times_ns: np.ndarray, bad: np.ndarray, since_ns: int) -> int | None:
    """Instant after the last bad one, ns; None: it never ended."""
    after = times_ns >= since_ns
    wrong = np.flatnonzero(after & bad)
    if not after.any():
        return None
    if wrong.size == 0:
        return since_ns
    return int(times_ns[wrong[-1] + 1]) if wrong[-1] + 1 < len(times_ns) else None


def at_rest_ns(record: Record, phase_ns: int, since_ns: int) -> int | None:
    """From when on every joint rests: truly in virtual time, else by the feedback."""
    source = record.truth if record.truth is not None else record.feedback
    moving = np.abs(source["velocity_rad_per_s"]).max(axis=1) > REST_RAD_PER_S
    return last_ns(source["time_ns"] + phase_ns, moving, since_ns)


def unpowered_ns(record: Record, phase_ns: int, since_ns: int) -> int | None:
    """From when on no drive is powered: truly in virtual time, else as the statuswords say."""
    if record.truth is not None:
        return last_ns(record.truth["time_ns"] + phase_ns, record.truth["powered_mask"] != 0, since_ns)
    words = record.feedback["statusword"]
    powered = ((words & 0x6F) == 0x27) | ((words & 0x6F) == 0x07)
    return last_ns(record.feedback["time_ns"], powered.any(axis=1), since_ns)


def travel(e: Evidence, since_ns: int) -> tuple[float | None, str]:
    """How far a joint went after the first fault, rad, and which: truly in virtual time, else by the feedback."""
    source = e.record.truth if e.record.truth is not None else e.record.feedback
    positions = source["position_rad"][source["time_ns"] >= since_ns]
    if len(positions) == 0:
        return None, "nothing was measured"
    way = np.ptp(positions, axis=0)
    joint = int(np.argmax(way))
    return float(way[joint]), e.scenario.joints[joint] + ("" if e.record.truth is not None else ", by its encoder")


def judge_safe_state(e: Evidence) -> list[Finding]:
    """One finding for the state and its fault, and one for each further figure of the expectation."""
    expect, since = e.scenario.data.expect, e.first_fault_ns
    if expect is None or since is None:
        return []
    record = e.record
    at = record.first_status(expect.state, since)  # told at every change
    phase_ns = int(e.scenario.config.rpdo_phase * e.scenario.config.period_ns)  # of a cycle, when it is noted
    latched = FAULTS[record.fault]
    right = at is not None and latched in expect.faults and record.state == expect.state
    ms = None if at is None else 1e-6 * (at - since)
    text = f"{record.state} with {latched}; expected {expect.state} with {' or '.join(expect.faults)}"
    passed = right and ms is not None and ms <= expect.within_ms
    findings = [Finding("safe_state", "error", ms, expect.within_ms, "ms", passed, text)]
    for name, limit, instant in (
        ("at_rest", expect.at_rest_within_ms, at_rest_ns(record, phase_ns, since)),
        ("unpowered", expect.unpowered_within_ms, unpowered_ns(record, phase_ns, since)),
    ):
        if limit is None:
            continue
        took = None if instant is None else 1e-6 * (instant - since)
        words = "after the first fault" if took is not None else "never"
        findings.append(Finding(name, "error", took, limit, "ms", took is not None and took <= limit, words))
    if (most := expect.moves_at_most_rad) is not None:
        way, joint = travel(e, since)
        findings.append(Finding("travel", "error", way, most, "rad", way is not None and way <= most, joint))
    return findings
