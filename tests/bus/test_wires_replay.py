"""`glenoid replay`: recordings of every kind, and what a bridge gets to see of them."""

import json
import sys
from pathlib import Path

import lcm
import numpy as np
import pytest
from glenoid.cli import main
from glenoid.inputs import InputError
from glenoid.lcm_types import command_v1_t, feedback_v1_t, setpoint_v1_t
from glenoid.publisher import COMMAND, FEEDBACK, SETPOINT, checked_url, decoded, setpoint_bytes
from glenoid.recording import make_recording, read_recording
from glenoid.streaming import Blend, Replayed, blend_within

sys.path.insert(0, str(Path(__file__).parent))
import fuzz_recordings
from wires_bridge import Bridge

JOINTS = 6
DURATION_S = 1.0
REST = np.linspace(0.1, 0.6, JOINTS)


def samples(rate_hz=100.0):
    """Minimum jerk from REST by 0.3 rad in every joint: rest to rest."""
    time = np.arange(0.0, DURATION_S + 0.5 / rate_hz, 1.0 / rate_hz)
    blend = Blend(REST, REST + 0.3, DURATION_S)
    rows = [blend.at(t) for t in time]
    return time, np.array([q for q, _ in rows]), np.array([v for _, v in rows])


@pytest.fixture
def run(capsys, monkeypatch):
    def call(*arguments):
        monkeypatch.setattr(sys, "argv", ["glenoid", *map(str, arguments)])
        try:
            code = main()
        except SystemExit as stop:
            code = stop.code or 0
        out, err = capsys.readouterr()
        return code, out, err

    return call


def write_csv(path):
    time, q, v = samples()
    names = ["time_s", *[f"q{k}_rad" for k in range(1, 7)], *[f"dq{k}_rad_per_s" for k in range(1, 7)]]
    np.savetxt(path, np.column_stack([time, q, v]), delimiter=",", header=",".join(names), comments="")
    return path


def write_log(path, channel=SETPOINT, session=5, rubbish=()):
    log = lcm.EventLog(str(path), "w", overwrite=True)
    for k, (t, q, v) in enumerate(zip(*samples(), strict=True)):
        log.write_event(k, "OTHER", b"not ours")
        if channel == SETPOINT:
            data = setpoint_bytes(round(1e9 * (3.0 + t)), k + 1, session, q.tolist(), v.tolist())
        else:
            message = feedback_v1_t()
            message.time_mono_ns, message.session, message.count = round(1e9 * (3.0 + t)), session, JOINTS
            message.position_rad, message.velocity_rad_per_s = [*q, *[0.0] * 10], [*v, *[0.0] * 10]
            data = message.encode()
        log.write_event(k, channel, data)
    for data in rubbish:
        log.write_event(10**6, channel, data)
    log.close()
    return path


def write_json(path):
    time, q, v = samples()
    motion = {"time_s": time.tolist()}
    device = {"exo_q_rad": q.tolist(), "exo_dq_rad_per_s": v.tolist()}
    path.write_text(json.dumps({"motion": motion, "exo": device}), encoding="utf-8")
    return path


WRITERS = {"a.csv": write_csv, "a.json": write_json, "a.log": write_log, "b.log": lambda p: write_log(p, FEEDBACK)}


@pytest.mark.parametrize("name", WRITERS)
def test_every_kind_of_file_gives_the_same_motion(name, tmp_path):
    recording = read_recording(WRITERS[name](tmp_path / name))
    time, q, v = samples()
    # stamps are whole nanoseconds; the text of numbers has 18 digits
    np.testing.assert_allclose(recording.time_s, time, atol=1e-9)
    np.testing.assert_allclose(recording.position_rad, q, atol=1e-15)
    np.testing.assert_allclose(recording.velocity_rad_per_s, v, atol=1e-15)
    assert recording.skipped == 0


def test_unreadable_messages_and_other_sessions_of_a_log_are_left_out(tmp_path):
    good = setpoint_bytes(10**12, 1, 99, [0.0] * JOINTS, [0.0] * JOINTS)
    rubbish = (b"", good[:-1], good + b"\0", b"\xff" * len(good), good)
    recording = read_recording(write_log(tmp_path / "a.log", rubbish=rubbish))
    assert recording.skipped == 5
    assert len(recording.time_s) == len(samples()[0])


