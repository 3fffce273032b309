"""Time: the result is a function of time and inputs, not of the steps."""

import math
import struct

import pytest

OK, WARNING, DISCARD, ERROR = range(4)
H = 1 / 512  # sums of these are exact, so that equal times have equal bits


def bits(row):
    return [struct.pack("<d", float(value)) for value in row]


@pytest.mark.parametrize("parts", [2, 16, 64])
def test_do_step_is_split_invariant(new, parts):
    whole, split = new().initialize(), new().initialize()
    for k in range(24):
        time = k * 64 * H
        assert whole.step(time, 64 * H) == OK
        for part in range(parts):
            size = 64 * H / parts
            assert split.step(time + part * size, size) == OK
        assert bits(split.outputs()) == bits(whole.outputs()), f"after {time + 64 * H} s"


def test_splitting_does_not_matter_after_a_refused_target(new):
    whole, split = new().initialize(), new().initialize()
    for unit in (whole, split):
        unit.run(0, 128 * H, 64 * H)
        assert unit.set("target", (3.0, 3.0, 3.0)) == OK
    assert whole.step(128 * H, 1024 * H) == OK
    split.run(128 * H, 1152 * H, H)
    assert bits(whole.outputs()) == bits(split.outputs())


def test_any_step_sizes_give_the_same_end(new, rng):
    fixed, varied = new().initialize(), new().initialize()
    assert fixed.step(0.0, 1024 * H) == OK
    tick = 0
    while tick < 1024:
        size = min(rng.randint(1, 97), 1024 - tick)
        assert varied.step(tick * H, size * H) == OK
        tick += size
    assert bits(varied.outputs()) == bits(fixed.outputs())


@pytest.mark.parametrize("start", [0.0, 12.5, 1e4])
def test_accumulated_and_exact_times_are_both_accepted(new, start):
    accumulated, exact = new().initialize(start), new().initialize(start)
    time = start
    for k in range(900):
        assert accumulated.step(time, 0.01 / 3) == OK, accumulated.messages
        time += 0.01 / 3
        begin, end = start + k * (0.01 / 3), start + (k + 1) * (0.01 / 3)
        assert exact.step(begin, end - begin) == OK, exact.messages
    # Both ends differ by at most 900 roundings of the time; at rest that changes nothing.
    assert accumulated.get("q") == exact.get("q")


def test_motion_does_not_depend_on_the_start_time(new):
    now, later = new().initialize(0.0), new().initialize(4.0)
    for a, b in zip(now.run(0, 1, 16 * H), later.run(4, 5, 16 * H), strict=True):
        assert bits(a) == bits(b)


# communication point (None: the right one), step size
ODD_STEPS = {
    "zero": (None, 0.0), "negative": (None, -H), "nan": (None, math.nan), "infinite": (None, math.inf),
    "time nan": (math.nan, H), "time infinite": (math.inf, H), "back in time": (-1.0, H), "gap": (1.0, H),
    "too small": (None, 1e-300),
}  # fmt: skip


@pytest.mark.parametrize("case", ODD_STEPS)
def test_impossible_steps_are_refused_and_change_nothing(new, case):
    disturbed, straight = new().initialize(), new().initialize()
    disturbed.run(0, 0.125, H)
    straight.run(0, 0.125, H)
    time, size = ODD_STEPS[case]
    disturbed.messages.clear()
    assert disturbed.step(0.125 if time is None else time, size) == DISCARD
    (message,) = disturbed.messages
    assert message.category == "logStatusDiscard"
    assert " s: must " in message.text or "too small" in message.text
    assert disturbed.run(0.125, 0.25, H) == straight.run(0.125, 0.25, H)


def test_the_stop_time_is_reached_but_not_passed(new):
    unit = new().initialize(stop=2 * 0.1)
    assert unit.step(0.0, 0.1) == OK
    assert unit.step(0.1, 0.1 + 1e-15) == OK  # rounding of the importer
    assert unit.step(0.2, 0.1) == ERROR
    assert "stop time" in unit.messages[-1].text
    assert unit.step(0.2, 0.1) == ERROR  # ended until reset


def test_start_outputs_are_there_in_initialization_mode(new):
    unit = new()
    assert unit.enter() == OK
    assert unit.set("start.q", (0.5, -0.25, 0.125, 1.0)) == OK
    before = unit.outputs()
    assert unit.get("q") == pytest.approx((0.5, -0.25, 0.125, 1.0), abs=1e-14)  # through the rotation matrix and back
    assert unit.exit() == OK
    assert unit.outputs() == before


def test_time_is_the_end_of_the_last_step(new):
    unit = new().initialize(3.0)
    assert unit.get("time") == 3.0
    assert unit.step(3.0, H) == OK
    assert unit.get("time") == 3.0 + H
