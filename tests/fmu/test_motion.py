"""What the arm does when the inputs change on the way."""

import math

import pytest

OK, WARNING, DISCARD, ERROR = range(4)
H = 1 / 512
IDLE, MOVING, ARRIVED, STOPPED, UNREACHABLE, LIMITS, EXO, FAILED = range(1, 9)


def state(unit):
    return [unit.get(name) for name in ("q", "dq", "ddq")]


def test_arrives_at_the_target(new):
    unit = new().initialize()
    assert unit.get("status") == IDLE
    unit.run(0, 1, H)
    assert unit.get("status") == MOVING
    assert 0 < unit.get("progress") < 1
    unit.run(1, 1.75, H)
    assert unit.get("status") == ARRIVED
    assert unit.get("progress") == 1
    assert math.dist(unit.get("wrist"), unit.get("target")) < 1e-6  # interpolation error of the path, CONTRACT of core
    assert max(map(abs, unit.get("dq") + unit.get("ddq"))) == 0


def disturb_target(unit):
    assert unit.set("target", (0.10, 0.45, 0.05)) == OK


def disturb_stop(unit):
    assert unit.set("stop", True) == OK


def disturb_enable(unit):
    assert unit.set("enable", False) == OK
    assert unit.set("target", (0.10, 0.45, 0.05)) == OK


def disturb_unreachable(unit):
    assert unit.set("target", (2.0, 2.0, 2.0)) == OK


@pytest.mark.parametrize("moment", [0.25, 0.75, 1.25])
@pytest.mark.parametrize("disturb", [disturb_target, disturb_stop, disturb_enable, disturb_unreachable])
def test_q_dq_ddq_do_not_jump(new, disturb, moment):
    """Just after the change the state differs from that just before by no more than rates times time allow."""
    unit = new().initialize()
    unit.run(0, moment, H)
    before = state(unit)
    disturb(unit)
    tiny = 2.0**-20
    assert unit.step(moment, tiny) == OK
    after = state(unit)
    # Rates over `tiny` seconds: dq <= 10 rad/s, ddq <= 200 rad/s2, dddq <= 2e4 rad/s3 for movements of a second;
    # each is some times what this reach does, and a jump would be of the size of the values themselves.
    for old, fresh, rate in zip(before, after, (10.0, 200.0, 2e4), strict=True):
        assert max(abs(a - b) for a, b in zip(old, fresh, strict=True)) < rate * tiny + 1e-9


def test_stop_brings_the_arm_to_rest_on_its_path(new):
    straight, unit = new().initialize(), new().initialize()
    path = [row[:4] for row in straight.run(0, 1.75, H)]
    unit.run(0, 0.75, H)
    assert unit.set("stop", True) == OK
    rows = unit.run(0.75, 2.75, H)
    assert unit.get("status") == STOPPED
    assert max(map(abs, unit.get("dq") + unit.get("ddq"))) == 0
    # Distance to the nearest sample of the undisturbed path: at most half of the way within one step.
    spacing = max(math.dist(a, b) for a, b in zip(path, path[1:], strict=False))
    assert max(min(math.dist(row[:4], q) for q in path) for row in rows) <= spacing
    still = unit.get("q")
    assert unit.set("stop", False) == OK
    unit.run(2.75, 3.0, H)
    assert unit.get("q") == still  # the same target is not a new movement


def test_without_enable_nothing_starts(new):
    unit = new()
    assert unit.enter() == OK
    assert unit.set("enable", False) == OK
    assert unit.exit() == OK
    start = unit.get("q")
    unit.run(0, 0.5, H)
    assert unit.get("q") == start
    assert unit.get("status") == IDLE
    assert unit.set("enable", True) == OK
    unit.run(0.5, 0.75, H)
    assert unit.get("status") == MOVING


def test_targets_within_a_millimetre_are_the_same(new):
    straight, unit = new().initialize(), new().initialize()
    straight.run(0, 0.5, H)
    unit.run(0, 0.5, H)
    assert unit.set("target[3]", unit.get("target[3]") + 0.9e-3) == OK
    assert unit.run(0.5, 1, H) == straight.run(0.5, 1, H)


def test_duration_is_that_of_later_movements(new):
    straight, unit = new().initialize(), new().initialize()
    straight.run(0, 0.5, H)
    unit.run(0, 0.5, H)
    assert unit.set("motion.duration", 0.5) == OK
    assert unit.run(0.5, 2, H) == straight.run(0.5, 2, H)
    assert unit.set("target", (0.10, 0.45, 0.05)) == OK
    unit.run(2, 2.5 - H, H)
    assert unit.get("status") == MOVING
    unit.run(2.5 - H, 2.5 + H, H)
    assert unit.get("status") == ARRIVED


@pytest.mark.parametrize("same", [True, False])
def test_after_a_stop_only_another_target_starts_a_movement(new, same):
    unit = new().initialize()
    unit.run(0, 0.75, H)
    assert unit.set("stop", True) == OK
    unit.run(0.75, 1.75, H)
    still, target = unit.get("q"), unit.get("target")
    assert unit.get("status") == STOPPED
    assert unit.set("stop", False) == OK
    assert unit.set("target[3]", target[2] + (0.9e-3 if same else 1.1e-3)) == OK
    unit.run(1.75, 3.5, H)
    if same:
        assert unit.get("status") == STOPPED
        assert unit.get("q") == still
    else:
        assert unit.get("status") == ARRIVED
        assert math.dist(unit.get("wrist"), unit.get("target")) < 1e-6