BAD = {
    "empty.csv": "",
    "text.csv": "time_s,q1_rad\n0,x\n1,2\n",
    "short_row.csv": "time_s,q1_rad\n0,1\n1\n",
    "one_row.csv": "time_s,q1_rad\n0,1\n",
    "no_joints.csv": "time_s,theta_rad\n0,1\n1,2\n",
    "backwards.csv": "time_s,q1_rad\n1,1\n0,2\n",
    "nan.csv": "time_s,q1_rad\n0,nan\n1,2\n",
    "inf.csv": "time_s,q1_rad\n0,1\ninf,2\n",
    "empty.json": "",
    "list.json": "[1, 2]",
    "other.json": '{"time_s": [0, 1]}',
    "ragged.json": '{"time_s": [0, 1], "exo_q_rad": [[1, 2], [1]]}',
    "text.json": '{"time_s": [0, 1], "exo_q_rad": [["a"], ["b"]]}',
    "rubbish.log": "\x00\x01\x02 this is no log" * 100,
    "empty.log": "",
}


@pytest.mark.parametrize("name", BAD)
def test_bad_files_are_refused_by_name_with_status_2(name, tmp_path, run):
    path = tmp_path / name
    path.write_text(BAD[name], encoding="utf-8")
    code, _, err = run("replay", path)
    assert code == 2
    assert name in err


def test_a_missing_file_is_refused(tmp_path, run):
    assert run("replay", tmp_path / "none.csv")[0] == 2


@pytest.mark.parametrize("speed", [0.3, 1.0, 2.5])
@pytest.mark.parametrize("cut", [(0.0, 1.0), (0.2, 0.8), (0.49, 0.51)])
def test_a_replay_begins_and_ends_at_rest_and_its_velocity_is_the_slope(speed, cut):
    time, q, v = samples(rate_hz=500.0)
    kept = (time >= cut[0]) & (time <= cut[1])
    motion = Replayed(make_recording(time[kept], q[kept], v[kept], "here"), speed)
    first, still = motion.at(0.0)
    last, stopped = motion.at(motion.duration_s)
    np.testing.assert_allclose(first, q[kept][0])
    np.testing.assert_allclose(last, q[kept][-1])
    assert np.abs(still).max() < 1e-3 * speed  # slower than what counts as at rest
    assert np.abs(stopped).max() < 1e-3 * speed
    h = 1e-5
    for t in np.linspace(2 * h, motion.duration_s - 2 * h, 57):
        slope = (motion.at(t + h)[0] - motion.at(t - h)[0]) / (2 * h)
        # central difference: at a corner of the clock's rate half the jump of acceleration times h is left
        np.testing.assert_allclose(motion.at(t)[1], slope, atol=h * 20 * speed**2 + 1e-10 / h)


@pytest.mark.parametrize("distance", [1e-6, 0.05, 1.0, 3.0])
def test_a_blend_stays_within_its_share_of_the_limits(distance):
    speed, acceleration = np.array([1.0, 0.2]), np.array([2.0, 10.0])
    blend = blend_within(np.zeros(2), np.array([distance, -distance]), speed, acceleration)
    times = np.linspace(0.0, blend.duration_s, 2001)
    velocity = np.array([blend.at(t)[1] for t in times])
    assert (np.abs(velocity).max(axis=0) <= 0.5 * speed * (1 + 1e-9)).all()
    # differences of the velocity: error h |jerk| / 2, jerk at most 60 d / T^3
    slack = 30 * distance / blend.duration_s**3 * times[1]
    assert (np.abs(np.diff(velocity, axis=0) / times[1]).max(axis=0) <= 0.5 * acceleration + slack).all()
    np.testing.assert_array_equal(blend.at(-1.0)[0], np.zeros(2))


def test_replay_restamps_and_starts_bumpless_with_a_fresh_token(url, tmp_path, run):
    here = REST - 0.05
    with Bridge(url, here) as bridge:
        code, out, err = run("replay", write_log(tmp_path / "a.log"), "--lcm-url", url, "--rate-hz", 200)
    assert code == 0, out + err
    got = bridge.setpoints
    assert {s.session for s in got} == {4711}
    assert [s.sequence for s in got] == list(range(1, len(got) + 1))
    stamps = np.array([s.time_mono_ns for s in got])
    steps = np.diff(stamps)
    assert (steps > 0).all()
    assert (steps % 5_000_000 == 0).all(), "on the grid, whatever the jitter"
    q = np.array([s.position_rad[:JOINTS] for s in got])
    v = np.array([s.velocity_rad_per_s[:JOINTS] for s in got])
    np.testing.assert_array_equal(q[0], here)
    np.testing.assert_allclose(q[-1], REST + 0.3, atol=1e-12)
    assert np.abs(v).max() <= 2.0
    # between two setpoints no joint goes further than its fastest speed allows
    assert (np.abs(np.diff(q, axis=0)) <= np.abs(v).max() * steps[:, None] * 1e-9 + 1e-12).all()
    assert bridge.commands == [command_v1_t.ARM, command_v1_t.START, command_v1_t.DISARM]


