"""What a rehearsal leaves: a page that needs nothing else, and logs that other programs read and that agree."""

import base64
import hashlib
import json
import re

import can
import jsonschema
import lcm
import mcap.reader
import numpy as np
import pytest
import yaml
from glenoid import _core
from glenoid.fmus import fmu_path
from glenoid.lcm_types import event_v1_t, feedback_v1_t, setpoint_v1_t, status_v1_t
from glenoid.publisher import EVENT, FEEDBACK, SETPOINT, STATUS, decoded, text_of
from glenoid.recording import read_recording
from glenoid.rehearse.checks import CHECKS
from glenoid.rehearse.run import rehearse

TYPES = {SETPOINT: setpoint_v1_t, FEEDBACK: feedback_v1_t, STATUS: status_v1_t, EVENT: event_v1_t}


@pytest.fixture(scope="module")
def page(good_folder):
    return (good_folder / "report.html").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def facts(good_folder):
    return json.loads((good_folder / "rehearsal.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def config(good_folder):
    return _core.BridgeConfig.parse((good_folder / "bridge.yaml").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def messages(good_folder):
    """Of the LCM log, by channel, decoded."""
    out = {}
    for event in lcm.EventLog(str(good_folder / "lcm.log"), "r"):
        kind = TYPES.get(event.channel)
        if kind is not None:
            message = decoded(kind, event.data)
            assert message is not None
            out.setdefault(event.channel, []).append((event.timestamp, message))
    return out


@pytest.fixture(scope="module")
def channels(good_folder):
    """Of the MCAP file: messages by topic and the schemas."""
    rows, schemas = {}, {}
    with (good_folder / "rehearsal.mcap").open("rb") as file:
        for schema, channel, message in mcap.reader.make_reader(file).iter_messages():
            rows.setdefault(channel.topic, []).append((message.log_time, json.loads(message.data)))
            schemas[channel.topic] = (schema.encoding, json.loads(schema.data))
    return rows, schemas


@pytest.fixture(scope="module")
def frames(good_folder):
    with can.CanutilsLogReader(str(good_folder / "candump.log")) as log:
        return list(log)


def test_page_fetches_nothing(page):
    assert not re.search(r"https?://", page)
    assert not re.search(r"<(script|link|iframe|object|embed)\b", page)
    assert not re.search(r"@import|url\(", page)
    assert all(target.startswith("data:image/png;base64,") for target in re.findall(r'(?:src|href)="([^"]*)', page))


def test_page_tells_verdict_checks_pictures_events_and_scenario(page, facts):
    assert f'<span class="verdict {facts["verdict"]}">' in page
    for name in CHECKS:
        assert f"<td>{name.replace('_', ' ')}</td>" in page
    for figure in re.findall(r'src="data:image/png;base64,([^"]*)', page):
        assert base64.b64decode(figure).startswith(b"\x89PNG")
    for words in (
        "Joints",
        "Drives",
        "Tracking error",
        "Jitter",
        "armed: all drives follow",
        "stature_m",
        "not a medical device",
    ):
        assert words in page
    assert facts["config_hash"] in page
    assert facts["fmu_sha256"] in page


def test_page_of_a_fault_names_it_and_the_safe_state(scenario_of, tmp_path):
    rehearse(scenario_of("fault_drive_emcy"), tmp_path)
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    for words in (
        "drive emcy",
        "shoulder_2",
        "safe state",
        "expected FAULT with DriveEmergency",
        "continuous over-current",
    ):
        assert words in page


def test_page_begins_with_who_did_what_and_why_it_is_so(page, scenario_of, tmp_path):
    top = page[: page.index("<h2>Margins")]
    for words in (
        "reach high · man of 1.75 m and 75 kg, right arm · generic_75_75",
        "PASS</span>nearest to its limit is bus load",
    ):
        assert words in top
    rehearse(scenario_of("reach_high", lambda data: data.update(checks={"arm_speed": {"limit": 0.5}})), tmp_path)
    failed = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert re.search(r"FAIL</span>arm speed: [0-9.]+ of 0.5 rad/s, upper arm</p>", failed)


def test_page_gives_angles_in_degrees_and_lengths_in_millimetres_too(page, facts):
    for name, unit, factor in (("joint_margin", "deg", 180.0 / np.pi), ("arrival", "mm", 1e3)):
        value = next(check["value"] for check in facts["checks"] if check["name"] == name)
        row = re.search(rf"<tr[^>]*><td>{name.replace('_', ' ')}</td>.*?</tr>", page)[0]
        shown = re.search(rf"<td class=n>([0-9.e+-]+) {unit}</td>", row)
        assert float(shown[1]) == pytest.approx(factor * value, rel=5e-3)  # three digits


def test_page_is_readable_in_the_dark_and_on_a_narrow_screen(page):
    assert "prefers-color-scheme: dark" in page
    assert page.count('<div class="wide"><table>') == page.count("<table>")


def test_facts_hold_verdict_and_hashes(facts, config, good_folder):
    assert facts["verdict"] == "PASS"
    assert facts["config_hash"] == config.hash
    assert facts["fmu_sha256"] == hashlib.sha256(fmu_path("3").read_bytes()).hexdigest()
    assert facts["scenario_sha256"] == hashlib.sha256((good_folder / "scenario.yaml").read_bytes()).hexdigest()
    assert {check["name"] for check in facts["checks"]} == set(CHECKS)
    assert facts["faults"] == 0
    assert facts["not_decided_by"] == []


def test_resolved_scenario_has_every_default_written_out(good_folder):
    data = yaml.safe_load((good_folder / "scenario.yaml").read_text(encoding="utf-8"))
    assert data["subject"]["stature_m"] == 1.75
    assert data["checks"]["tracking_error"] == {"level": "error", "limit": 0.02}
    assert data["bridge"]["file"] == "bridge.yaml"


def test_every_channel_describes_itself(channels):
    rows, schemas = channels
    assert set(rows) == {
        f"/glenoid/{n}" for n in ("setpoint", "command", "feedback", "status", "event", "source", "can")
    }
    for topic, found in rows.items():
        encoding, schema = schemas[topic]
        assert encoding == "jsonschema"
        judge = jsonschema.Draft202012Validator(schema)
        for _, row in found[:: max(1, len(found) // 50)]:
            judge.validate(row)
            assert set(row) == set(schema["properties"])


def test_replay_reads_the_lcm_log(good_folder):
    recording = read_recording(good_folder / "lcm.log", "setpoint")
    assert recording.joints == 6
    assert recording.duration_s > 2.0


def test_lcm_log_and_mcap_agree(messages, channels):
    rows, _ = channels
    for channel, topic in ((SETPOINT, "/glenoid/setpoint"), (FEEDBACK, "/glenoid/feedback")):
        assert len(messages[channel]) == len(rows[topic])
        for (_, message), (_, row) in zip(messages[channel], rows[topic], strict=True):
            assert message.time_mono_ns == row["time_ns"]
            assert str(message.session) == row["session"]
            assert list(message.position_rad[:6]) == row["position_rad"]
            assert list(message.velocity_rad_per_s[:6]) == row["velocity_rad_per_s"]
    texts = [text_of(message.text) for _, message in messages[EVENT]]
    assert texts == [row["text"] for _, row in rows["/glenoid/event"]]
    assert len(messages[STATUS]) == len(rows["/glenoid/status"])


def test_lcm_log_is_in_the_order_of_time(messages):
    for rows in messages.values():
        stamps = [stamp for stamp, _ in rows]
        assert stamps == sorted(stamps)


def test_mcap_and_candump_hold_the_same_frames(channels, frames):
    rows, _ = channels
    assert len(frames) == len(rows["/glenoid/can"])
    for frame, (log_time, row) in zip(frames, rows["/glenoid/can"], strict=True):
        assert frame.arbitration_id == row["id"]
        assert bytes(frame.data).hex() == row["data"]
        # written with microseconds, read as a double of seconds
        assert abs(frame.timestamp - 1e-9 * log_time) < 1e-6 + 4 * np.spacing(frame.timestamp)


def test_drives_answers_on_the_bus_are_the_feedback(messages, frames, config):
    """6064h of each TPDO by the gear of the configuration: the position that the bridge told, to the last bit of a count."""
    answers = {}
    for frame in frames:
        if frame.arbitration_id & 0x780 == 0x180 and len(frame.data) == 8:
            answers.setdefault(frame.arbitration_id & 0x7F, []).append(
                int.from_bytes(frame.data[2:6], "little", signed=True)
            )
    for k, joint in enumerate(config.joints):
        per_rad = joint["sign"] * joint["gear_ratio"] * joint["encoder_counts_per_turn"] / (2.0 * np.pi)
        told = [
            round((message.position_rad[k] - joint["offset_rad"]) * per_rad)
            for _, message in messages[FEEDBACK]
            if message.valid_mask >> k & 1
        ]
        assert told == answers[joint["node"]][-len(told) :]
        assert len(told) > 1000


def test_targets_on_the_bus_are_the_commands(messages, frames, config):
    sent = [f for f in frames if f.arbitration_id == 0x200 + config.joints[2]["node"]]
    counts = {int.from_bytes(f.data[2:6], "little", signed=True) for f in sent}
    joint = config.joints[2]
    per_rad = joint["sign"] * joint["gear_ratio"] * joint["encoder_counts_per_turn"] / (2.0 * np.pi)
    commands = [m.command_rad[2] for _, m in messages[FEEDBACK] if m.state == status_v1_t.RUN]
    assert len(commands) > 1000
    assert {round((q - joint["offset_rad"]) * per_rad) for q in commands} <= counts
