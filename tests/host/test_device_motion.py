"""A device that follows a planned reach: the joints of the core, the laws of T, refusals, tables and pictures."""

import csv
import math
import re

import numpy as np
import pytest
from glenoid import _core
from glenoid.cli.plan import plan_with_device
from glenoid.devices import JOINTS, load_device
from glenoid.exo import core_exo
from glenoid.inputs import ReachInput
from glenoid.reach import plan_reach
from places import ROOT

IDENTITY = "name: arm's own chart\nshoulder:\n  axes: [[0, 0, 1], [1, 0, 0], [0, 0, 1]]\n"
SKEW = (
    "name: skew\nside: {side}\nshoulder:\n  axes: {axes}\nmounts: {{base_rad: {base}, cuff_rad: {cuff}}}\n"
    "girdle: {{order: ElevationFirst}}\n"
)
NAMES = ["generic_60_60", "generic_75_75", "harmony"]


def turns(angles):
    return np.abs((angles + np.pi) % (2 * np.pi) - np.pi)


@pytest.fixture
def device_file(tmp_path):
    def write(text):
        file = tmp_path / "mine.yaml"
        file.write_text(text, encoding="utf-8")
        return file

    return write


def planned_path(name, start_deg=(40, -60, 50, 80), end_deg=(95, -20, 30, 50)):
    """A refined geodesic between two postures, and the device's model on it."""
    reach = ReachInput(start_q_deg=start_deg)
    generator = plan_reach(reach).generator
    arm, planner = generator.arm, _core.ReachPlanner()
    ends = [_core.posture_from_angles(np.deg2rad(q)) for q in (start_deg, end_deg)]
    paths = []
    for first, last in (ends, ends[::-1]):
        status, plan = planner.plan_between(arm, first, last)
        assert status == _core.Status.Ok
        paths.append(_core.refine_path(arm, plan.path, 1e-12)[1])
    model = _core.ExoModel(core_exo(load_device(name), reach.subject), arm.rhythm.position(ends[0].R_TU[:, 2]))
    return arm, ends, paths, model


def joints_along(model, arm, path, posture, values, near=None):
    centre = arm.rhythm.position(posture.R_TU[:, 2])
    status, start = _core.choose_branch(model, posture, centre, near)
    assert status == _core.Status.Ok
    status, check = _core.check_path(model, path, arm.rhythm, start, False)
    assert status == _core.Status.Ok
    return check, _core.map_path(model, path, arm.rhythm, check.guide, values)


def test_identity_device_gives_the_arm_s_angles_back(device_file):
    planned, _ = plan_with_device(ReachInput(), 100.0, str(device_file(IDENTITY)))
    q, joints = planned.samples["q_rad"], planned.samples["exo_q_rad"]
    # One is a chart of the other: rounding, divided by the sine of the least elevation.
    tolerance = 1e-13 / math.sin(q[:, 0].min())
    assert turns(joints[:, 2:5] - q[:, (1, 0, 2)]).max() < tolerance
    assert np.array_equal(joints[:, 5], q[:, 3])
    # Girdle: protraction and elevation of the centre itself.
    assert np.allclose(joints[:, :2], planned.samples["girdle"][:, (1, 0)], rtol=0, atol=1e-14)
    assert planned.samples["exo_residual_m"].max() < 1e-15


@pytest.mark.parametrize("name", NAMES)
def test_plan_gives_the_joints_of_the_core(name, run):
    data = run("plan", "--exo", name, "--json").json
    settings = _core.MotionSettings()
    settings.exo = core_exo(load_device(name), ReachInput().subject)
    generator = _core.MotionGenerator(settings)
    generator.command(0.0, np.array(ReachInput().target_m))
    core = generator.sample(np.array(data["motion"]["time_s"]))
    for key in ("exo_q_rad", "exo_dq_rad_per_s", "exo_ddq_rad_per_s2", "exo_residual_m"):
        assert data["exo"]["motion"][key] == core[key].tolist(), key
    assert data["exo"]["joints"] == list(JOINTS)


@pytest.mark.parametrize("name", NAMES)
def test_joints_put_the_upper_arm_where_the_path_has_it(name):
    arm, ends, paths, model = planned_path(name)
    values = np.linspace(0, 1, 41)
    _, found = joints_along(model, arm, paths[0], ends[0], values)
    for value, joints in zip(values, found["q_rad"], strict=True):
        assert np.abs(_core.exo_upper_arm(model, joints) - paths[0].posture(value).R_TU).max() < 1e-12


