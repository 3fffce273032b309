"""`glenoid plan` for a single reach."""

import csv
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from glenoid.reach import Verification, plan_reach, rotation_between, verify
from glenoid.tables import motion_columns, write_csv
from places import EXAMPLE, ROOT

OK = ("plan", "--start-q-deg", "15,-30,30,60", "--target-m", "0.20,0.42,0.25")


def test_json_holds_motion_certificate_and_family(run):
    done = run(*OK, "--json")
    assert done.code == 0
    data = done.json
    assert data["status"] == "ok"
    motion = {name: np.array(values) for name, values in data["motion"].items()}
    assert motion["q_rad"].shape == (len(motion["time_s"]), 4)
    # The planner promises the wrist at the target to the certificate's own figure.
    assert np.linalg.norm(motion["wrist_m"][-1] - [0.20, 0.42, 0.25]) <= data["certificate"]["hand_error_m"] + 1e-12
    assert motion["progress"][0] == 0.0
    assert motion["progress"][-1] == 1.0
    assert {"hessian_positive", "limits", "long_way", "transversality"} <= data["certificate"].keys()
    assert len(data["family"]["swivel_rad"]) == len(data["family"]["energy_kg_m2"]) > 10


def test_motion_starts_and_ends_at_rest(plain_reach):
    samples = plan_reach(plain_reach).samples
    for name in ("dq_rad_per_s", "ddq_rad_per_s2"):
        peak = np.abs(samples[name]).max()
        assert np.abs(samples[name][[0, -1]]).max() <= 1e-9 * peak


def test_chosen_posture_has_the_least_energy_of_the_feasible_family(plain_reach):
    reach = plan_reach(plain_reach)
    feasible = (reach.family["margin_rad"] >= 0) & np.isfinite(reach.family["energy_kg_m2"])
    assert feasible.any()
    # The family's energies are those of a coarse grid, which overestimates: the optimum may not lie above any of them.
    assert reach.generator.path.energy_kg_m2 <= reach.family["energy_kg_m2"][feasible].min() * (1 + 1e-6)


def test_verification_arrives(run):
    done = run(*OK, "--verify", "--json")
    assert done.code == 0
    assert done.json["verification"]["passed"]


def test_verification_notices_a_wrong_path(plain_reach, monkeypatch):
    reach = plan_reach(plain_reach)
    assert verify(reach).passed
    from glenoid import reach as module

    real = module._core.follow_geodesic
    monkeypatch.setattr(
        module._core, "follow_geodesic", lambda arm, start, rates, *rest: real(arm, start, bent(rates), *rest)
    )
    assert not verify(reach).passed


@pytest.mark.parametrize(("arrival", "deviation", "passed"), [(0, 0, True), (1e-6, 0, False), (0, 1e-4, False)])
def test_verification_asks_for_both_arrival_and_way(arrival, deviation, passed):
    assert Verification(arrival, deviation, 0.0).passed == passed


def test_rates_in_the_csv_are_the_derivatives_of_the_angles_beside_them(plain_reach):
    reach = plan_reach(plain_reach, rate_hz=1000.0)
    columns = motion_columns(reach.time_s, reach.samples)
    for name in ("theta", "eta", "zeta", "phi"):
        for value, rate in ((f"{name}_rad", f"d{name}_rad_per_s"), (f"d{name}_rad_per_s", f"dd{name}_rad_per_s2")):
            slope = np.gradient(columns[value], columns["time_s"])[1:-1]
            # Central differences over h = 1 ms: h^2 / 6 times the third derivative, below 1e3 of the largest rate here.
            assert np.abs(slope - columns[rate][1:-1]).max() <= 1e-6 * 1e3 * np.abs(columns[rate]).max(), rate


def bent(rates):
    rates.phi = rates.phi * 1.00001
    return rates


def test_rotation_between_is_the_angle():
    angle = 1e-9
    turned = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    assert rotation_between(np.eye(3), turned) == pytest.approx(angle, rel=1e-6)


