"""`glenoid plan --batch`: the contract for programs."""

import json
from pathlib import Path

import numpy as np
import pytest
from glenoid import _core
from glenoid.batch import run_batch
from glenoid.devices import load_device, parse_device
from glenoid.exo import core_exo
from glenoid.inputs import ReachInput
from glenoid.reach import plan_reach
from hypothesis import given
from hypothesis import strategies as st
from places import EXAMPLE

Q0 = [0.26, -0.52, 0.52, 1.05]
TARGET = [0.20, 0.36, 0.15]
GOOD = {"id": "good", "q0": Q0, "target": TARGET}
KEYS = {"id", "status", "q", "shoulder", "elbow", "wrist", "swivel", "energy", "iterations", "solve_us", "pulled_m"}


def solve(*tasks, **common):
    return run_batch(list(tasks), ReachInput(**common))


def test_answers_have_the_shapes_of_the_contract(run, tmp_path):
    file = tmp_path / "tasks.json"
    file.write_text(json.dumps([GOOD, GOOD | {"id": 7}]), encoding="utf-8")
    done = run("plan", "--batch", file, "--json")
    assert done.code == 0
    assert [answer["id"] for answer in done.json] == ["good", 7]
    for answer in done.json:
        assert answer.keys() == KEYS
        assert answer["status"] == "ok"
        assert np.array(answer["q"]).shape == (101, 4)
        for point in ("shoulder", "elbow", "wrist"):
            assert np.array(answer[point]).shape == (101, 3)
        assert answer["solve_us"] > 0


def test_the_shipped_list_is_answered_as_its_names_say(run):
    done = run("plan", "--batch", EXAMPLE.with_name("batch.json"), "--json")
    assert {a["id"]: a["status"] for a in done.json} == {"to the head": "ok", "out of reach": "TargetUnreachable"}


def test_motion_leads_from_the_start_to_the_target():
    (answer,) = solve(GOOD)
    assert np.allclose(answer["q"][0], Q0, rtol=0, atol=1e-12)
    assert np.allclose(answer["wrist"][-1], TARGET, rtol=0, atol=1e-9)


def test_given_end_posture_is_reached_without_a_choice():
    q1 = [1.2, 0.1, 0.2, 1.0]
    (answer,) = solve(GOOD | {"q1": q1})
    assert np.allclose(answer["q"][-1], q1, rtol=0, atol=1e-9)


def test_lengths_of_the_task_are_those_of_the_arm():
    subject = {"upper_arm_length_m": 0.31, "forearm_length_m": 0.24, "shoulder_distance_m": 0.16}
    (answer,) = solve(GOOD | {"subject": subject})
    shoulder, elbow, wrist = (np.array(answer[name]) for name in ("shoulder", "elbow", "wrist"))
    assert np.allclose(np.linalg.norm(elbow - shoulder, axis=1), 0.31, atol=1e-12)
    assert np.allclose(np.linalg.norm(wrist - elbow, axis=1), 0.24, atol=1e-12)


def test_measured_shoulder_anchors_the_rhythm():
    start = [0.15, -0.06, 0.01]
    (answer,) = solve(GOOD | {"subject": {"shoulder_start_m": start}})
    (plain,) = solve(GOOD)
    assert np.allclose(answer["shoulder"][0], start, atol=1e-12)
    moved = np.array(answer["shoulder"]) - start
    assert np.linalg.norm(moved[-1]) > 1e-2
    assert np.linalg.norm(np.array(plain["shoulder"])[0] - start) > 1e-2


@given(st.lists(st.floats(-0.3, 0.3), min_size=3, max_size=3))
def test_moving_the_whole_task_moves_the_motion(shift):
    start = np.array([0.15, -0.06, 0.01])
    first, second = solve(
        GOOD | {"subject": {"shoulder_start_m": start.tolist()}},
        GOOD
        | {"subject": {"shoulder_start_m": (start + shift).tolist()}, "target": (np.array(TARGET) + shift).tolist()},
    )
    # The target enters through differences of sums with the shift: rounding 1e-16, times the condition of the choice.
    assert np.allclose(first["q"], second["q"], rtol=0, atol=1e-8)
    assert np.allclose(np.array(first["wrist"]) + shift, second["wrist"], rtol=0, atol=1e-8)


