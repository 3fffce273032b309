"""`glenoid sweep`: what is drawn, what a row says, and that rows depend on nothing but their own case."""

import csv
import json

import jsonschema
import numpy as np
import pytest
import scipy.stats
import yaml
from glenoid.devices import JOINTS, load_device
from glenoid.exo import core_exo
from glenoid.inputs import ReachInput
from glenoid.reach import plan_reach
from glenoid.sweep import run as sweep_run
from glenoid.sweep.run import run_study
from glenoid.sweep.study import Normal, Range, cases_of, load_study
from hypothesis import given
from hypothesis import strategies as st
from places import ROOT

EXAMPLE = ROOT / "host/examples/sweep_shoulder_ranges.yaml"
PERSONS = {"women": {"subject.sex": "female", "subject.stature_m": {"mean": 1.63, "sd": 0.07, "min": 1.5, "max": 1.8}}}
TASKS = {"shelf": {"target_m": {"min": [0.1, 0.35, 0.1], "max": [0.2, 0.4, 0.2]}}}
STUDY = {"draws": 3, "groups": PERSONS, "tasks": TASKS}


@pytest.fixture
def study_file(tmp_path):
    def write(data):
        file = tmp_path / "study.yaml"
        file.write_text(yaml.safe_dump(data, sort_keys=False), encoding="utf-8")
        return file

    return write


@pytest.fixture
def rows_of(study_file):
    def rows(**data):
        return list(run_study(load_study(study_file(STUDY | data)), 1))

    return rows