def test_csv_has_units_and_every_bit(run, tmp_path, plain_reach):
    file = tmp_path / "reach.csv"
    assert run(*OK, "--csv", file).code == 0
    with file.open(encoding="utf-8") as lines:
        rows = list(csv.reader(lines))
    assert all(name.endswith(("_s", "_rad", "_rad_per_s", "_rad_per_s2", "_m", "progress")) for name in rows[0])
    reach = plan_reach(plain_reach)
    expected = np.column_stack(list(motion_columns(reach.time_s, reach.samples).values()))
    assert np.array_equal(np.array(rows[1:], dtype=float), expected)


def test_csv_of_nowhere_is_an_input_error(run, tmp_path):
    done = run(*OK, "--csv", tmp_path / "no" / "where.csv")
    assert done.code == 2
    assert "where.csv" in done.err


def test_unreachable_target_is_a_negative_verdict_with_the_distance(run):
    done = run("plan", "--target-m", "2,2,2", "--json")
    assert done.code == 1
    assert done.json["status"] == "TargetUnreachable"
    assert done.json["reach_margin_m"] < 0
    assert "motion" not in done.json
    assert "REFUSED" in run("plan", "--target-m", "2,2,2").out


def test_infeasible_limits_are_a_negative_verdict_with_the_angle(run):
    arguments = (*OK, "--limits-deg", "elbow_flexion=10,12", "--start-q-deg", "15,-30,30,11")
    done = run(*arguments, "--json")
    assert done.code == 1
    assert done.json["status"] == "LimitsInfeasible"
    assert "elbow flexion" in done.json["message"]
    assert done.json["best_margin_rad"] < 0


def test_options_go_over_the_file(run):
    data = run("plan", EXAMPLE, "--rhythm", "Fixed", "--json").json
    shoulder = np.array(data["motion"]["shoulder_m"])
    assert np.ptp(shoulder, axis=0).max() <= 1e-12
    assert np.ptp(np.array(run("plan", EXAMPLE, "--json").json["motion"]["shoulder_m"]), axis=0).max() > 1e-3


def test_subject_file_changes_the_arm(run):
    person = ROOT / "host/subjects/p50_female.yaml"
    mine, other = (
        run("plan", *more, "--target-m", "0.15,0.40,0.05", "--json").json for more in ((), ("--subject", person))
    )
    assert mine["energy_kg_m2"] != other["energy_kg_m2"]


def test_prescribed_swivel_is_kept(run):
    data = run(*OK, "--swivel", "Prescribed", "--swivel-prescribed-rad", "0.5", "--json").json
    assert data["swivel_rad"] == pytest.approx(0.5, abs=1e-9)


def test_leaving_the_limits_on_the_way_is_said_loudly(run):
    # From inward to behind: the axial rotation passes its limit in between, though both ends respect it.
    arguments = ("plan", "--start-q-deg", "81,26,41,99", "--target-m=-0.07,0.18,-0.33")
    data = run(*arguments, "--json").json
    q = np.rad2deg(data["motion"]["q_rad"])
    beyond = (q[:, 1] + q[:, 2] - 80.0).max()
    assert beyond > 1.0
    assert data["certificate"]["limits"]["violated"]
    assert np.rad2deg(-data["certificate"]["limits"]["worst_margin_rad"]) == pytest.approx(beyond, abs=0.1)
    assert any("axial rotation" in line and "OUTSIDE" in line for line in data["warnings"])
    plain = run(*arguments).out
    assert "WARNING" in plain
    assert "OUTSIDE" in plain


def test_console_script_and_module_are_the_same_program():
    script = Path(sys.executable).parent / "glenoid"
    outputs = [
        subprocess.run(command, check=True, capture_output=True, text=True).stdout
        for command in ([script, "info", "--json"], [sys.executable, "-m", "glenoid", "info", "--json"])
    ]
    assert outputs[0] == outputs[1]


@pytest.mark.parametrize(
    "command", ["plan", "simulate", "sweep", "validate", "rehearse", "replay", "source", "info", "demo"]
)
def test_every_command_has_help(run, command):
    done = run(command, "--help")
    assert done.code == 0
    assert "Example" in done.out or command == "info"


def test_write_csv_keeps_column_order(tmp_path):
    file = tmp_path / "t.csv"
    write_csv({"b_m": np.array([1.0, 2.0]), "a_m": np.array([3.0, 4.0])}, file)
    assert file.read_text(encoding="utf-8").split() == ["b_m,a_m", "1.0,3.0", "2.0,4.0"]
