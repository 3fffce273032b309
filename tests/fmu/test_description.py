"""The descriptions: schemas, agreement of the two versions, agreement with the compiled table and with the core."""

import math
import re
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import fmpy
import fmpy.validation
import fmu_driver
import pytest
from lxml import etree

OK = 0
SCHEMAS = Path(fmpy.__file__).parent / "schema"
ROOT = fmu_driver.ROOT


def schema_errors(schema, document):
    checker = etree.XMLSchema(file=str(SCHEMAS / schema))
    checker.validate(etree.parse(str(document)))
    return [str(entry) for entry in checker.error_log]


@pytest.mark.parametrize(
    ("document", "schema"),
    [
        ("modelDescription.xml", None),
        ("sources/buildDescription.xml", "fmi3/fmi3BuildDescription.xsd"),
        ("terminalsAndIcons/terminalsAndIcons.xml", "fmi3/fmi3TerminalsAndIcons.xsd"),
    ],
)
def test_documents_follow_their_schemas(archive, document, schema):
    schema = schema or f"fmi{archive.version}/fmi{archive.version}ModelDescription.xsd"
    assert schema_errors(schema, archive.folder / document) == []


def test_fmpy_finds_no_problem(archive):
    assert fmpy.validation.validate_fmu(str(archive.path)) == []


def test_both_versions_describe_the_same_variables(archives):
    two, three = (
        [
            (*v[:-1], v.element.get("displayUnit"), v.element.get("declaredType"))
            for v in archives[key].variables.values()
        ]
        for key in ("fmi2", "fmi3")
    )
    assert two == three
    assert archives["fmi2"].token == archives["fmi3"].token


def test_the_packed_description_is_the_hand_kept_one(archives):
    assert (archives["fmi3"].folder / "modelDescription.xml").read_bytes() == (
        ROOT / "modelDescription.xml"
    ).read_bytes()


def test_every_real_variable_has_a_defined_unit(archive):
    defined = {unit.attrib["name"]: unit for unit in archive.root.find("UnitDefinitions")}
    for variable in archive.variables.values():
        if variable.kind == "real":
            assert variable.unit in defined, variable.name
            display = variable.element.get("displayUnit")
            assert display is None or display in {d.get("name") for d in defined[variable.unit].findall("DisplayUnit")}


def test_every_variable_is_described(archive):
    elements = archive.root.find("ModelVariables")
    assert all(len(element.get("description", "")) > 5 for element in elements)


def test_start_values_are_those_of_the_library(archive):
    with fmu_driver.Instance(archive) as unit:
        assert unit.enter() == OK
        for variable in archive.variables.values():
            if variable.start is not None:
                assert unit.get(variable.name) == variable.start, variable.name


def test_start_values_lie_in_their_ranges(archive):
    for v in archive.variables.values():
        if v.start is not None:
            assert v.minimum <= v.start <= v.maximum, v.name


def test_start_values_are_the_defaults_of_the_core(core, archives):
    variables = archives["fmi3"].variables
    settings = core.MotionSettings()

    def start(name):
        if name in variables:
            return variables[name].start
        return [v.start for v in variables.values() if v.name.startswith(name + "[")]

    assert start("subject.stature") == settings.subject.stature_m
    assert start("subject.mass") == settings.subject.mass_kg
    assert start("rhythm.model") == settings.rhythm.model.value
    assert start("rhythm.gain") == settings.rhythm.gain
    assert start("rhythm.smoothing") == settings.rhythm.smoothing_rad
    assert start("metric.movingShoulder") == settings.moving_shoulder
    assert start("swivel.mode") == settings.swivel_mode.value
    assert start("swivel.prescribed") == settings.swivel_prescribed_rad
    assert start("motion.duration") == settings.duration_s
    assert start("limits.lower") == list(settings.limits.lower_rad)
    assert start("limits.upper") == list(settings.limits.upper_rad)
    assert start("start.q") == list(settings.start_q_rad)


def test_enumerations_are_those_of_the_core(core, archives):
    types = archives["fmi3"].root.find("TypeDefinitions")
    for name in ("RhythmModel", "SwivelMode", "MotionStatus"):
        items = {i.attrib["name"]: int(i.attrib["value"]) for i in types.find(f"*[@name='{name}']")}
        assert items == {member.name: member.value for member in getattr(core, name)}


