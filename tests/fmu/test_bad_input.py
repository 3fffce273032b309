"""Bad values: refused with a message that names variable, value, unit and rule; the state is as before."""

import math
import re

import pytest

OK, WARNING, DISCARD, ERROR = range(4)
H = 1 / 512

# variable, value, unit in the message
AT_ONCE = [
    ("subject.stature", math.nan, "m"), ("subject.stature", 0.0, "m"), ("subject.stature", 175.0, "m"),
    ("subject.mass", -75.0, "kg"), ("subject.mass", math.inf, "kg"),
    ("subject.upperArmLength", -0.3, "m"), ("subject.forearmLength", -1e-300, "m"), ("subject.shoulderDistance", 17.0, "m"),
    ("rhythm.model", 0, ""), ("rhythm.model", 4, ""), ("rhythm.gain", 1.6, ""), ("rhythm.smoothing", -0.1, "rad"),
    ("swivel.mode", -1, ""), ("metric.axialFactor", -0.5, ""), ("motion.timing", 4, ""), ("swivel.prescribed", 20.0, "rad"),
    ("motion.duration", 0.0, "s"), ("motion.duration", -1.5, "s"), ("motion.duration", 61.0, "s"),
    ("limits.lower[1]", -0.1, "rad"), ("limits.upper[4]", 145.0, "rad"), ("start.q[1]", 15.0, "rad"),
    ("start.q[2]", math.nan, "rad"), ("exo.axis1[3]", 1.5, ""), ("exo.base[1]", -math.inf, "rad"), ("exo.girdleOrder", 3, ""),
    ("exo.girdleDrives", 0, ""), ("exo.girdleDrives", 5, ""), ("exo.girdleLink", -0.1, "m"), ("exo.girdleLink", 150.0, "m"),
    ("exo.minSingularity", 5.0, "rad"), ("exo.lower[1]", -math.inf, "rad"), ("exo.upper[6]", math.nan, "rad"),
    ("target[1]", math.nan, "m"), ("target[2]", math.inf, "m"), ("target[3]", 420.0, "m"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "value", "unit"), AT_ONCE)
def test_a_bad_value_is_refused_when_it_is_set(new, name, value, unit):
    disturbed, plain = new(), new()
    for instance in (disturbed, plain):
        assert instance.enter() == OK
    before = disturbed.get(name)
    assert disturbed.set(name, value) == DISCARD
    assert disturbed.get(name) == before
    (message,) = disturbed.messages
    assert message.category == "logStatusDiscard"
    shown = f" {unit}" if unit else ""
    assert re.search(
        rf"{re.escape(name)} = \S+{shown}: must (be finite|lie in \S+ \.\. \S+{shown}); nothing", message.text
    )
    for instance in (disturbed, plain):
        assert instance.exit() == OK
    assert disturbed.run(0, 0.25, H) == plain.run(0, 0.25, H)


# parameters that are fine one by one, and the words that the messages must hold
TOGETHER = {
    "limits crossed": ({"limits.lower[2]": 0.5, "limits.upper[2]": -0.5}, ["limits", "rad"]),
    "start outside limits": ({"limits.upper[4]": 0.9}, ["start", "phi", "rad"]),
    "axis of length zero": ({"exo.axis1": (0, 0, 0)}, ["exo.axis1"]),
    "axis not a unit vector": ({"exo.axis2": (1, 1, 0)}, ["exo.axis2"]),
    "between the automatic factor and the least": ({"metric.axialFactor": 0.5}, ["metric.axialFactor", "1..5"]),
    "range crossed": ({"exo.lower[3]": 0.5, "exo.upper[3]": -0.5}, ["exo.lower", "rad"]),
    "carried base without a girdle": ({"exo.baseFollowsGirdle": True, "exo.girdleDrives": 4}, ["girdle", "drives"]),
}


@pytest.mark.parametrize("case", TOGETHER)
def test_contradictory_parameters_end_initialization_with_a_message(new, case):
    parameters, words = TOGETHER[case]
    unit = new()
    assert unit.enter() == OK
    for name, value in parameters.items():
        assert unit.set(name, value) == OK
    assert unit.exit() == ERROR
    errors = [m.text for m in unit.messages if m.category == "logStatusError"]
    assert any(all(word in text for word in words) for text in errors), errors
    assert unit.step(0.0, H) == ERROR
    assert unit.call("Reset") == OK
    fresh = new().initialize()
    assert unit.initialize().run(0, 0.25, H) == fresh.run(0, 0.25, H)


def test_every_problem_is_named(new):
    unit = new()
    assert unit.enter() == OK
    for name, value in {
        "limits.lower[2]": 0.5,
        "limits.upper[2]": -0.5,
        "limits.lower[3]": 1.5,
        "limits.upper[3]": 1,
    }.items():
        assert unit.set(name, value) == OK
    assert unit.exit() == ERROR
    assert len([m for m in unit.messages if m.category == "logStatusError"]) >= 2


def test_a_bad_target_on_the_way_changes_nothing(new):
    disturbed, plain = new().initialize(), new().initialize()
    for unit in (disturbed, plain):
        unit.run(0, 0.5, H)
    assert disturbed.set("target", (0.1, math.nan, 0.1)) == DISCARD  # none of the three is taken
    assert disturbed.run(0.5, 1, H) == plain.run(0.5, 1, H)


def test_a_bad_duration_on_the_way_changes_nothing(new):
    disturbed, plain = new().initialize(), new().initialize()
    assert disturbed.set("motion.duration", 0.01) == DISCARD
    assert "motion.duration = 0.01 s: must lie in 0.05 .. 60 s" in disturbed.messages[-1].text
    assert disturbed.run(0, 1, H) == plain.run(0, 1, H)
