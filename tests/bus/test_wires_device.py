"""A motion made for one device is not sent to a bridge that drives another."""

import re
import sys
from pathlib import Path

import numpy as np
import pytest
from glenoid import _core
from glenoid.cli import main
from glenoid.cli.plan import plan_with_device
from glenoid.device_link import configured, differences, fingerprint, heard, require_within
from glenoid.devices import JOINTS, device_names, load_device, parse_device
from glenoid.inputs import InputError, load_reach
from glenoid.lcm_types import device_v1_t

sys.path.insert(0, str(Path(__file__).parent))
from wires_bridge import Bridge, device_message

ROOT = Path(__file__).resolve().parents[2]
DEVICE = "generic_75_75"
TEXT = """
name: mine
side: right
shoulder: {axes: [[0, 0, 1], [1, 0, 0], [0, 0, 1]]}
mounts: {base_deg: [20, 0, 0]}
girdle: {drives: NoLength, order: ElevationFirst}
joints:
  shoulder_2: {range_deg: [10, 130]}
"""


def device(text=TEXT):
    return parse_device(text, Path("mine.yaml"))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("side: right", "side: left"),
        ("[1, 0, 0]", "[0, 1, 0]"),
        ("[20, 0, 0]", "[20.001, 0, 0]"),
        ("NoLength", "Full"),
        ("ElevationFirst", "ProtractionFirst"),
        ("[10, 130]", "[10, 131]"),
        ("shoulder_2:", "shoulder_3:"),
        ("mounts: {", "mounts: {cuff_deg: [0, 1, 0], "),
    ],
)
def test_the_fingerprint_is_of_what_turns_motion_into_joint_angles(old, new):
    assert old in TEXT
    assert fingerprint(device(TEXT.replace(old, new))) != fingerprint(device())


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("name: mine", "name: yours\nnote: a word"),
        ("base_deg: [20, 0, 0]", f"base_rad: [{np.deg2rad(20.0)}, 0, 0]"),
        ("[[0, 0, 1]", "[[-0.0, 0, 1]"),
        ("[10, 130]}", "{value: [10, 130], status: assumed}}"),
        ("130]}", "130], gear: {ratio: 2, sign: -1, encoder_counts_per_turn: 8}}"),
    ],
)
def test_the_fingerprint_is_not_of_words_units_or_gears(old, new):
    assert old in TEXT
    assert fingerprint(device(TEXT.replace(old, new))) == fingerprint(device())


def test_shipped_devices_tell_each_other_apart():
    complete = [load_device(name) for name in device_names() if not load_device(name).missing]
    assert len({fingerprint(one) for one in complete}) == len(complete) >= 5


def told(**changes):
    """A bridge that drives `device()`."""
    message = device_message(device="mine", device_sha256=fingerprint(device()), limit_rad=2.0)
    message.lower_rad[3], message.upper_rad[3] = np.deg2rad(10.0), np.deg2rad(130.0)
    for name, value in changes.items():
        setattr(message, name, value)
    return message


def test_the_same_device_has_no_differences():
    assert list(differences(heard(told()), device(), "right")) == []
    assert list(differences(heard(told(device_sha256=[0] * 64)), device(), "right")) == []  # a bridge that does not say


def test_every_difference_is_named():
    swapped = [*JOINTS[:2], JOINTS[3], JOINTS[2], *JOINTS[4:]]
    for message, words in (
        (device_message(joints=swapped), r"^joints: .*shoulder_2, shoulder_1"),
        (device_message(joints=JOINTS[:5]), r"^joints: "),
        (told(side=device_v1_t.LEFT), r"^side: .*left.*right"),
        (told(device_sha256=[*b"0" * 64]), r"^device: .*000000000000.*mine.*sha256: [0-9a-f]{64}"),
        (told(upper_rad=[3.0] * 16), r"shoulder_2: .*3 rad.*2.269"),
    ):
        assert any(re.search(words, line) for line in differences(heard(message), device(), "right")), words


def test_a_motion_beyond_the_bridges_limits_is_refused():
    motion = np.zeros((3, 6))
    require_within(heard(device_message(limit_rad=1.0)), motion + 1.0)
    motion[1, 5] = -1.01
    with pytest.raises(InputError, match=r"elbow: .*-1.01"):
        require_within(heard(device_message(limit_rad=1.0)), motion)


def example(name):
    """A shipped configuration of a bridge."""
    return configured(
        _core.BridgeConfig.parse((ROOT / f"host/bridge/examples/{name}.yaml").read_text(encoding="utf-8"))
    )


@pytest.mark.parametrize("name", ["six_drives", "six_drives_udp"])
def test_the_examples_are_for_the_device_that_they_name(name):
    """Fingerprint, joints, side and limits of the file are those of the device file."""
    driven = example(name)
    assert driven.device
    assert driven.device_sha256
    assert list(differences(driven, load_device(driven.device), driven.side)) == []


@pytest.mark.usefixtures("fmu")
def test_source_refuses_a_bridge_of_another_device(url, monkeypatch, capsys):
    arguments = ["glenoid", "source", "--start-q-deg", "15,-30,30,60", "--target-m", "0.20,0.42,0.25", "--exo", DEVICE]
    monkeypatch.setattr(sys, "argv", [*arguments, "--lcm-url", url])
    other = device_message(device="other", device_sha256="0" * 64)
    with Bridge(url, [0.0] * 6, device=other) as bridge, pytest.raises(SystemExit) as end:
        sys.exit(main())
    assert end.value.code == 2
    assert "device: the bridge's configuration is for other" in capsys.readouterr().err
    assert bridge.commands == []


def test_the_example_lets_the_reach_of_the_document_pass():
    """docs/bridge.md sends it to these drives: no joint is cut off at a limit."""
    reach = load_reach(ROOT / "host/examples/reach_to_head.yaml")
    planned, _ = plan_with_device(reach, 100.0, "harmony")
    require_within(example("six_drives"), planned.samples["exo_q_rad"])


@pytest.mark.usefixtures("fmu")
def test_a_rehearsal_refuses_a_bridge_of_another_device(tmp_path, monkeypatch, capsys):
    text = (ROOT / "host/rehearsals/reach_high.yaml").read_text(encoding="utf-8")
    assert "generic_75_75" in text
    text = text.replace("generic_75_75", "harmony")
    text = text.replace("bridge/", f"{ROOT}/host/rehearsals/bridge/").replace("../", f"{ROOT}/host/")
    (tmp_path / "other.yaml").write_text(text, encoding="utf-8")
    monkeypatch.setattr(sys, "argv", ["glenoid", "rehearse", str(tmp_path / "other.yaml"), "--out", str(tmp_path)])
    with pytest.raises(SystemExit) as end:
        sys.exit(main())
    assert end.value.code == 2
    assert "shoulder_2: the bridge allows" in capsys.readouterr().err
