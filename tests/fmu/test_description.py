"""The descriptions: schemas, agreement of the two versions, agreement with the compiled table and with the core."""

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
    assert start("metric.axialFactor") == settings.axial_factor
    assert start("motion.timing") == settings.timing.value
    assert start("swivel.prescribed") == settings.swivel_prescribed_rad
    assert start("motion.duration") == settings.duration_s
    assert start("limits.lower") == list(settings.limits.lower_rad)
    assert start("limits.upper") == list(settings.limits.upper_rad)
    assert start("start.q") == list(settings.start_q_rad)
    exo = settings.exo
    assert [start(f"exo.axis{k}") for k in (1, 2, 3)] == exo.axes.tolist()
    assert start("exo.base") == list(exo.base_rad)
    assert start("exo.cuff") == list(exo.cuff_rad)
    assert start("exo.girdleOrder") == exo.girdle_order.value
    assert start("exo.girdleDrives") == exo.girdle_drives.value
    assert start("exo.girdleLink") == exo.girdle_link_m
    assert start("exo.baseFollowsGirdle") == exo.base_follows_girdle
    assert start("exo.minSingularity") == exo.min_singularity_rad
    assert start("exo.lower") == list(exo.lower_rad)
    assert start("exo.upper") == list(exo.upper_rad)


def test_enumerations_are_those_of_the_core(core, archives):
    types = archives["fmi3"].root.find("TypeDefinitions")
    for name in ("RhythmModel", "SwivelMode", "TimingLaw", "GirdleOrder", "GirdleDrives", "MotionStatus"):
        items = {i.attrib["name"]: int(i.attrib["value"]) for i in types.find(f"*[@name='{name}']")}
        members = {member.name: member.value for member in getattr(core, name)}
        if name == "GirdleDrives":
            members["None"] = members.pop("NoDrives")  # None is no name in Python
        assert items == members


def test_terminals_name_existing_variables(archive):
    document = ET.parse(archive.folder / "terminalsAndIcons/terminalsAndIcons.xml")
    names = [member.attrib["variableName"] for member in document.iter("TerminalMemberVariable")]
    assert set(names) <= set(archive.variables)
    assert len(set(names)) == len(names)
    inputs = {v.name for v in archive.variables.values() if v.causality == "input"}
    assert inputs <= set(names)


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
    """docs/fmu.md names every variable (vectors by their name) with its value reference; then comes its causality."""
    text = (ROOT / "docs/fmu.md").read_text(encoding="utf-8")
    rows = dict(re.findall(r"^\| `([^`]+)` \| (\d+)(?: \.\. \d+)? \| [a-z]", text, re.MULTILINE))
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