@pytest.mark.parametrize("name", NAMES)
def test_rates_are_the_derivatives_of_the_joints(name):
    arm, ends, paths, model = planned_path(name)
    h = np.finfo(float).eps ** (1 / 3)
    values = np.linspace(0.1, 0.9, 17)
    _, at = joints_along(model, arm, paths[0], ends[0], values)
    _, before = joints_along(model, arm, paths[0], ends[0], values - h)
    _, after = joints_along(model, arm, paths[0], ends[0], values + h)
    _, wide = joints_along(model, arm, paths[0], ends[0], np.linspace(0, 1, 401))
    # Central difference: h^2 |q'''| / 6 + noise / h, the noise of the joints 1e-13 (the law above) over the sine to singular.
    third = np.abs(np.diff(wide["ddq_rad"], axis=0)).max() * 400
    fourth = np.abs(np.diff(wide["ddq_rad"], 2, axis=0)).max() * 400**2
    noise = 1e-13 / math.sin(wide["singularity_rad"].min()) / h
    difference = (after["q_rad"] - before["q_rad"]) / (2 * h)
    assert np.abs(difference - at["dq_rad"]).max() < h**2 * third + noise
    difference = (after["dq_rad"] - before["dq_rad"]) / (2 * h)
    assert np.abs(difference - at["ddq_rad"]).max() < h**2 * fourth + 100 * noise


@pytest.mark.parametrize("name", NAMES)
def test_reversing_a_path_reverses_the_joints(name):
    arm, ends, (there, back), model = planned_path(name)
    values = np.linspace(0, 1, 33)
    check, forth = joints_along(model, arm, there, ends[0], values)
    last = forth["q_rad"][-1, 2:5]
    again, home = joints_along(model, arm, back, ends[1], 1 - values, last)
    assert again.guide.branch == check.guide.branch
    # Two solutions of one boundary-value problem, each to 1e-12 in its tail; the joints magnify by the sine to singular.
    tolerance = 1e-8 / math.sin(forth["singularity_rad"].min())
    assert np.abs(forth["q_rad"] - home["q_rad"]).max() < tolerance
    assert np.abs(forth["dq_rad"] + home["dq_rad"]).max() < 100 * tolerance


def turn(axis, angle):
    """Rotation about a coordinate axis."""
    k = "xyz".index(axis)
    out, i, j = np.eye(3), (k + 1) % 3, (k + 2) % 3
    out[i, i] = out[j, j] = np.cos(angle)
    out[j, i], out[i, j] = np.sin(angle), -np.sin(angle)
    return out


def skew_text(side, axes, base, cuff):
    return SKEW.format(side=side, axes=axes.tolist(), base=base.tolist(), cuff=cuff.tolist())


def test_left_arm_in_the_left_device_moves_as_the_right_arm_in_its_twin(device_file):
    axes = np.array([[0.0, 0.6, 0.8], [1.0, 0.0, 0.0], [0.0, -0.28, 0.96]])
    base, cuff, mirror = np.array([0.3, -0.2, 0.1]), np.array([0.1, 0.2, -0.3]), np.array([1.0, -1.0, -1.0])
    right, _ = plan_with_device(ReachInput(), 50.0, str(device_file(skew_text("right", axes, base, cuff))))
    given = ReachInput.model_validate({"subject": {"arm": "left"}, "target_m": (-0.20, 0.42, 0.25)})
    text = skew_text("left", axes * mirror, base * mirror, cuff * mirror)
    left, _ = plan_with_device(given, 50.0, str(device_file(text)))
    assert right.ok
    assert left.ok
    for key in ("exo_q_rad", "exo_dq_rad_per_s", "exo_residual_m", "misalignment_m"):
        assert np.array_equal(left.samples[key], right.samples[key]), key


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("shoulder: {a12_deg: 45, a23_deg: 45}", r"reach"),
        ("shoulder: {a12_deg: 90, a23_deg: 90, min_singularity_deg: 60}", r"singular"),
        ("shoulder: {a12_deg: 90, a23_deg: 90}\njoints: {shoulder_2: {range_deg: [0, 60]}}", r"Shoulder2"),
    ],
    ids=["reach", "singular", "range"],
)
def test_infeasible_device_is_a_verdict_with_where_and_by_how_much(text, words, device_file, run):
    file = device_file(f"name: mine\n{text}\n")
    for command in ("plan", "simulate"):
        done = run(command, "--exo", file)
        assert done.code == 1
        said = " ".join((done.out + done.err).split())
        assert "REFUSED" in said
        assert re.search(words, said), said
        assert re.search(r"\d+\.\d+ deg at \d+ %", said), said
    data = run("plan", "--exo", file, "--json").json
    assert data["status"] == "ExoInfeasible"
    assert "motion" not in data


