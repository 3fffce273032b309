"""Every shipped rehearsal does what it states."""

from pathlib import Path
from typing import get_args

import numpy as np
import pytest
import yaml
from glenoid.rehearse.checks import REST_RAD_PER_S, gather, judge_all, verdict
from glenoid.rehearse.motion import run_source
from glenoid.rehearse.scenario import FAULTS, FaultKind, load_scenario
from glenoid.rehearse.virtual import run_virtual

FOLDER = Path(__file__).resolve().parents[2] / "host/rehearsals"
VIRTUAL = [path for path in sorted(FOLDER.glob("*.yaml")) if "real_time" not in path.stem]
#: and by which checks alone, where that matters
MUST_FAIL = {"too_fast": None, "fault_drive_stuck_encoder": ["travel"]}
RPDO, ENABLE = 0x200, 0x0F


@pytest.fixture(scope="module", params=VIRTUAL, ids=lambda path: path.stem)
def done(request):
    """A shipped scenario, run."""
    scenario = load_scenario(request.param)
    motion = run_source(scenario, 1e-9 * scenario.config.setpoint_period_ns)
    return request.param.stem, gather(scenario, motion, run_virtual(scenario, motion))


def test_verdict_is_the_one_the_file_states(done):
    name, e = done
    findings = judge_all(e)
    told = [f"{f.name}: {f.value} {f.text}" for f in findings if f.outcome == "FAIL"]
    assert verdict(findings) == ("FAIL" if name in MUST_FAIL else "PASS"), told
    if (alone := MUST_FAIL.get(name)) is not None:
        assert [finding.name for finding in findings if finding.outcome == "FAIL"] == alone


def test_faults_end_in_the_stated_safe_state_in_the_stated_time(done):
    """The same from the raw record: not through the code that judges."""
    name, e = done
    expect, record = e.scenario.data.expect, e.record
    if expect is None:  # no fault, or none that may end the motion
        assert (record.fault, record.state) == (0, "IDLE") or name in MUST_FAIL
        return
    assert expect.at_rest_within_ms is not None, "a safe state is one at rest, in a stated time"
    truth = record.truth
    since = record.origin_ns + round(1e9 * min(fault.at_s for fault in e.scenario.data.faults))
    assert record.state == expect.state
    assert FAULTS[record.fault] in expect.faults
    first = next(event for event in record.events if event["severity"] == 2 and event["code"] == record.fault)
    assert 0 <= first["time_ns"] - since <= 1e6 * expect.within_ms
    way = np.ptp(truth["position_rad"][truth["time_ns"] >= since], axis=0).max()
    assert (expect.moves_at_most_rad is not None and way <= expect.moves_at_most_rad) or name in MUST_FAIL
    print(f"{e.scenario.data.name}: {record.state}, {FAULTS[record.fault]}, {1e-6 * (first['time_ns'] - since):.1f} ms")
    before = truth["time_ns"] < since
    assert (np.abs(truth["velocity_rad_per_s"][before][-1]) > REST_RAD_PER_S).any(), "the arm moved when it happened"
    for limit, bad in (
        (expect.at_rest_within_ms, (np.abs(truth["velocity_rad_per_s"]) > REST_RAD_PER_S).any(axis=1)),
        (expect.unpowered_within_ms, truth["powered_mask"] != 0),
    ):
        if limit is not None:
            after = truth["time_ns"] > since + 1e6 * limit
            assert after.any()
            assert not bad[after].any()


def test_no_drive_is_told_to_go_on_after_the_stop(done):
    _, e = done
    record = e.record
    if record.fault == 0:
        return
    stop_ns = next(event["time_ns"] for event in record.events if event["code"] == record.fault)
    frames = record.frames
    rpdo = ((frames["id"] & ~np.uint32(0x7F)) == RPDO) & (frames["time_ns"] > stop_ns)
    assert not ((frames["data"][rpdo, 0] & ENABLE) == ENABLE).any()


def test_every_kind_of_fault_has_a_rehearsal_that_states_where_it_ends():
    shipped = [yaml.safe_load(path.read_text()) for path in VIRTUAL]
    kinds = {fault["kind"] for data in shipped if "expect" in data for fault in data["faults"]}
    assert kinds == set(get_args(FaultKind))