def test_measured_shoulder_path_carries_the_arm():
    path = [[0.15, -0.06, 0.01], [0.15, -0.05, 0.03], [0.14, -0.04, 0.06]]
    (answer,) = solve(GOOD | {"gh_path_m": path})
    shoulder = np.array(answer["shoulder"])
    lambdas = np.linspace(0, 1, 101)
    expected = np.column_stack([np.interp(lambdas, [0, 0.5, 1], np.array(path)[:, k]) for k in range(3)])
    assert np.allclose(shoulder, expected, rtol=0, atol=1e-15)
    assert np.allclose(answer["wrist"][-1], TARGET, rtol=0, atol=1e-9)


def test_common_settings_apply_to_every_task():
    fixed, moving = (solve(GOOD, rhythm={"model": name})[0] for name in ("Fixed", "SoltaniZarrin2017"))
    assert np.ptp(fixed["shoulder"], axis=0).max() <= 1e-12
    assert np.ptp(moving["shoulder"], axis=0).max() > 1e-2


def test_left_arm_is_the_mirrored_right_arm():
    mirror = np.array([-1.0, 1.0, 1.0])
    subject = {"shoulder_start_m": [0.15, -0.06, 0.01]}
    (right,) = solve(GOOD | {"subject": subject})
    mirrored = {"target": (TARGET * mirror).tolist(), "subject": {"shoulder_start_m": [-0.15, -0.06, 0.01]}}
    (left,) = solve(GOOD | mirrored, subject={"arm": "left"})
    assert np.array_equal(left["q"], right["q"])
    assert np.array_equal(np.array(left["wrist"]), np.array(right["wrist"]) * mirror)


