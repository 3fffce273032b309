"""The FMUs through FMPy: the same numbers as the core."""

import tempfile

import numpy as np
import pytest
from glenoid.fmus import fmu_path
from glenoid.inputs import InputError, ReachInput, load_reach
from glenoid.simulate import difference_from_core, output_names, simulate, start_values
from places import EXAMPLE


@pytest.mark.parametrize("fmi", ["2", "3"])
def test_fmu_gives_the_numbers_of_the_core(fmi, plain_reach):
    done = simulate(plain_reach, fmu_path(fmi), 0.01, 1.7)
    assert done.status == "Arrived"
    assert difference_from_core(plain_reach, done) == 0.0


def test_both_versions_are_equal_bit_for_bit(plain_reach):
    two, three = (simulate(plain_reach, fmu_path(fmi), 0.01, 1.7) for fmi in ("2", "3"))
    for name, values in two.samples.items():
        assert np.array_equal(values, three.samples[name]), name


def test_measured_shoulder_is_served_by_moving_the_reach():
    reach = load_reach(EXAMPLE)
    done = simulate(reach, fmu_path("3"), 0.01, reach.duration_s)
    assert np.allclose(done.samples["shoulder_m"][0], reach.start_shoulder_m, rtol=0, atol=1e-12)
    assert np.allclose(done.samples["wrist_m"][-1], reach.target_m, rtol=0, atol=1e-8)


@pytest.mark.parametrize(
    "change",
    [
        {"subject": {"sex": "female", "stature_m": 1.6, "mass_kg": 60.0}},
        {"subject": {"upper_arm_length_m": 0.3, "forearm_length_m": 0.25, "shoulder_distance_m": 0.15}},
        {"subject": {"arm": "left"}, "target_m": (-0.20, 0.42, 0.25)},
        {"rhythm": {"model": "Fixed"}},
        {"rhythm": {"model": "Measured"}},
        {"rhythm": {"gain": 0.35, "smoothing_rad": 0.2}},
        {"metric": "fixedShoulder"},
        {"swivel": {"mode": "Prescribed", "prescribed_rad": 0.5}},
        {"swivel": {"mode": "HumanPrior"}},
        {"axial_factor": 2.0},
        {"timing": "MinimumJerkHand"},
        {"timing": "MinimumJerkHoming"},
        {"duration_s": 0.8},
        {"start_q_deg": (40, -60, 50, 90)},
        {"subject": {"limits_deg": {"elevation": [0, 80]}}},
    ],
    ids=str,
)
def test_every_setting_reaches_the_fmu(change):
    reach = ReachInput.model_validate({"target_m": (0.20, 0.42, 0.25)} | change)
    done = simulate(reach, fmu_path("3"), 0.02, 1.0)
    plain = simulate(ReachInput(), fmu_path("3"), 0.02, 1.0)
    assert difference_from_core(reach, done) == 0.0
    changed = any(not np.array_equal(done.samples[name], plain.samples[name]) for name in done.samples)
    assert changed or change == {"subject": {"limits_deg": {"elevation": [0, 80]}}}


def test_outputs_are_those_of_the_description():
    text = fmu_path("3").parents[2] / "modelDescription.xml"
    names = text.read_text(encoding="utf-8") if text.is_file() else ""
    assert not names or all(f'name="{name}"' in names for name in output_names())


@pytest.mark.parametrize(
    "change",
    [
        {"subject": {"forearm_mass_kg": 1.6}},
        {"rhythm": {"measured": {"slope_m": [0.01] * 9, "shoulder_distance_m": 0.17}}},
        {"swivel": {"prior": {"height_rad": 0.1, "lateral_rad": 0.1, "regression": 0.5, "common_rad": 0.1}}},
    ],
    ids=["mass", "rhythm", "prior"],
)
def test_settings_that_the_fmu_lacks_are_refused(change):
    with pytest.raises(InputError, match="glenoid plan"):
        start_values(ReachInput.model_validate(change), np.zeros(3))


def test_command_writes_and_compares(run, tmp_path):
    file, picture = tmp_path / "s.csv", tmp_path / "s.png"
    done = run("simulate", EXAMPLE, "--fmi", "2", "--csv", file, "--plot", picture, "--json")
    assert done.code == 0
    data = done.json
    assert data["fmi_version"] == "2.0"
    assert data["status"] == "Arrived"
    assert len(data["q_rad"]) == len(data["time_s"]) == len(file.read_text().splitlines()) - 1
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("options", [("--timing", "MinimumJerkHoming"), ("--axial-factor", "2"), ("--gain", "0.5")])
def test_options_that_plan_has_reach_the_fmu_too(run, options):
    plain, changed = (run("simulate", *more, "--json").json for more in ((), options))
    assert changed["largest_difference_from_core_rad"] == 0.0
    assert changed["q_rad"] != plain["q_rad"]


def test_refused_target_is_a_negative_verdict(run):
    done = run("simulate", "--target-m", "2,2,2", "--json")
    assert done.code == 1
    assert done.json["status"] == "TargetUnreachable"


def test_what_the_fmu_refuses_is_an_input_error_with_its_words(run):
    done = run("simulate", "--gain", "2")
    assert done.code == 2
    assert "rhythm.gain" in done.err


def test_missing_fmu_says_how_to_get_it(run, monkeypatch, tmp_path):
    monkeypatch.setenv("GLENOID_FMU_DIR", str(tmp_path))
    done = run("simulate")
    assert done.code == 2
    assert "make build" in done.err


@pytest.mark.parametrize("options", [(), ("--swivel-prescribed-rad", "6")], ids=["done", "refused by the FMU"])
def test_nothing_is_left_in_the_temporary_folder(run, tmp_path, monkeypatch, options):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    assert run("simulate", "--stop-s", "0.02", *options).code == (2 if options else 0)
    assert not list(tmp_path.iterdir())
