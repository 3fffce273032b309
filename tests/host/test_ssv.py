"""Parameter sets: valid by the standard's schema, true to modelDescription.xml, and with the effect that core predicts."""

import subprocess
import sys
import xml.etree.ElementTree as ET
import zipfile
from pathlib import Path

import fmpy
import fmpy.ssp
import numpy as np
import pytest
from glenoid import _core, ssv
from glenoid.devices import load_device, parse_device
from glenoid.fmus import fmu_path
from glenoid.inputs import ReachInput, load_subject
from glenoid.parameters import NO_RANGE_RAD, device_parameters, subject_parameters
from glenoid.simulate import core_samples, start_values
from lxml import etree
from places import ROOT

SUBJECTS = sorted((ROOT / "host/subjects").glob("*.yaml"))
DEVICES = [path for path in sorted((ROOT / "host/exoskeletons").glob("*.yaml")) if not load_device(path).missing]
OUTPUTS = [*(f"exo.q[{k}]" for k in range(1, 7)), "exo.residual"]
MINE = """
name: mine
shoulder: {a12_deg: 90, a23_deg: 90, min_singularity_deg: 12}
mounts: {base_deg: [20, 0, 0]}
girdle: {drives: NoLength, order: ElevationFirst, base_follows: true, link_m: 0.16}
joints:
  girdle_protraction: {range_rad: [-0.2, 0.3]}
  shoulder_2: {range_deg: [10, 130]}
"""


@pytest.fixture(scope="module", params=["2", "3"])
def archive(request):
    return fmu_path(request.param)


@pytest.fixture
def sets(archive, tmp_path):
    """The sets as an importer finds them."""
    with zipfile.ZipFile(archive) as file:
        for name in file.namelist():
            if name.endswith(".ssv"):
                file.extract(name, tmp_path)
    return tmp_path / "resources"


def test_archive_holds_a_set_for_every_subject_and_complete_device(sets):
    found = {path.relative_to(sets).with_suffix("").as_posix() for path in sets.rglob("*.ssv")}
    assert found == {f"subjects/{p.stem}" for p in SUBJECTS} | {f"exoskeletons/{p.stem}" for p in DEVICES}


def test_sets_are_valid_by_the_schema_of_the_standard(sets):
    schema = etree.XMLSchema(etree.parse(Path(fmpy.ssp.__file__).parent / "schema/SystemStructureParameterValues.xsd"))
    for path in sets.rglob("*.ssv"):
        schema.assertValid(etree.parse(path))


def test_parameters_have_name_type_unit_and_range_of_the_description(sets, archive):
    variables = {v.name: v for v in fmpy.read_model_description(archive, validate=False).modelVariables}
    kinds = {"Boolean": "Boolean", "Enumeration": "Enumeration", "Real": "Real", "Float64": "Real"}
    for path in sets.rglob("*.ssv"):
        for parameter in ET.parse(path).getroot().iter(f"{{{ssv.SSV}}}Parameter"):
            variable, value = variables[parameter.attrib["name"]], parameter[0]
            assert variable.causality == "parameter"
            assert value.tag == f"{{{ssv.SSV}}}{kinds[variable.type]}", variable.name
            if kinds[variable.type] == "Real":
                assert value.get("unit") == variable.unit, variable.name
                assert float(variable.min) <= float(value.attrib["value"]) <= float(variable.max), variable.name
            if variable.type == "Enumeration":
                items = [item.name for item in variable.declaredType.items]
                assert value.attrib["value"] in items


@pytest.mark.parametrize("path", SUBJECTS, ids=lambda path: path.stem)
def test_what_is_read_is_what_the_subject_s_file_says(path, sets):
    assert ssv.read(sets / f"subjects/{path.stem}.ssv") == subject_parameters(load_subject(path))


@pytest.mark.parametrize("path", DEVICES, ids=lambda path: path.stem)
def test_what_is_read_is_what_the_device_s_file_says(path, sets):
    assert ssv.read(sets / f"exoskeletons/{path.stem}.ssv") == device_parameters(load_device(path))


def test_a_set_names_what_it_cannot_carry(sets):
    text = (sets / "subjects/own_measurements.ssv").read_text(encoding="utf-8")
    assert "forearm_mass_kg" in text


