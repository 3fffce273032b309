"""The arm as load of the drives: what the motors feel of it, and the file that carries it to glenoid-drives."""

import subprocess

import numpy as np
import pytest
import yaml
from glenoid import _core
from glenoid.inputs import InputError
from glenoid.programs import program
from glenoid.rehearse.load import load_yaml, parts
from glenoid.rehearse.motion import run_source
from glenoid.rehearse.run import rehearse
from glenoid.rehearse.virtual import run_virtual

G = 9.80665  # m/s^2


def carrying(mass_kg):
    """The good rehearsal with a person so heavy as load; None: without."""

    def change(data):
        data["drives"] = {"load": "none" if mass_kg is None else "arm"}
        data["subject"] = {"stature_m": 1.75, "mass_kg": mass_kg or 75.0}

    return change


@pytest.fixture(scope="module")
def motion_of():
    """The source's motion of a scenario."""
    return lambda scenario: run_source(scenario, 1e-9 * scenario.config.setpoint_period_ns)


def run(scenario_of, motion_of, mass_kg):
    scenario = scenario_of("reach_high", carrying(mass_kg))
    motion = motion_of(scenario)
    return scenario, motion, run_virtual(scenario, motion)


def test_following_error_and_torque_grow_with_the_arm(scenario_of, motion_of):
    errors, torques = [], []
    for mass_kg in (None, 75.0, 150.0, 300.0):
        _, _, record = run(scenario_of, motion_of, mass_kg)
        moving = np.abs(record.truth["velocity_rad_per_s"]).max(axis=1) > 0.1
        error = record.truth["command_rad"][:-1] - record.truth["position_rad"][1:]
        errors.append(float(np.sqrt((error[moving[1:]] ** 2).sum(axis=1).mean())))
        torques.append(float(np.sqrt((record.truth["torque_Nm"][moving] ** 2).sum(axis=1).mean())))
    assert errors == sorted(errors)
    assert errors[-1] > 1.2 * errors[0]
    assert torques == sorted(torques)
    assert torques[-1] > 3.0 * torques[0]


def test_at_rest_the_elbow_carries_the_weight_of_the_forearm(scenario_of, motion_of):
    """By the lever of its centre of mass: elementary statics, not the model's equations."""
    scenario, motion, record = run(scenario_of, motion_of, 150.0)
    arm, _, _ = parts(scenario, motion)
    at_ns = record.origin_ns + round(1e9 * motion.period_s * (motion.rows - 20))
    row = int(np.searchsorted(record.truth["time_ns"], at_ns))
    assert np.abs(record.truth["velocity_rad_per_s"][row]).max() < 1e-3
    q = motion.samples["q_rad"][-1]
    posture = _core.posture_from_angles(q)
    axis, c, s = posture.R_TU[:, 0], np.cos(q[3]), np.sin(q[3])
    along = -posture.R_TU @ np.array([0.0, -s, c])  # forearm, from the elbow to the wrist
    weight = np.array([0.0, 0.0, -G * arm.forearm.mass_kg])
    held = -axis @ np.cross(arm.forearm.com_m * along, weight)
    friction = 1.0  # Nm, Coulomb, of the nominal profile
    torque = record.truth["torque_Nm"][row][5]
    assert abs(held) > 2.0 * friction
    assert abs(torque - held) <= friction


def test_loaded_rehearsal_leaves_the_file_that_the_program_reads(scenario_of, tmp_path):
    done = rehearse(scenario_of("reach_high_loaded"), tmp_path)
    assert done.verdict == "PASS"
    assert yaml.safe_load((tmp_path / "load.yaml").read_text())["upper_arm"]["mass_kg"] > 1.0
    rehearse(scenario_of("reach_high"), tmp_path)
    assert not (tmp_path / "load.yaml").exists()


def drives(*arguments):
    try:
        command = [program("glenoid-drives"), *arguments]
    except InputError as error:
        pytest.skip(str(error))
    return subprocess.run(command, capture_output=True, text=True, check=False)


BAD = {
    "unknown key": (lambda d: d.update(armor=1), "load.yaml: unknown key armor"),
    "mass": (lambda d: d["forearm"].update(mass_kg=0), "load.yaml.forearm: mass_kg = 0.000000: must be above 0"),
    "word": (lambda d: d["exoskeleton"].update(girdle_order="Both"), "girdle_order = Both: must be one of Protraction"),
    "axis": (lambda d: d["exoskeleton"].update(axis_2=[1, "x", 0]), "axis_2[1] = x: must be a finite number"),
    "length of axis": (lambda d: d["exoskeleton"].update(axis_2=[1, 1, 0]), "must be 1 within 1e-6"),
    "list": (lambda d: d["upper_arm"].update(inertia_kg_m2=[0.01]), "inertia_kg_m2: must be a list of 3 numbers"),
    "inertia": (
        lambda d: d["upper_arm"].update(inertia_kg_m2=[9.0, 0.1, 0.1]),
        "upper arm: length, mass and principal",
    ),
    "girdle": (lambda d: d.update(girdle_length_m=170), "girdle_length_m = 170.000000 m: must be above 0 and below 1"),
    "joints": (lambda d: d["joints"].pop(), "joints: must be a list of 6"),
    "node": (lambda d: d["joints"][2].update(node=200), "joints[2]: node = 200: must be 1 to 127"),
    "sign": (lambda d: d["joints"][2].update(sign=0.5), "joints[2]: sign = 0.500000: must be 1 or -1"),
    "other nodes": (lambda d: d["joints"][2].update(node=9), "its joints are the nodes 1,2,9,4,5,6, in this order"),
}


@pytest.mark.parametrize("what", sorted(BAD))
def test_bad_load_file_is_refused_with_file_key_value_and_rule(scenario_of, motion_of, tmp_path, what):
    scenario = scenario_of("reach_high_loaded")
    change, words = BAD[what]
    data = yaml.safe_load(load_yaml(scenario, motion_of(scenario)))
    change(data)
    (tmp_path / "load.yaml").write_text(yaml.safe_dump(data))
    done = drives("--load", tmp_path / "load.yaml", "--bus", "udp:239.74.163.91:43191", "--duration-s", "0.05")
    assert done.returncode == 2
    assert words in done.stderr


def test_program_carries_the_load(scenario_of, motion_of, tmp_path):
    scenario = scenario_of("reach_high_loaded")
    (tmp_path / "load.yaml").write_text(load_yaml(scenario, motion_of(scenario)))
    report = tmp_path / "drives.json"
    place = ("--bus", "udp:239.74.163.91:43192", "--report", report)
    done = drives("--load", tmp_path / "load.yaml", "--duration-s", "0.2", *place)
    if "no such device" in done.stderr.lower() or "unreachable" in done.stderr.lower():
        pytest.skip(done.stderr)
    assert done.returncode == 0, done.stderr
    assert len(yaml.safe_load(report.read_text())["drives"]) == 6


def test_slide_of_a_girdle_is_refused(scenario_of, motion_of, tmp_path):
    device = yaml.safe_load((scenario_of("reach_high").path.parents[1] / "exoskeletons/generic_75_75.yaml").read_text())
    device["girdle"]["drives"] = "VerticalOnly"
    (tmp_path / "slide.yaml").write_text(yaml.safe_dump(device))
    scenario = scenario_of("reach_high_loaded", lambda data: data.update(exoskeleton=str(tmp_path / "slide.yaml")))
    with pytest.raises(InputError, match=r"drives\.load = 'arm': load: girdle drives VerticalOnly are a slide"):
        run_virtual(scenario, motion_of(scenario))