def test_a_bus_that_may_reach_hardware_is_refused_unless_forced(url, tmp_path, run):
    path = write_csv(tmp_path / "a.csv")
    with Bridge(url, REST, real_bus_mask=2) as bridge:
        code, _, err = run("replay", path, "--lcm-url", url)
        assert code == 2
        assert "hardware" in err
        assert command_v1_t.ARM not in bridge.commands
        assert run("replay", path, "--lcm-url", url, "--force-real-bus", "--rate-hz", 100)[0] == 0


def test_what_is_faster_than_the_bridge_allows_is_refused_with_a_speed_that_would_do(url, tmp_path, run):
    path = write_csv(tmp_path / "a.csv")
    with Bridge(url, REST, speed_limit=0.5) as bridge:  # the motion reaches 15/8 * 0.3 rad/s
        code, _, err = run("replay", path, "--lcm-url", url)
        assert code == 2
        speed = float(err.split("--speed ")[1].split()[0])
        assert command_v1_t.ARM not in bridge.commands
        assert run("replay", path, "--lcm-url", url, "--speed", speed, "--rate-hz", 100)[0] == 0


@pytest.mark.parametrize(
    ("trouble", "words"),
    [({"refuse_arming": "the local e-stop is pressed"}, "e-stop"), ({"stop_after": 60}, "something broke")],
)
def test_what_the_bridge_says_reaches_the_user_with_status_1(url, tmp_path, run, trouble, words):
    with Bridge(url, REST, **trouble):
        arguments = ["--lcm-url", url, "--timeout-s", 1.5, "--rate-hz", 100]
        code, _, err = run("replay", write_csv(tmp_path / "a.csv"), *arguments)
    assert code == 1
    assert words in err


def test_other_joints_are_refused(url, tmp_path, run):
    with Bridge(url, REST[:3]):
        code, _, err = run("replay", write_csv(tmp_path / "a.csv"), "--lcm-url", url)
    assert code == 2
    assert "6 joints" in err


def test_without_a_bridge_it_gives_up(url, tmp_path, run):
    code, _, err = run("replay", write_csv(tmp_path / "a.csv"), "--lcm-url", url, "--timeout-s", 0.3)
    assert code == 1
    assert "silent" in err


@pytest.mark.parametrize("bad", ["udpm://239.255.76.67:7667?ttl=1", "tcpq://localhost", "udpm://?ttl=0&ttl=3", ""])
def test_urls_that_leave_the_machine_need_leave(bad):
    with pytest.raises(InputError):
        checked_url(bad)
    assert checked_url(bad, allow_network=True) == bad


@pytest.mark.parametrize("kind", [setpoint_v1_t, feedback_v1_t, command_v1_t])
def test_decoding_wants_the_exact_bytes(kind):
    data = kind().encode()
    assert decoded(kind, data) is not None
    for size in range(len(data)):
        assert decoded(kind, data[:size]) is None
    assert decoded(kind, data + b"\0") is None
    assert decoded(kind, bytes([data[0] ^ 1]) + data[1:]) is None


@pytest.mark.parametrize(
    ("position", "velocity"), [([], []), ([0.0] * 17, [0.0] * 17), ([0.0], [0.0, 1.0]), ([float("nan")], [0.0])]
)
def test_setpoints_that_cannot_be_are_not_sent(position, velocity):
    with pytest.raises(ValueError, match=r"setpoint|positions"):
        setpoint_bytes(0, 1, 1, position, velocity)


def test_channels_are_those_of_the_contract():
    assert (SETPOINT, FEEDBACK, COMMAND) == ("GLENOID_SETPOINT", "GLENOID_FEEDBACK", "GLENOID_COMMAND")


@pytest.mark.parametrize("kind", ["csv", "json", "log"])
def test_damaged_files_are_read_or_refused_in_words(kind):
    data = (Path(__file__).parent / "corpus/recordings" / kind).read_bytes()
    fuzz_recordings.run(data)
    for size in range(0, len(data), 1 if kind != "log" else 17):
        fuzz_recordings.run(data[:size])
    for k in range(1, len(data), 1 if kind != "log" else 7):
        for byte in (0x00, 0x7F, 0xFF, data[k] ^ 1):
            fuzz_recordings.run(data[:k] + bytes([byte]) + data[k + 1 :])


def test_files_beyond_the_parsers_limits_are_refused_in_words():
    fuzz_recordings.run(b"ctime_s,q1_rad\n" + b"1" * 200_000 + b",1\n")
    fuzz_recordings.run(b"j" + b"[" * 100_000)
