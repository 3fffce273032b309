"""InitialUnknown of the descriptions: what an initial output depends on is what is declared, found by trying."""

import math
import re

import fmu_driver
import pytest

OK = 0


def components(name, values):
    return {f"{name}[{k}]": value for k, value in enumerate(values, start=1)}


C, S = math.cos(0.1), math.sin(0.1)
OBLIQUE = (
    components("exo.axis1", (S, 0.0, C)) | components("exo.axis2", (C, S, 0.0)) | components("exo.axis3", (S, C * S, C * C))
    | components("exo.base", (0.1, 0.2, 0.3)) | components("exo.cuff", (0.3, 0.1, 0.2))
)  # fmt: skip
RANGES = components("exo.lower", [-4.0] * 6) | components("exo.upper", [4.0] * 6)
# Where the outputs are compared; what a parameter does may show in one of them only.
POINTS = {
    "start values": {},
    "oblique axes": OBLIQUE,
    "smoothed Measured rhythm": {"rhythm.model": 3},
    "axes carried by the girdle": OBLIQUE | {"exo.baseFollowsGirdle": True},
    "other order": OBLIQUE | {"exo.baseFollowsGirdle": True, "exo.girdleOrder": 2},
    "vertical slide on a link": {"exo.girdleDrives": 3, "exo.girdleLink": 0.2},
    "no drives, on a link": {"exo.girdleDrives": 4, "exo.girdleLink": 0.2},
    "slide of the other order": {"exo.girdleDrives": 3, "exo.girdleLink": 0.2, "exo.girdleOrder": 2},
    "link of fixed length": {"exo.girdleDrives": 2, "exo.girdleLink": 0.2, "rhythm.model": 3},
    "given upper arm": {"subject.upperArmLength": 0.3},
    "given lengths": {"subject.upperArmLength": 0.3, "subject.forearmLength": 0.25},
    "ranges": OBLIQUE | RANGES,
    "ranges of the other assembly": OBLIQUE | RANGES | {"exo.upper[4]": 0.5},
    "just out of reach": components("exo.axis2", (0.0, math.sin(0.1), math.cos(0.1)))
    | components("exo.base", (0.06, 0, 0)),
}
# Further values of every parameter; those that the FMU refuses at some point are left out there.
VALUES = {
    "subject.stature": [1.9], "subject.mass": [60.0], "subject.female": [True], "subject.leftArm": [True],
    "subject.upperArmLength": [0.31], "subject.forearmLength": [0.24], "subject.shoulderDistance": [0.2],
    "rhythm.model": [1, 2], "rhythm.gain": [0.5], "rhythm.smoothing": [0.2], "metric.movingShoulder": [False],
    "swivel.mode": [2, 3], "swivel.prescribed": [0.5], "motion.duration": [0.9],
    "metric.axialFactor": [2.0], "motion.timing": [2, 3],
    "exo.girdleOrder": [1, 2], "exo.girdleDrives": [1, 2, 3, 4], "exo.girdleLink": [0.1], "exo.minSingularity": [1.5],
    "exo.baseFollowsGirdle": [True, False],
}  # fmt: skip
VALUES |= {f"exo.axis{k}[{i}]": [] for k in (1, 2, 3) for i in (1, 2, 3)}  # slightly changed, below
VALUES |= {f"exo.{name}[{i}]": [0.05, 0.4] for name in ("base", "cuff") for i in (1, 2, 3)}
VALUES |= {
    f"exo.{end}[{i}]": [-9.0, *(k / 2 for k in range(-7, 8)), 9.0] for end in ("lower", "upper") for i in range(1, 7)
}
VALUES |= components("limits.lower", ([0.05], [-2.0], [-1.2], [0.1]))
VALUES |= components("limits.upper", ([2.0], [0.6], [1.2], [2.0]))
VALUES |= components("start.q", ([0.5, 1.5], [-0.3], [0.4], [1.2]))
AXIS_STEP = 5e-7  # a unit vector may be wrong by 1e-6
ROUNDING = 1e-12  # of angles and lengths of the size of 1; what a parameter does only by rounding is no dependency


def initial_outputs(archive, values):
    """Outputs in initialization by value reference; None if the FMU refuses the values."""
    with fmu_driver.Instance(archive, logging=False) as unit:
        assert unit.enter() == OK
        for name, value in values.items():
            assert unit.set(name, value) == OK, name
        if unit.exit() != OK:
            return None
        return {v.reference: value for v, value in zip(archive.outputs, unit.outputs(), strict=True)}


@pytest.fixture(scope="module")
def found(archives):
    """For each parameter, the outputs that some change of it changes, at any of the points."""
    archive = archives["fmi3"]
    differing = {name: set() for name in VALUES}
    for settings in POINTS.values():
        plain = initial_outputs(archive, settings)
        assert plain is not None
        for name, values in VALUES.items():
            now = settings.get(name, archive.variables[name].start)
            for value in values or [now - AXIS_STEP if now > 0.5 else now + AXIS_STEP]:
                other = initial_outputs(archive, settings | {name: value}) or plain
                differing[name] |= {
                    reference for reference in plain if abs(plain[reference] - other[reference]) > ROUNDING
                }
    return differing


def declared(archive):
    """References of the parameters by reference of the initial output."""
    return {
        int(entry.attrib["valueReference"]): set(map(int, entry.attrib["dependencies"].split()))
        for entry in archive.root.findall("ModelStructure/InitialUnknown")
    }


@pytest.mark.parametrize("name", sorted({re.sub(r"\[\d\]$", "", name) for name in VALUES}))
def test_what_changes_an_initial_output_is_declared(archives, found, name):
    archive = archives["fmi3"]
    entries = declared(archive)
    for scalar in (v for v in archive.variables.values() if v.name == name or v.name.startswith(name + "[")):
        known = {output for output, references in entries.items() if scalar.reference in references}
        assert found[scalar.name] <= known, scalar.name


def test_what_is_declared_changes_the_initial_output(archives, found):
    """Status apart: it changes only where the start posture is at the edge of reach."""
    archive = archives["fmi3"]
    names = {v.reference: v.name for v in archive.variables.values()}
    problems = []
    for output, references in declared(archive).items():
        changed_by = {archive.variables[name].reference for name, outputs in found.items() if output in outputs}
        if names[output] == "status":
            assert changed_by
        else:
            problems += [f"{names[output]} is not changed by {names[k]}" for k in sorted(references - changed_by)]
    assert not problems, "\n".join(problems)


def test_every_parameter_is_tried(archives):
    assert set(VALUES) == {v.name for v in archives["fmi3"].variables.values() if v.causality == "parameter"}


def test_every_output_is_an_initial_unknown(archives):
    assert set(declared(archives["fmi3"])) == {v.reference for v in archives["fmi3"].outputs}