def test_a_device_s_set_gives_every_parameter_of_the_device(sets, archive):
    description = fmpy.read_model_description(archive, validate=False).modelVariables
    names = {v.name for v in description if v.causality == "parameter" and v.name.startswith("exo.")}
    for path in DEVICES:
        assert set(ssv.read(sets / f"exoskeletons/{path.stem}.ssv")) == names


def test_figures_of_a_device_s_file_are_those_of_its_parameters():
    values = device_parameters(parse_device(MINE, Path("mine.yaml")))
    expected = {
        "exo.girdleOrder": 2, "exo.girdleDrives": 2, "exo.girdleLink": 0.16, "exo.baseFollowsGirdle": True,
        "exo.minSingularity": np.deg2rad(12.0), "exo.lower[1]": -0.2, "exo.upper[1]": 0.3, "exo.lower[4]": np.deg2rad(10.0),
        "exo.upper[4]": np.deg2rad(130.0), "exo.lower[6]": -NO_RANGE_RAD, "exo.upper[6]": NO_RANGE_RAD,
        "exo.base[1]": np.deg2rad(20.0),
    }  # fmt: skip
    assert {name: values[name] for name in expected} == expected


@pytest.mark.parametrize("drives", ["Full", "NoLength", "VerticalOnly", "NoDrives"])
def test_drives_have_the_numbers_of_the_core(drives):
    device = parse_device(
        f"name: d\nshoulder: {{a12_deg: 90, a23_deg: 90}}\ngirdle: {{drives: {drives}}}\n", Path("d.yaml")
    )
    assert device_parameters(device)["exo.girdleDrives"] == getattr(_core.GirdleDrives, drives).value
    assert _core.NO_EXO_LIMIT_RAD == NO_RANGE_RAD


def simulate(archive, values):
    result = fmpy.simulate_fmu(
        str(archive), validate=False, fmi_type="CoSimulation", stop_time=1.5, output_interval=0.05,
        start_values=values, output=["q[1]", *OUTPUTS],
    )  # fmt: skip
    return np.array(result["time"]), np.column_stack([result[name] for name in ("q[1]", *OUTPUTS)])


@pytest.mark.parametrize(
    ("person", "device"), [("p50_female", None), ("reduced_range", "harmony"), (None, "generic_60_60"), (None, "exorn")]
)
def test_applied_sets_change_the_result_as_they_do_in_the_core(person, device, sets, archive):
    target = (0.15, 0.38, 0.0)
    subject = load_subject(ROOT / f"host/subjects/{person}.yaml") if person else ReachInput().subject
    reach = ReachInput(subject=subject, target_m=target)
    values = {f"target[{k}]": value for k, value in enumerate(target, start=1)}
    plain = simulate(archive, values)[1]
    for folder, name in (("subjects", person), ("exoskeletons", device)):
        if name is not None:
            values |= ssv.read(sets / folder / f"{name}.ssv")
    time_s, found = simulate(archive, values)
    core = core_samples(reach, time_s, load_device(device) if device else None)
    assert np.array_equal(found, np.column_stack([core["q_rad"][:, 0], core["exo_q_rad"], core["exo_residual_m"]]))
    assert np.abs(found - plain).max() > 1e-2


def test_start_values_of_a_simulation_are_those_of_the_sets(sets):
    device = load_device("generic_60_60")
    values = start_values(ReachInput(), np.zeros(3), device)
    for name in ("subjects/p50_male", "exoskeletons/generic_60_60"):
        for key, value in ssv.read(sets / f"{name}.ssv").items():
            assert values[key] == value, key


def test_the_same_files_give_the_same_bytes(tmp_path):
    for folder in ("a", "b"):
        ssv.write_all(ROOT / "host", tmp_path / folder)
    names = sorted(path.relative_to(tmp_path / "a") for path in (tmp_path / "a").rglob("*.ssv"))
    assert len(names) == len(SUBJECTS) + len(DEVICES)
    for name in names:
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()


def test_reading_files_needs_no_compiled_module():
    code = "import sys, glenoid.ssv; sys.exit('glenoid._core' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
