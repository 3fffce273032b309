"""A check that does not hold is seen, decides or warns as its level says, and a wrong expectation fails."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from glenoid.rehearse.checks import judge_all, tracking_error, verdict
from glenoid.rehearse.run import perform, rehearse
from glenoid.rehearse.scenario import load_scenario

FOLDER = Path(__file__).resolve().parents[2] / "host/rehearsals"

#: limits that the good rehearsal cannot keep
IMPOSSIBLE = {
    "arrival": 1e-9,
    "tracking_error": 1e-9,
    "joint_margin": 3.0,
    "arm_speed": 1e-3,
    "arm_acceleration": 1e-3,
    "device_margin": 3.0,
    "device_speed": 1e-3,
    "device_acceleration": 1e-3,
    "misalignment": 1e-9,
    "following_error": 1e-9,
    "jitter": -1.0,
    "bus_load": 1e-3,
    "losses": -1.0,
    "completed": -1.0,
}


def outcomes(done):
    return {finding.name: finding.outcome for finding in done.findings}


@pytest.mark.parametrize("level", ["error", "warn", "off"])
def test_broken_limits_are_seen(scenario_of, level):
    def change(data):
        data["checks"] = {name: {"level": level, "limit": limit} for name, limit in IMPOSSIBLE.items()}

    done = rehearse(scenario_of("reach_high", change), None)
    expected = {"error": "FAIL", "warn": "warn", "off": "off"}[level]
    assert {outcomes(done)[name] for name in IMPOSSIBLE} == {expected}
    assert done.verdict == ("FAIL" if level == "error" else "PASS")


@pytest.fixture(scope="module")
def evidence():
    """The good rehearsal, run once to be judged often."""
    path = FOLDER / "reach_high.yaml"
    return perform(load_scenario(path), lambda _stage, _share: None)


def test_good_rehearsal_passes(evidence):
    assert verdict(judge_all(evidence)) == "PASS"


def test_measured_motion_is_compared_at_the_right_instant(evidence):
    """One SYNC off and the error would be the way of a period, several times as much as it is."""
    speed = np.abs(evidence.motion.samples["exo_dq_rad_per_s"]).max()
    way = 1e-9 * evidence.scenario.config.period_ns * speed
    assert tracking_error(evidence)[0] < 0.5 * way


@pytest.mark.parametrize("name", sorted(IMPOSSIBLE))
def test_one_broken_check_decides(scenario_of, evidence, name):
    broken = scenario_of("reach_high", lambda data: data.update(checks={name: {"limit": IMPOSSIBLE[name]}}))
    findings = judge_all(replace(evidence, scenario=broken))
    assert [finding.name for finding in findings if finding.outcome == "FAIL"] == [name]
    assert verdict(findings) == "FAIL"


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("state", "STOP"),
        ("fault", "EStop"),
        ("within_ms", 1e-3),
        ("at_rest_within_ms", 1e-3),
        ("unpowered_within_ms", 1.0),
        ("moves_at_most_rad", 1e-6),
    ],
)
def test_wrong_expectation_fails(scenario_of, key, value):
    done = rehearse(scenario_of("fault_drive_emcy", lambda data: data["expect"].update({key: value})), None)
    assert done.verdict == "FAIL"
    failed = [finding.name for finding in done.findings if finding.outcome == "FAIL"]
    names = {"at_rest_within_ms": "at_rest", "unpowered_within_ms": "unpowered", "moves_at_most_rad": "travel"}
    assert failed == [names.get(key, "safe_state")]


def test_expected_fault_that_does_not_happen_fails(scenario_of):
    done = rehearse(scenario_of("fault_drive_emcy", lambda data: data["faults"][0].update(at_s=600.0)), None)
    assert done.verdict == "FAIL"


def test_fault_without_an_expectation_fails(scenario_of):
    done = rehearse(scenario_of("fault_stream_stop", lambda data: data.pop("expect")), None)
    assert outcomes(done)["completed"] == "FAIL"
    assert outcomes(done)["reaction"] == "pass"


def test_a_fault_that_is_borne_is_judged_to_the_end_of_the_motion(scenario_of):
    """A drive that answers 2 ms late shows where the joint was then; the good rehearsal is some tenths of that off."""
    done = perform(scenario_of("small_delays"), lambda _stage, _share: None)
    way = 2e-3 * np.abs(done.motion.samples["exo_dq_rad_per_s"][:, 3]).max()
    assert tracking_error(done)[0] > 0.5 * way
    assert done.row.max() > done.motion.ends[-1]
    assert verdict(judge_all(done)) == "PASS"


def test_slow_reaction_fails(scenario_of):
    done = rehearse(
        scenario_of("fault_stream_stop", lambda data: data.update(checks={"reaction": {"limit": 20.0}})), None
    )
    assert outcomes(done)["reaction"] == "FAIL"


def test_unreachable_target_fails_with_the_words_of_the_fmu(scenario_of):
    done = rehearse(
        scenario_of("reach_high", lambda data: data.update(movements=[{"target_m": [0.2, 0.9, 0.9]}])), None
    )
    completed = next(finding for finding in done.findings if finding.name == "completed")
    assert done.verdict == "FAIL"
    assert "TargetUnreachable" in completed.text


def test_short_gap_is_held_and_the_motion_goes_on(scenario_of):
    def change(data):
        data["faults"] = [{"kind": "stream_stop", "at_s": 2.1, "duration_s": 0.02}]  # the arm rests then
        data["checks"] = {"completed": "warn"}

    done = rehearse(scenario_of("reach_high", change), None)
    assert done.verdict == "PASS", [finding for finding in done.findings if finding.outcome == "FAIL"]
    assert done.facts["fault"] == 0
