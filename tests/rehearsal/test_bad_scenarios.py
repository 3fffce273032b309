"""Scenario files that are refused: file, key, value and rule are named, exit status 2."""

from pathlib import Path

import pytest
import yaml

FOLDER = Path(__file__).resolve().parents[2] / "host/rehearsals"


def good():
    data = yaml.safe_load((FOLDER / "reach_high.yaml").read_text(encoding="utf-8"))
    data["subject"] = str((FOLDER / data["subject"]).resolve())
    data["bridge"]["file"] = str((FOLDER / data["bridge"]["file"]).resolve())
    return data


def fault(**keys):
    return lambda data: data.update(faults=[{"kind": "estop", "at_s": 1.0} | keys])


BAD = {
    "unknown key": (lambda d: d.update(speed=2), ["speed = 2", "unknown key"]),
    "unknown check": (lambda d: d.update(checks={"charm": "error"}), ["checks.charm", "unknown key"]),
    "unknown level": (lambda d: d.update(checks={"jitter": "loud"}), ["checks.jitter.level = 'loud'", "'warn'"]),
    "check without meaning": (lambda d: d.update(checks={"jitter": 3}), ["checks.jitter = 3"]),
    "no movements": (lambda d: d.update(movements=[]), ["movements = []", "at least 1"]),
    "movements missing": (lambda d: d.pop("movements"), ["movements", "missing"]),
    "two targets": (
        lambda d: d.update(movements=[{"activity": "drink", "target_m": [0, 0.3, 0]}]),
        ["movements.0", "one of the two"],
    ),
    "unknown activity": (lambda d: d.update(movements=[{"activity": "juggle"}]), ["juggle", "'comb_hair'"]),
    "hasty": (lambda d: d["movements"][0].update(duration_s=0.01), ["movements.0.duration_s = 0.01", "0.3"]),
    "not finite": (lambda d: d["movements"][0].update(duration_s=float("nan")), ["movements.0.duration_s", "finite"]),
    "truth as a number": (lambda d: d["movements"][0].update(duration_s=True), ["movements.0.duration_s = True"]),
    "text as a number": (fault(at_s="1"), ["faults.0.at_s = '1'"]),
    "half a seed": (lambda d: d.update(drives={"seed": 1.5}), ["drives.seed = 1.5"]),
    "limit that is none": (lambda d: d.update(checks={"jitter": {"limit": True}}), ["checks.jitter.limit = True"]),
    "unknown fault": (fault(kind="gremlin"), ["faults.0.kind = 'gremlin'"]),
    "fault in the past": (fault(at_s=-1), ["faults.0.at_s = -1"]),
    "figure of another fault": (fault(jump_rad=0.1), ["faults.0", "jump_rad does not belong to estop"]),
    "unknown joint": (fault(kind="drive_jam", joint="knee"), ["faults.0.joint = 'knee'", "shoulder_1"]),
    "expectation without a fault": (
        lambda d: d.update(expect={"state": "STOP", "within_ms": 5}),
        ["expect", "without faults"],
    ),
    "unknown state": (
        lambda d: (fault()(d), d.update(expect={"state": "ASLEEP", "within_ms": 5})),
        ["expect.state = 'ASLEEP'"],
    ),
    "unknown fault of the bridge": (
        lambda d: (fault()(d), d.update(expect={"state": "STOP", "fault": "Gremlins", "within_ms": 5})),
        ["Gremlins", "StaleSetpoints"],
    ),
    "no such subject": (lambda d: d.update(subject="nobody.yaml"), ["nobody.yaml", "No such file"]),
    "no such bridge": (lambda d: d["bridge"].update(file="none.yaml"), ["bridge.file = 'none.yaml'"]),
    "no such exoskeleton of the bridge": (lambda d: d["bridge"].update(exoskeleton="wings"), ["there is no wings"]),
    "no such device": (lambda d: d.update(exoskeleton="wings"), ["exo = 'wings'"]),
    "device that is a template": (lambda d: d.update(exoskeleton="exo_ul7"), ["template"]),
    "no such profile": (lambda d: d.update(drives={"profile": "steam"}), ["drives.profile = 'steam'", "nominal"]),
    "only in virtual time": (
        lambda d: (fault(kind="link_down")(d), d.update(mode="real_time")),
        ["faults.0.kind = 'link_down'", "only in virtual time"],
    ),
    "source faster than time": (lambda d: d.update(real_time={"factor": 2.0}), ["real_time.factor = 2.0"]),
}


@pytest.mark.parametrize("what", sorted(BAD))
def test_refused_with_file_key_and_rule(run, tmp_path, what):
    change, words = BAD[what]
    data = good()
    change(data)
    file = tmp_path / "bad.yaml"
    file.write_text(yaml.safe_dump(data), encoding="utf-8")
    done = run("rehearse", file, "--out", tmp_path / "out")
    assert done.code == 2, done.out + done.err
    for word in words:
        assert word in done.err
    assert ".yaml" in done.err or "exo" in done.err
    assert not (tmp_path / "out/rehearsal.json").exists()


def test_bad_configuration_is_named_with_its_line(run, tmp_path):
    data = good()
    text = (
        Path(data["bridge"]["file"])
        .read_text(encoding="utf-8")
        .replace("velocity_rad_per_s: 3.5", "velocity_rad_per_s: -1")
    )
    (tmp_path / "bridge.yaml").write_text(text, encoding="utf-8")
    data["bridge"]["file"] = "bridge.yaml"
    (tmp_path / "bad.yaml").write_text(yaml.safe_dump(data), encoding="utf-8")
    done = run("rehearse", tmp_path / "bad.yaml")
    assert done.code == 2
    for word in ("bridge.yaml", "line ", "velocity_rad_per_s", "-1"):
        assert word in done.err


@pytest.mark.parametrize("text", ["- a list", "name: [unclosed", ""])
def test_not_a_mapping(run, tmp_path, text):
    (tmp_path / "bad.yaml").write_text(text, encoding="utf-8")
    assert run("rehearse", tmp_path / "bad.yaml").code == 2


def test_folder_that_cannot_be_made(run, tmp_path):
    (tmp_path / "file").write_text("")
    done = run("rehearse", FOLDER / "reach_high.yaml", "--out", tmp_path / "file")
    assert done.code == 2
    assert "file" in done.err


def test_exit_status_follows_the_verdict(run, tmp_path):
    assert run("rehearse", FOLDER / "reach_high.yaml", "--out", tmp_path / "good").code == 0
    done = run("rehearse", FOLDER / "too_fast.yaml", "--out", tmp_path / "bad", "--json")
    assert done.code == 1
    assert done.json["verdict"] == "FAIL"
    assert (tmp_path / "bad/report.html").is_file()


def test_a_name_with_brackets_is_printed_as_it_is(run, tmp_path):
    file = tmp_path / "name.yaml"
    file.write_text(yaml.safe_dump(good() | {"name": "reach [bold]high[/x]"}), encoding="utf-8")
    done = run("rehearse", file, "--out", tmp_path / "[out]")
    assert done.code == 0, done.out + done.err
    assert "PASS  reach [bold]high[/x]" in done.out
    assert "[out]/report.html" in done.out