BAD = {
    "no dictionary": (3, "InvalidInput"),
    "no target": ({"id": "x", "q0": Q0}, "InvalidInput"),
    "unknown key": (GOOD | {"tarjet": 1}, "InvalidInput"),
    "three angles": (GOOD | {"q0": [0, 0, 0]}, "InvalidInput"),
    "nan": (GOOD | {"target": [float("nan"), 0, 0]}, "NotFinite"),
    "start in degrees": (GOOD | {"q0": [15, -30, 30, 60]}, "OutOfRange"),
    "end in degrees": (GOOD | {"q1": [60, -30, 30, 60]}, "OutOfRange"),
    "infinite start": (GOOD | {"q0": [float("inf"), 0, 0, 1]}, "NotFinite"),
    "zero length": (GOOD | {"subject": {"forearm_length_m": 0}}, "InvalidInput"),
    "out of reach": (GOOD | {"target": [3, 0, 0]}, "TargetUnreachable"),
    "one shoulder point": (GOOD | {"gh_path_m": [[0.1, 0, 0]]}, "InvalidInput"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_task_is_answered_and_disturbs_no_other(case):
    task, status = BAD[case]
    before, bad, after = solve(GOOD, task, GOOD)
    assert bad["status"] == status
    assert bad["q"] is None
    assert "errors.pydantic.dev" not in bad.get("message", "")
    assert before["q"] == after["q"]
    json.dumps([before, bad, after], allow_nan=False)


EXO_KEYS = {"exo_status", "exo_q", "exo_residual", "exo_margin", "exo_singularity", "exo_worst"}
EXO = "name: d\nshoulder: {a12_deg: 90, a23_deg: 90}\n"


def device(text=""):
    return parse_device(EXO + text, Path("d.yaml"))


def test_joints_of_the_device_put_the_arm_where_the_answer_has_it(run, tmp_path):
    file, mine = tmp_path / "tasks.json", tmp_path / "d.yaml"
    file.write_text(json.dumps([GOOD]), encoding="utf-8")
    mine.write_text(EXO + "girdle: {drives: NoLength, base_follows: true}\n", encoding="utf-8")
    (answer,) = run("plan", "--batch", file, "--exo", mine, "--json").json
    assert answer.keys() == KEYS | EXO_KEYS
    assert answer["exo_status"] == "ok"
    joints, arm_q = np.array(answer["exo_q"]), np.array(answer["q"])
    assert joints.shape == (101, 6)
    model = _core.ExoModel(core_exo(load_device(mine), ReachInput().subject), np.array(answer["shoulder"][0]))
    for row, angles in zip(joints, arm_q, strict=True):
        assert np.abs(_core.exo_upper_arm(model, row) - _core.posture_from_angles(angles).R_TU).max() < 1e-12
    assert np.abs(joints[:, 5] - arm_q[:, 3]).max() < 1e-12
    distance = np.linalg.norm(answer["shoulder"], axis=1)
    assert np.allclose(answer["exo_residual"], np.abs(distance - distance[0]), rtol=0, atol=1e-12)
    assert answer["exo_worst"]["least_margin_rad"] <= min(answer["exo_margin"])
    assert answer["exo_worst"]["refusal"] is None


def test_joints_of_a_batch_are_those_of_a_single_plan():
    reach = ReachInput(start_q_rad=tuple(Q0), target_m=tuple(TARGET))
    (answer,) = run_batch([GOOD], ReachInput(), device())
    generator = plan_reach(reach, 100.0, core_exo(device(), reach.subject)).generator
    ends = generator.sample(np.array([0.0, 2.0 * reach.duration_s]))["exo_q_rad"]
    assert np.abs(ends - np.array(answer["exo_q"])[[0, -1]]).max() < 1e-9


@pytest.mark.parametrize(
    ("text", "refusal"),
    [("joints: {shoulder_2: {range_deg: [0, 40]}}", "JointLimit"), ("mounts: {base_deg: [0, 0, 0]}", None)],
)
def test_a_device_that_cannot_follow_leaves_the_arm_s_answer_alone(text, refusal):
    (plain,) = solve(GOOD)
    (answer,) = run_batch([GOOD], ReachInput(), device(text))
    assert {key: answer[key] for key in KEYS - {"solve_us"}} == {key: plain[key] for key in KEYS - {"solve_us"}}
    assert answer["exo_status"] == ("ExoInfeasible" if refusal else "ok")
    assert answer["exo_worst"]["refusal"] == refusal
    if refusal:
        assert answer["exo_q"] is None
        assert answer["exo_worst"]["least_range_joint"] == "shoulder_2"
        assert answer["exo_worst"]["least_range_margin_rad"] < 0


def test_a_task_without_rhythm_or_motion_has_no_joints():
    path = [[0.15, -0.06, 0.01], [0.14, -0.04, 0.06]]
    answers = run_batch([GOOD | {"gh_path_m": path}, GOOD | {"target": [3, 0, 0]}], ReachInput(), device())
    assert [answer["exo_status"] for answer in answers] == ["Unsupported", None]
    for answer in answers:
        assert answer.keys() == KEYS | EXO_KEYS
        assert answer["exo_q"] is None


def test_an_angle_out_of_range_is_named():
    (answer,) = solve(GOOD | {"q0": [0.2, 0.0, 0.0, 60.0]})
    for word in ("'good'", "q0[4]", "60 rad", "4 pi", "degrees"):
        assert word in answer["message"]


@pytest.mark.parametrize(
    "wrong",
    [{"q0": [True, 0, 0, 1]}, {"q0": ["0.2", 0, 0, 1]}, {"target": [0.2, 0.4, False]}, {"id": True}, {"id": 1.5}],
    ids=str,
)
def test_only_a_number_is_a_number(wrong):
    (answer,) = solve(GOOD | wrong)
    assert answer["status"] == "InvalidInput"
    assert next(iter(wrong)) in answer["message"]


@pytest.mark.parametrize("target", [[200, 420, 250], [1e308, 1e308, 0.0]], ids=str)
def test_a_target_beyond_any_arm_is_named(target):
    (answer,) = solve(GOOD | {"target": target})
    assert answer["status"] == "OutOfRange"
    for word in ("'good'", "target", "5 m", "millimetres"):
        assert word in answer["message"]


def test_a_list_with_byte_order_mark_is_read(run, tmp_path):
    file = tmp_path / "tasks.json"
    file.write_bytes(b"\xef\xbb\xbf" + json.dumps([GOOD]).encode())
    assert run("plan", "--batch", file, "--json").json[0]["status"] == "ok"


def test_batch_is_deterministic():
    first, second = (solve(GOOD)[0] for _ in range(2))
    assert first["q"] == second["q"]


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("{}", "list"),
        ("[1,", "JSON"),
        ('[{"id": 1, "id": 2}]', "id stands twice"),
        ("[" * 100_000 + "]" * 100_000, "without end"),
    ],
    ids=["object", "cut off", "key twice", "deep"],
)
def test_bad_batch_file_is_an_input_error(run, tmp_path, text, word):
    file = tmp_path / "tasks.json"
    file.write_text(text, encoding="utf-8")
    done = run("plan", "--batch", file)
    assert done.code == 2
    assert word in done.err


def test_missing_batch_file_is_an_input_error(run):
    assert run("plan", "--batch", "no_such.json").code == 2


def test_options_for_one_reach_do_not_go_with_a_batch(run, tmp_path):
    file = tmp_path / "tasks.json"
    file.write_text("[]", encoding="utf-8")
    assert run("plan", "--batch", file, "--verify").code == 2
    assert run("plan", "--batch", file).json == []
