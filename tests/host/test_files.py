"""The files that are shipped: subjects, the measured reach, their schemas; and `glenoid info`."""

import hashlib
import re
from pathlib import Path

import jsonschema
import numpy as np
import pytest
import yaml
from glenoid import _core
from glenoid.inputs import ReachInput, load_reach, load_subject
from glenoid.reach import plan_reach
from glenoid.settings import core_subject
from glenoid.sweep.study import cases_of, load_study
from places import EXAMPLE, ROOT

SUBJECTS = sorted((ROOT / "host/subjects").glob("*.yaml"))
REACHES = sorted((ROOT / "host/examples").glob("reach_*.yaml"))


@pytest.mark.parametrize("file", SUBJECTS, ids=lambda path: path.stem)
def test_subject_is_valid_and_can_reach(file, run):
    schema = run("info", "--schema", "subject").json
    jsonschema.validate(yaml.safe_load(file.read_text(encoding="utf-8")), schema)
    person = load_subject(file)
    assert plan_reach(ReachInput(subject=person, target_m=(0.15, 0.40, 0.05))).ok


@pytest.mark.parametrize("file", REACHES, ids=lambda path: path.stem)
def test_reach_is_valid_and_names_its_source(file, run):
    jsonschema.validate(yaml.safe_load(file.read_text(encoding="utf-8")), run("info", "--schema", "reach").json)
    assert "MIT" in load_reach(file).source


def example_of(document, first_words):
    """The YAML block of a document that begins so."""
    text = (ROOT / "docs" / document).read_text(encoding="utf-8")
    return next(block for block in re.findall(r"```yaml\n(.*?)```", text, re.DOTALL) if block.startswith(first_words))


@pytest.mark.parametrize("command", ["info", "plan", "simulate"])
def test_the_device_of_the_documentation_follows_the_default_reach(command, run, tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text(example_of("exoskeletons.md", "name: mine"), encoding="utf-8")
    assert run(command, "--exo", file).code == 0


def test_the_study_of_the_documentation_is_one(tmp_path):
    file = tmp_path / "study.yaml"
    device = tmp_path / "mine.yaml"
    device.write_text(example_of("exoskeletons.md", "name: mine"), encoding="utf-8")
    text = example_of("sweep.md", "name:").replace("mine.yaml", str(device))
    assert str(device) in text
    file.write_text(text, encoding="utf-8")
    study = load_study(file)
    assert len(list(cases_of(study))) == 2 * study.draws * len(study.exoskeletons)


def test_schema_refuses_what_the_loader_refuses(run):
    schema = run("info", "--schema", "reach").json
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate({"traget_m": [1, 2, 3]}, schema)


def test_measured_reach_is_consistent():
    """The file's own start: lengths, start posture and shoulder put the wrist where the movement began."""
    reach = load_reach(EXAMPLE)
    generator = plan_reach(reach).generator
    points = _core.forward_kinematics(generator.arm, _core.posture_from_angles(np.array(reach.start_rad)))
    # The four-angle model with constant lengths reproduces a measured wrist to a few millimetres.
    assert np.linalg.norm(points.wrist_m - np.array(reach.measured.wrist_path_m[0])) < 0.01
    assert np.array_equal(reach.measured.wrist_path_m[-1], reach.target_m)


def test_info_tells_version_fmus_and_models(run):
    data = run("info", "--json").json
    assert data["version"] == _core.version
    for fmu in data["fmus"]:
        assert fmu["sha256"] == hashlib.sha256(Path(fmu["path"]).read_bytes()).hexdigest()
    assert data["rhythms"]["SoltaniZarrin2017"]
    assert data["swivel_modes"]["MinimumEnergy"]


def test_info_tells_where_each_figure_of_a_subject_comes_from(run, tmp_path):
    file = tmp_path / "me.yaml"
    file.write_text("stature_m: 1.8\nupper_arm_length_m: 0.333\n", encoding="utf-8")
    entries = {entry["name"]: entry for entry in run("info", "--subject", file, "--json").json["subject"]["scaling"]}
    given = [entry for entry in entries.values() if entry["value"] == 0.333]
    assert given
    assert "given" in given[0]["source"]
    scaled = [entry for entry in entries.values() if "given" not in entry["source"]]
    assert scaled
    assert all(entry["source"] for entry in scaled)


def test_every_override_reaches_the_core():
    person = load_subject(ROOT / "host/subjects/p50_male.yaml").model_copy(
        update={"forearm_mass_kg": 1.7, "upper_arm_inertia_kg_m2": (0.01, 0.011, 0.002), "forearm_com_m": 0.11}
    )
    scaled = _core.scale_subject(core_subject(person))
    assert scaled.forearm.mass_kg == 1.7
    assert scaled.forearm.com_m == 0.11
    assert scaled.upper_arm.inertia_kg_m2.tolist() == [0.01, 0.011, 0.002]