@given(st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_draws_lie_within_their_bounds_in_order(first, second):
    for kind in (Range(min=-1.0, max=2.0), Normal(mean=0.5, sd=0.3, min=-1.0, max=2.0)):
        low, high = sorted((kind.at(first), kind.at(second)))
        assert -1.0 <= low <= high <= 2.0
        assert (low == kind.at(min(first, second))) or low == high


@given(st.floats(0.01, 0.99))
def test_a_normal_draw_is_the_quantile_of_the_truncated_normal(share):
    ours = Normal(mean=1.7, sd=0.1, min=1.55, max=2.0).at(share)
    law = scipy.stats.truncnorm((1.55 - 1.7) / 0.1, (2.0 - 1.7) / 0.1, loc=1.7, scale=0.1)
    # Both invert the same distribution; ndtri and ppf are good to some 1e-15 relative, times the slope of the quantile.
    assert law.cdf(ours) == pytest.approx(share, abs=1e-12)


def test_draws_of_a_key_fill_its_range(study_file):
    study = load_study(study_file(STUDY | {"draws": 400}))
    drawn = [case.values["target_m"][0] for case in cases_of(study)]
    # Kolmogorov-Smirnov: a right sampler fails with the probability 1e-4, and the seed is fixed.
    assert scipy.stats.kstest(drawn, scipy.stats.uniform(0.1, 0.1).cdf).pvalue > 1e-4


def test_rows_do_not_depend_on_the_number_of_processes(study_file, monkeypatch):
    study = load_study(study_file(STUDY | {"exoskeletons": ["generic_75_75"]}))
    monkeypatch.setattr(sweep_run, "CHUNK", 2)
    assert list(run_study(study, 1)) == list(run_study(study, 2))


def key_of(row):
    return tuple(row[name] for name in ("group", "task", "draw", "exo"))


@pytest.mark.parametrize(
    "more",
    [
        {"groups": {"men": {"subject.stature_m": 1.8}} | PERSONS},
        {"tasks": {"near": {"target_m": [0.1, 0.3, 0.0]}} | TASKS},
        {"exoskeletons": ["generic_60_60", "generic_75_75"]},
        {"draws": 5},
    ],
    ids=["group", "task", "device", "draws"],
)
def test_what_is_added_to_a_study_changes_no_other_row(rows_of, more):
    device = {"exoskeletons": ["generic_75_75"]}
    few = {key_of(row): row | {"case": 0} for row in rows_of(**device)}
    many = {key_of(row): row | {"case": 0} for row in rows_of(**(device | more))}
    assert len(many) > len(few)
    for key, row in few.items():
        extra = many[key]
        assert {name: extra[name] for name in row} == row


def test_another_seed_draws_others(rows_of):
    assert rows_of(seed=1)[0]["subject.stature_m"] != rows_of(seed=2)[0]["subject.stature_m"]


def test_a_row_is_what_a_single_plan_says(rows_of):
    (row,) = rows_of(draws=1, exoskeletons=["generic_75_75"])
    subject = {"sex": "female", "stature_m": row["subject.stature_m"]}
    reach = ReachInput.model_validate({"subject": subject, "target_m": row["target_m"]})
    planned = plan_reach(reach, 100 / reach.duration_s, core_exo(load_device("generic_75_75"), reach.subject))
    assert row["status"] == planned.status == "ok"
    assert row["energy_kg_m2"] == planned.generator.path.energy_kg_m2
    assert row["swivel_rad"] == planned.samples["swivel_rad"][-1]
    for k, joint in enumerate(JOINTS):
        q, dq = planned.samples["exo_q_rad"][:, k], planned.samples["exo_dq_rad_per_s"][:, k]
        assert row[f"exo_{joint}_least_rad"] == q.min()
        assert row[f"exo_{joint}_most_rad"] == q.max()
        assert row[f"exo_{joint}_peak_rad_per_s"] == np.abs(dq).max()


def test_similar_persons_with_similar_targets_move_alike(rows_of):
    """Lengths, and with them targets, all grow with stature: same angles, energy as its square (mass is not varied)."""
    rows = rows_of(
        groups={"sizes": {"subject.stature_m": {"values": [1.5, 1.75, 2.0]}}},
        tasks={"one": {"target_m": [0.2, 0.42, 0.25]}},
        targets_for_stature_m=1.75,
        exoskeletons=["generic_75_75"],
    )
    assert [row["status"] for row in rows] == ["ok"] * 3
    for row in rows:
        size = row["subject.stature_m"] / 1.75
        # Rounding of the scaled lengths (1e-16) times the condition of the choice, as for a task that is moved.
        assert row["energy_kg_m2"] == pytest.approx(size**2 * rows[1]["energy_kg_m2"], rel=1e-8)
        assert row["misalignment_m"] == pytest.approx(size * rows[1]["misalignment_m"], rel=1e-6)
        for joint in JOINTS:
            assert row[f"exo_{joint}_most_rad"] == pytest.approx(rows[1][f"exo_{joint}_most_rad"], abs=1e-7)


def test_values_in_turn_are_combined(rows_of):
    rows = rows_of(
        groups={"both": {"subject.sex": {"values": ["male", "female"]}, "rhythm.gain": {"values": [0.5, 1.0]}}},
        tasks={"one": {"target_m": [0.2, 0.35, 0.15]}},
    )
    found = {(row["subject.sex"], row["rhythm.gain"]) for row in rows}
    assert found == {(sex, gain) for sex in ("male", "female") for gain in (0.5, 1.0)}
    assert len(rows) == 4  # nothing is drawn: once is enough
    assert len({row["energy_kg_m2"] for row in rows}) == 4


def test_refusals_are_results_and_are_counted(run, study_file, tmp_path):
    narrow = tmp_path / "narrow.yaml"
    narrow.write_text(
        "name: narrow\nshoulder: {a12_deg: 90, a23_deg: 90}\njoints: {shoulder_2: {range_deg: [0, 40]}}\n",
        encoding="utf-8",
    )
    tasks = {"near": {"target_m": [0.2, 0.42, 0.25]}, "far": {"target_m": [2.0, 0.0, 0.0]}}
    file = study_file({"tasks": tasks, "exoskeletons": [str(narrow), "generic_75_75"]})
    done = run("sweep", file, "--out", tmp_path / "out", "--json")
    assert done.code == 0
    assert done.json == json.loads((tmp_path / "out/summary.json").read_text(encoding="utf-8"))
    refused, good = done.json["devices"][str(narrow)], done.json["devices"]["generic_75_75"]
    assert refused["status"] == {"ExoInfeasible": 1, "TargetUnreachable": 1}
    assert refused["exo_refusal"] == {"JointLimit": 1}
    assert refused["figures"] == {}
    assert good["status"] == {"TargetUnreachable": 1, "ok": 1}
    for device in (refused, good):
        for section in ("groups", "tasks"):
            assert sum(part["cases"] for part in device[section].values()) == device["cases"] == 2
    with (tmp_path / "out/cases.csv").open(encoding="utf-8") as lines:
        rows = list(csv.DictReader(lines))
    assert [row["status"] for row in rows] == ["ExoInfeasible", "ok", "TargetUnreachable", "TargetUnreachable"]
    assert "Shoulder2" in rows[0]["message"]
    # The arm's own figures do not depend on the device, refused or not.
    assert rows[0]["energy_kg_m2"] == rows[1]["energy_kg_m2"] != ""
    assert rows[0]["exo_elbow_most_rad"] == "" != rows[1]["exo_elbow_most_rad"]


def test_table_names_counts_and_ranges(run, study_file, tmp_path):
    done = run("sweep", study_file(STUDY), "--out", tmp_path / "out")
    assert done.code == 0
    assert "women" in done.out
    assert "100.0 %" in done.out
    assert "swivel" in done.out


def test_shipped_study_is_valid(run):
    jsonschema.validate(yaml.safe_load(EXAMPLE.read_text(encoding="utf-8")), run("info", "--schema", "study").json)
    study = load_study(EXAMPLE)
    assert len(list(cases_of(study))) == 2 * 2 * study.draws * len(study.exoskeletons)


BAD = {
    "truth for a count": (STUDY | {"draws": True}, ["draws", "True", "whole number"]),
    "truth for a bound": (
        STUDY | {"groups": {"a": {"subject.stature_m": {"min": True, "max": 2}}}},
        ["groups.a.subject.stature_m", "min", "True", "finite number"],
    ),
    "device twice": (STUDY | {"exoskeletons": ["generic_75_75", "generic_75_75"]}, ["exoskeletons", "twice"]),
    "unknown key": ({"drews": 3}, ["drews", "3", "unknown key"]),
    "no draws": ({"draws": 0}, ["draws", "0", "1"]),
    "unknown key of a reach": ({"groups": {"g": {"subject.statur_m": 1.7}}}, ["groups.g", "subject.statur_m", "1.7"]),
    "nested section": ({"groups": {"g": {"subject": {"sex": "male"}}}}, ["groups.g.subject", "values", "min"]),
    "section and key": ({"groups": {"g": {"rhythm": "Fixed", "rhythm.gain": 1.0}}}, ["rhythm", "Fixed"]),
    "crossed bounds": ({"groups": {"g": {"rhythm.gain": {"min": 1.0, "max": 0.5}}}}, ["rhythm.gain", "1.0", "0.5"]),
    "no spread": (
        {"groups": {"g": {"subject.stature_m": {"mean": 1.7, "sd": 0.0, "min": 1.5, "max": 1.9}}}},
        ["subject.stature_m", "sd"],
    ),
    "bound out of range": (
        {"groups": {"g": {"subject.stature_m": {"min": 0.2, "max": 1.9}}}},
        ["groups.g", "stature", "0.2", " m", "0.5"],
    ),
    "not a number": ({"tasks": {"t": {"duration_s": {"min": "soon", "max": 2}}}}, ["tasks.t.duration_s", "soon"]),
    "nan": ({"tasks": {"t": {"duration_s": {"min": float("nan"), "max": 2}}}}, ["tasks.t.duration_s", "nan", "finite"]),
    "value nan": ({"tasks": {"t": {"duration_s": float("nan")}}}, ["tasks.t", "duration_s", "nan", "finite"]),
    "no values": ({"tasks": {"t": {"rhythm.gain": {"values": []}}}}, ["tasks.t.rhythm.gain", "1 item"]),
    "both sides": (
        {"groups": {"g": {"rhythm.gain": 1.0}}, "tasks": {"t": {"rhythm.gain": 0.5}}},
        ["rhythm.gain", "groups.g", "tasks.t"],
    ),
    "unknown device": ({"exoskeletons": ["suit"]}, ["suit", "generic_75_75"]),
    "template": ({"exoskeletons": ["harmony_template.yaml"]}, ["harmony_template.yaml", "No such file"]),
    "other reach": ({"reach": {"metric": "taxicab"}}, ["reach", "metric", "taxicab"]),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_study_is_refused_in_words_before_anything_is_written(run, study_file, tmp_path, case):
    data, words = BAD[case]
    done = run("sweep", study_file(data), "--out", tmp_path / "out")
    assert done.code == 2
    for word in words:
        assert word in done.err
    assert not (tmp_path / "out").exists()


def test_results_that_cannot_be_written_are_an_input_error(run, study_file, tmp_path):
    (tmp_path / "out").write_text("a file", encoding="utf-8")
    done = run("sweep", study_file(STUDY), "--out", tmp_path / "out")
    assert done.code == 2
    assert str(tmp_path / "out") in done.err


def test_a_summary_belongs_to_the_rows_beside_it(run, study_file, tmp_path, monkeypatch):
    arguments = ("sweep", study_file(STUDY), "--out", tmp_path, "--jobs", "1")
    assert run(*arguments).code == 0
    monkeypatch.setattr("glenoid.sweep.run.run_case", lambda *_: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        run(*arguments)
    assert not (tmp_path / "summary.json").exists()