def test_terminals_name_existing_variables(archive):
    document = ET.parse(archive.folder / "terminalsAndIcons/terminalsAndIcons.xml")
    names = [member.attrib["variableName"] for member in document.iter("TerminalMemberVariable")]
    assert set(names) <= set(archive.variables)
    assert len(set(names)) == len(names)
    inputs = {v.name for v in archive.variables.values() if v.causality == "input"}
    assert inputs <= set(names)


# A second value of every parameter that keeps the whole set valid.
OTHER_VALUES = {
    "subject.stature": 1.9, "subject.mass": 60.0, "subject.female": True, "subject.leftArm": True,
    "subject.upperArmLength": 0.31, "subject.forearmLength": 0.24, "subject.shoulderDistance": 0.2, "rhythm.model": 1,
    "rhythm.gain": 0.5, "rhythm.smoothing": 0.2, "metric.movingShoulder": False, "swivel.mode": 2, "swivel.prescribed": 0.5,
    "motion.duration": 0.9, "exo.girdleOrder": 2,
    "exo.axis1": (0.0, math.sin(0.1), math.cos(0.1)), "exo.axis2": (math.cos(0.1), math.sin(0.1), 0.0),
    "exo.axis3": (0.0, math.sin(0.2), math.cos(0.2)), "exo.base": (0.01, 0.02, 0.03), "exo.cuff": (0.03, 0.01, 0.02),
    "limits.lower": (0.05, -2.0, -1.2, 0.1), "limits.upper": (2.0, 0.6, 1.2, 2.0), "start.q": (0.5, -0.3, 0.4, 1.2),
}  # fmt: skip


@pytest.mark.parametrize("name", OTHER_VALUES)
def test_initial_outputs_depend_on_what_is_declared_and_no_more(archives, name):
    archive = archives["fmi3"]
    changed = {v.reference for v in archive.variables.values() if v.name == name or v.name.startswith(name + "[")}
    declared = {
        int(entry.attrib["valueReference"])
        for entry in archive.root.findall("ModelStructure/InitialUnknown")
        if changed & set(map(int, entry.attrib["dependencies"].split()))
    }
    with fmu_driver.Instance(archive) as plain, fmu_driver.Instance(archive) as other:
        plain.initialize()
        other.initialize(**{name: OTHER_VALUES[name]})
        pairs = zip(archive.outputs, plain.outputs(), other.outputs(), strict=True)
        differing = {v.reference for v, a, b in pairs if a != b}
    assert differing <= declared


def test_every_parameter_is_tried_above(archives):
    parameters = {
        re.sub(r"\[\d\]$", "", v.name) for v in archives["fmi3"].variables.values() if v.causality == "parameter"
    }
    assert parameters == set(OTHER_VALUES)


def test_an_output_does_not_depend_on_inputs_of_the_same_moment(archive):
    """ModelStructure declares no direct feedthrough."""
    assert all(entry.get("dependencies") == "" for entry in archive.root.findall("ModelStructure/Output"))
    with fmu_driver.Instance(archive) as unit:
        unit.initialize()
        unit.run(0, 0.5, 1 / 512)
        before = unit.outputs()
        assert unit.set("target", (0.1, 0.45, 0.1)) == OK
        assert unit.set("stop", True) == OK
        assert unit.outputs() == before


def test_documented_variables_are_those_of_the_description(archives):
    """docs/fmu.md names every variable (vectors by their name) with its value reference."""
    text = (ROOT / "docs/fmu.md").read_text(encoding="utf-8")
    rows = dict(re.findall(r"^\| `([^`]+)` \| (\d+)(?: \.\. \d+)? \|", text, re.MULTILINE))
    variables = archives["fmi3"].variables.values()
    expected = {
        re.sub(r"\[1\]$", "", v.name): str(v.reference) for v in variables if not re.search(r"\[[2-9]\]$", v.name)
    }
    assert rows == expected


def test_generated_fmi2_description_is_the_packed_one(archives, tmp_path):
    """The generator is a program of its own too."""
    names = [f.attrib["name"] for f in archives["fmi2"].root.iter("File")]
    script = ROOT / "fmu/scripts/generate_fmi2.py"
    command = [sys.executable, str(script), str(ROOT / "modelDescription.xml"), str(tmp_path / "md.xml"), *names]
    subprocess.run(command, check=True)
    packed = (archives["fmi2"].folder / "modelDescription.xml").read_bytes()
    assert etree.tostring(etree.fromstring((tmp_path / "md.xml").read_bytes()), method="c14n") == etree.tostring(
        etree.fromstring(packed), method="c14n"
    )