@pytest.mark.parametrize(
    ("drives", "law"), [("Full", "zero"), ("NoDrives", "misalignment"), ("VerticalOnly", "horizontal")]
)
def test_residual_of_missing_drives_in_metres(drives, law, device_file):
    planned, motion = plan_with_device(
        ReachInput(), 50.0, str(device_file(IDENTITY + f"girdle: {{drives: {drives}}}\n"))
    )
    moved = planned.samples["shoulder_m"] - planned.samples["shoulder_m"][0]
    expected = {
        "zero": np.zeros(len(moved)),
        "misalignment": planned.samples["misalignment_m"],
        "horizontal": np.linalg.norm(moved[:, :2], axis=1),
    }[law]
    assert np.allclose(planned.samples["exo_residual_m"], expected, rtol=0, atol=1e-12)
    assert motion.summary(planned.samples)["largest_misalignment_mm"] > 10.0


def test_tables_and_pictures_of_both_spaces(run, tmp_path):
    table, picture = tmp_path / "r.csv", tmp_path / "r.png"
    done = run("plan", "--exo", "generic_75_75", "--csv", table, "--plot", picture)
    assert done.code == 0
    assert "misalignment" in done.out
    with table.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    columns = set(rows[0])
    assert {f"exo_{name}_rad" for name in JOINTS} | {"theta_rad", "exo_residual_m", "exo_margin_rad"} <= columns
    assert float(rows[-1]["exo_elbow_rad"]) == float(rows[-1]["phi_rad"])
    for file in (picture, tmp_path / "r_exo.png"):
        assert file.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("fmi", ["2", "3"])
@pytest.mark.parametrize("name", NAMES)
def test_fmu_gives_the_joints_of_the_plan(name, fmi, run, tmp_path):
    table, picture = tmp_path / "s.csv", tmp_path / "s.png"
    done = run("simulate", "--exo", name, "--fmi", fmi, "--csv", table, "--plot", picture, "--stop-s", 1.5, "--json")
    assert done.code == 0
    assert done.json["largest_difference_from_core_rad"] == 0.0
    motion = run("plan", "--exo", name, "--json").json["exo"]["motion"]  # both every 10 ms
    for key in ("exo_q_rad", "exo_dq_rad_per_s", "exo_residual_m"):
        assert len(done.json[key]) == len(motion[key])
        # The two may form the time of a sample differently by a rounding: rates below 10 rad/s, 200 rad/s^2.
        assert np.abs(np.array(done.json[key]) - motion[key]).max() <= 200 * 4e-16
    header = table.read_text(encoding="utf-8").splitlines()[0]
    assert "exo_shoulder_1_rad" in header
    assert "exo_residual_m" in header
    assert (tmp_path / "s_exo.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    "text",
    [
        "girdle: {drives: VerticalOnly, link_m: 0.18}",
        "girdle: {drives: NoDrives}",
        "girdle: {drives: NoLength, order: ElevationFirst, base_follows: true, link_m: 0.15}",
        "joints: {shoulder_2: {range_deg: [-170, 0]}}",
    ],
)
def test_every_figure_of_a_device_reaches_the_fmu(text, run, device_file):
    plain = run("simulate", "--exo", device_file(IDENTITY), "--json").json
    done = run("simulate", "--exo", device_file(IDENTITY + text + "\n"), "--json")
    assert done.code == 0
    assert done.json["largest_difference_from_core_rad"] == 0.0
    assert any(done.json[key] != plain[key] for key in ("exo_q_rad", "exo_residual_m"))


def test_a_device_for_the_other_arm_is_refused_before_the_run(run, device_file):
    done = run("simulate", "--exo", device_file(IDENTITY + "side: left\n"))
    assert done.code == 2
    assert "side = left" in done.err


def test_base_carried_by_the_girdle_turns_the_shoulder_joints_back(run, device_file):
    file = device_file(IDENTITY + "girdle: {base_follows: true}\n")
    carried = run("plan", "--exo", file, "--json").json["exo"]["motion"]
    level = run("plan", "--exo", device_file(IDENTITY), "--json").json["exo"]["motion"]
    # Same girdle, other shoulder joints: R = Rz(q_pr) Ry(-q_ed) Rz(q_1) Rx(q_2) Rz(q_3) in both.
    assert carried["exo_residual_m"] == level["exo_residual_m"]
    for q, other in zip(carried["exo_q_rad"], level["exo_q_rad"], strict=True):
        assert q[:2] == other[:2]
        girdle = turn("z", q[0]) @ turn("y", -q[1])
        ours, plain = (turn("z", a[2]) @ turn("x", a[3]) @ turn("z", a[4]) for a in (q, other))
        assert np.abs(girdle @ ours - plain).max() < 1e-12


def test_plan_says_which_figures_of_a_subject_are_scaled(run):
    text = run("plan", "--target-m=-0.15,0.40,0.05", "--subject", ROOT / "host/subjects/own_measurements.yaml").out
    assert "SCALED" in text
    data = run("plan", "--json").json
    assert all(entry["source"] for entry in data["subject"]["scaling"])