REFUSED = {
    "out of reach": ({}, (1.0, 1.0, 1.0), UNREACHABLE, "out of reach"),
    "behind the limits": (
        {"limits.upper[4]": 1.2, "limits.lower[4]": 0.9},
        (0.10, 0.12, -0.12),
        LIMITS,
        "limits",
    ),
    "joint range": ({"exo.upper[4]": 1.0}, (0.20, 0.42, 0.25), EXO, "Shoulder2 is beyond its upper limit"),
    "range of a girdle joint": ({"exo.upper[2]": 0.1}, (0.20, 0.42, 0.25), EXO, "GirdleElevation is beyond"),
    "near singular": ({"exo.minSingularity": 1.0}, (0.20, 0.42, 0.25), EXO, "singular"),
    "axes out of reach": (
        {"exo.axis2": (0.6, 0.0, 0.8), "exo.axis3": (0.0, 0.0, 1.0), "start.q": (0.6, -0.5, 0.5, 1.0)},
        (0.20, 0.42, 0.25),
        EXO,
        "out of reach of its axes",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_a_refused_target_leaves_a_resting_arm_at_rest(new, case):
    parameters, target, status, words = REFUSED[case]
    unit = new()
    unit.initialize(**parameters, target=target)
    start = unit.get("q")
    for row in unit.run(0, 1, 16 * H):
        assert all(map(math.isfinite, row))
    assert unit.get("status") == status
    assert unit.get("q") == start
    assert max(map(abs, unit.get("dq") + unit.get("ddq"))) == 0
    (warning,) = [m for m in unit.messages if m.category == "logStatusWarning"]
    assert "target" in warning.text
    assert words in warning.text
    assert unit.set("target", (0.20, 0.42, 0.25)) == OK  # a good one is served again
    if not parameters:
        assert unit.step(1.0, 1.75) == OK
        assert unit.get("status") == ARRIVED


def test_a_refused_target_on_the_way_stops_the_arm(new):
    unit = new().initialize()
    unit.run(0, 0.75, H)
    assert unit.set("target", (1.0, 1.0, 1.0)) == OK
    unit.run(0.75, 2.5, H)
    assert unit.get("status") == UNREACHABLE
    assert max(map(abs, unit.get("dq") + unit.get("ddq"))) == 0


def test_left_arm_mirrors_the_right_one_in_its_own_frame(new):
    """x points to the person's own right for both arms, so the mirrored target gives the same angles."""
    right = new()
    right.initialize()
    x, y, z = right.get("target")
    left = new()
    left.initialize(**{"subject.leftArm": True}, target=(-x, y, z))
    for a, b in zip(right.run(0, 1.75, 16 * H), left.run(0, 1.75, 16 * H), strict=True):
        assert a[:4] == b[:4]
    assert left.get("wrist") == [-right.get("wrist[1]"), right.get("wrist[2]"), right.get("wrist[3]")]


DERIVATIVES = [("q", 1, "dq"), ("q", 2, "ddq"), ("dq", 1, "ddq"), ("exo.q", 1, "exo.dq")]


def output_derivatives(unit, variables, order):
    import ctypes

    n = len(variables)
    references = (ctypes.c_uint32 * n)(*[v.reference for v in variables])
    orders, values = (ctypes.c_int32 * n)(*[order] * n), (ctypes.c_double * n)()
    size = ctypes.c_size_t(n)
    if unit.archive.version == 2:
        return unit.call("GetRealOutputDerivatives", references, size, orders, values), list(values)
    return unit.call("GetOutputDerivatives", references, size, orders, values, size), list(values)


@pytest.mark.parametrize(("name", "order", "rate"), DERIVATIVES)
def test_output_derivatives_are_the_rates(new, name, order, rate):
    unit = new().initialize()
    unit.run(0, 0.5, H)
    variables = [v for v in unit.archive.variables.values() if v.name.startswith(name + "[")]
    assert output_derivatives(unit, variables, order) == (OK, unit.get(rate))


def test_exo_acceleration_is_the_slope_of_the_rate(new):
    unit = new().initialize()
    unit.run(0, 0.5, H)
    variables = [v for v in unit.archive.variables.values() if v.name.startswith("exo.q[")]
    _, acceleration = output_derivatives(unit, variables, 2)
    old = unit.get("exo.dq")
    tiny = 2.0**-16
    assert unit.step(0.5, tiny) == OK
    # forward difference: half the jerk (below 2000 rad/s3) times the step, and rounding over the step
    allowed = 1000 * tiny + 1e-14 / tiny
    for a, before, after in zip(acceleration, old, unit.get("exo.dq"), strict=True):
        assert abs((after - before) / tiny - a) < allowed


@pytest.mark.parametrize(("name", "order"), [("wrist[1]", 1), ("q[1]", 3), ("q[1]", 0), ("dq[1]", 2), ("energy", 1)])
def test_other_output_derivatives_are_refused(new, name, order):
    unit = new().initialize()
    unit.run(0, 0.5, H)
    assert output_derivatives(unit, [unit.archive.variables[name]], order)[0] == DISCARD
    assert name in unit.messages[-1].text
    unit.run(0.5, 0.625, H)
