"""The real programs, in real time: LCM and frames over UDP on ports of their own.

How late this machine is decides nothing here: what is asked for is what the protocol itself guarantees.
"""

import gc
import os
import socket
import threading

import attempts
import pytest
from glenoid.inputs import InputError
from glenoid.programs import program
from glenoid.rehearse.programs import may_be_realtime, realtime_source
from glenoid.rehearse.run import perform, rehearse


@pytest.fixture(autouse=True)
def _programs():
    try:
        program("glenoid-bridge"), program("glenoid-drives")
    except InputError as error:
        pytest.skip(str(error))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("239.255.76.67", 7667))
        except OSError as error:
            pytest.skip(f"no multicast on this machine: {error}; ip route add 224.0.0.0/4 dev lo")


def failed(done):
    """Checks that did not hold."""
    return [f"{f.name}: {f.text}" for f in done.findings if f.outcome == "FAIL"]


def first_that(scenario, wanted, folder=None):
    """The first of some rehearsals that is as wanted; the last one otherwise."""
    return attempts.first_that(lambda: rehearse(scenario, folder), wanted, failed)


def test_good_rehearsal_passes_with_the_real_programs(scenario_of, tmp_path):
    done = first_that(scenario_of("reach_high_real_time"), lambda done: done.verdict == "PASS", tmp_path)
    assert done.verdict == "PASS", failed(done)
    assert (tmp_path / "report.html").is_file()
    assert len(done.facts["drives"]) == 6
    assert done.facts["config_hash"] == scenario_of("reach_high").config.hash


@pytest.mark.parametrize(
    ("kind", "state", "faults"),
    [
        ("drive_emcy", "FAULT", ["DriveEmergency"]),
        ("stream_nan", "STOP", ["StaleSetpoints"]),
        ("estop_input", "STOP", ["EStop"]),
    ],
)
def test_faults_reach_the_real_programs(scenario_of, kind, state, faults):
    def change(data):
        data["faults"] = [{"kind": kind, "at_s": 0.8}]
        data["expect"] = {"state": state, "fault": faults, "within_ms": 500.0}
        data["checks"] |= dict.fromkeys(("tracking_error", "reaction"), "warn")

    done = first_that(scenario_of("reach_high_real_time", change), lambda done: done.verdict == "PASS")
    assert done.verdict == "PASS", failed(done)


def test_source_gives_its_priority_to_every_thread_and_takes_it_back():
    """Or a thread that holds the interpreter's lock, and waits behind other programs, holds up the source."""
    if not may_be_realtime():
        pytest.skip("SCHED_FIFO or locked memory is not permitted here")
    over = threading.Event()
    other = threading.Thread(target=over.wait)
    other.start()
    try:
        with realtime_source(80):
            inside = [os.sched_getscheduler(task) for task in (0, other.native_id)]
            assert not gc.isenabled()
        assert inside == [os.SCHED_FIFO] * 2
        assert [os.sched_getscheduler(task) for task in (0, other.native_id)] == [os.SCHED_OTHER] * 2
        assert gc.isenabled()
        with realtime_source(0):
            assert os.sched_getscheduler(0) == os.SCHED_OTHER
    finally:
        over.set()
        other.join()


def test_half_speed_takes_twice_as_long(scenario_of):
    e = perform(
        scenario_of("reach_high_real_time", lambda data: data.update(real_time={"factor": 0.5})),
        lambda _stage, _share: None,
    )
    step = scenario_of("reach_high").config.setpoint_period_ns
    # 2.3 s of motion and its two extra steps on the source's clock
    assert abs(e.motion.rows * step * 1e-9 - 2 * 2.3) < 4 * step * 1e-9
