"""Two runs in virtual time are the same to the last bit; what changes the drives' motion changes the hash."""

import json
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest
import yaml
from glenoid import _core
from glenoid.inputs import InputError
from glenoid.programs import program
from glenoid.rehearse.run import perform, rehearse
from glenoid.rehearse.scenario import load_scenario

FOLDER = Path(__file__).resolve().parents[2] / "host/rehearsals"
BRIDGE = FOLDER / "bridge/six_drives.yaml"
STAMPS = {"created_utc", "wall_s"}
STAMP_LINE = re.compile(rb'<p class="small" id="stamp">[^<]*</p>')


def without_stamps(path):
    if path.name == "rehearsal.json":
        return {key: value for key, value in json.loads(path.read_text()).items() if key not in STAMPS}
    return STAMP_LINE.sub(b"", path.read_bytes())


def test_two_runs_leave_the_same_folder_but_for_the_stamps_of_the_clock(good_folder, tmp_path):
    rehearse(load_scenario(FOLDER / "reach_high.yaml"), tmp_path)
    names = sorted(path.name for path in good_folder.iterdir())
    assert names == sorted(path.name for path in tmp_path.iterdir())
    different = [name for name in names if without_stamps(good_folder / name) != without_stamps(tmp_path / name)]
    assert different == []


def losing(seed):
    """One frame in twenty of every drive is lost for half a second."""

    def change(data):
        data["drives"] = {"seed": seed}
        data["faults"] = [{"kind": "drive_drop", "at_s": 0.5, "duration_s": 0.5, "loss_per_mille": 50}]

    return change


def frames_of(scenario):
    frames = perform(scenario, lambda _stage, _share: None).record.frames
    return b"".join(np.ascontiguousarray(frames[name]).tobytes() for name in sorted(frames))


@pytest.mark.parametrize(
    ("name", "change"), [("fault_drive_reboots", lambda data: None), ("reach_high", losing(1))], ids=["reboot", "loss"]
)
def test_faults_are_as_repeatable(scenario_of, name, change):
    assert frames_of(scenario_of(name, change)) == frames_of(scenario_of(name, change))


def test_another_seed_loses_other_frames(scenario_of):
    assert frames_of(scenario_of("reach_high", losing(1))) != frames_of(scenario_of("reach_high", losing(2)))


def test_folder_can_be_rehearsed_again(good_folder, tmp_path):
    done = rehearse(load_scenario(good_folder / "scenario.yaml"), tmp_path)
    assert done.verdict == "PASS"
    assert (tmp_path / "candump.log").read_bytes() == (good_folder / "candump.log").read_bytes()


def configuration(change=lambda exo: None):
    data = yaml.safe_load(BRIDGE.read_text(encoding="utf-8"))
    change(data["exoskeletons"]["six_generic_drives"])
    return _core.BridgeConfig.parse(yaml.safe_dump(data, sort_keys=False))


CHANGES = {
    "velocity limit": lambda exo: exo["joint_defaults"]["limits"].update(velocity_rad_per_s=3.4),
    "upper limit": lambda exo: exo["joints"][5]["limits"].update(upper_rad=2.5),
    "gear": lambda exo: exo["joint_defaults"]["gear"].update(ratio=101),
    "sign": lambda exo: exo["joint_defaults"]["gear"].update(sign=-1),
    "node": lambda exo: exo["joints"][0].update(node=9),
    "delay": lambda exo: exo["setpoints"].update(delay_ms=6),
    "quick stop": lambda exo: exo["setpoints"].update(quick_stop_after_ms=40),
    "heartbeat": lambda exo: exo["heartbeat"].update(drive_waits_ms=80),
    "following error": lambda exo: exo["joint_defaults"]["following_error"].update(window_rad=0.2),
}


@pytest.mark.parametrize("what", sorted(CHANGES))
def test_hash_changes_with_what_decides_the_motion(what):
    assert configuration(CHANGES[what]).hash != configuration().hash


def test_hash_does_not_look_at_the_bus_or_the_comments():
    other = configuration(lambda exo: exo["buses"][0].update(url="socketcan:can0"))
    assert other.hash == configuration().hash == _core.BridgeConfig.parse(BRIDGE.read_text(encoding="utf-8")).hash


def test_hash_is_the_one_that_the_bridge_prints(good_folder):
    try:
        bridge = program("glenoid-bridge")
    except InputError as error:
        pytest.skip(str(error))
    facts = json.loads((good_folder / "rehearsal.json").read_text())
    for file in (BRIDGE, good_folder / "bridge.yaml"):
        told = subprocess.run([bridge, file, "--check-config"], capture_output=True, text=True, check=True).stdout
        assert f"config_hash {facts['config_hash']}\n" in told


def test_a_run_that_breaks_off_leaves_no_older_verdict(tmp_path, monkeypatch):
    from glenoid.rehearse import run

    scenario = load_scenario(FOLDER / "reach_high.yaml")
    (tmp_path / "rehearsal.json").write_text('{"verdict": "PASS"}')
    monkeypatch.setattr(run, "perform", lambda *_: (_ for _ in ()).throw(InputError("stopped here")))
    with pytest.raises(InputError, match="stopped here"):
        run.rehearse(scenario, tmp_path)
    assert not (tmp_path / "rehearsal.json").exists()
