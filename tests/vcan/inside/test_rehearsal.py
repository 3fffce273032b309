"""`glenoid rehearse` in real time with its programs on vcan0."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from attempts import first_that
from glenoid.fmus import fmu_path
from glenoid.inputs import InputError

ROOT = Path(__file__).resolve().parents[3]
REHEARSALS = ROOT / "host/rehearsals"
RATE_HZ = 50  # what a user-mode Linux on a busy machine holds; a kernel with CAN of its own holds 500
PATIENCE_S = 120.0


@pytest.fixture
def scenario(bridge_data, patient, link, tmp_path):
    """The good rehearsal in real time on this interface, at its rate."""
    data = yaml.safe_load((REHEARSALS / "reach_high_real_time.yaml").read_text(encoding="utf-8"))
    (tmp_path / "bridge_of_rehearsal.yaml").write_text(yaml.safe_dump(bridge_data), encoding="utf-8")
    data["subject"] = str((REHEARSALS / data["subject"]).resolve())
    data["bridge"] = {"file": "bridge_of_rehearsal.yaml"}
    data["drives"] = {"profile": str(patient)}
    data["movements"] = [{"activity": "reach_high", "duration_s": 4.0, "pause_s": 0.3}]
    data["real_time"] = {"factor": 1.0, "bus": f"socketcan:{link.name}", "priority": 0}
    # Two setpoints a period ahead and 20 ms of interpolation are what the drives lag behind here.
    data["checks"] |= {"tracking_error": {"limit": 0.1}, "misalignment": "warn", "arrival": {"limit": 0.02}}
    path = tmp_path / "rehearsal.yaml"
    path.write_text(yaml.safe_dump(data), encoding="utf-8")
    return path


def test_a_rehearsal_in_real_time_passes_on_vcan0(scenario, tmp_path):
    try:
        fmu_path("3")
    except InputError as error:
        pytest.skip(str(error))
    out = tmp_path / "report"
    words = [sys.executable, "-m", "glenoid", "rehearse", str(scenario), "--out", str(out), "--json"]
    done = first_that(
        lambda: subprocess.run(words, capture_output=True, text=True, check=False, timeout=PATIENCE_S),
        lambda done: done.returncode == 0,
        lambda done: done.stdout + done.stderr,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    facts = json.loads((out / "rehearsal.json").read_text())
    assert facts["verdict"] == "PASS"
    assert len(facts["drives"]) == 6
    assert (out / "report.html").is_file()
    syncs = [line for line in (out / "candump.log").read_text().splitlines() if " 080#" in line]
    assert len(syncs) > 0.9 * 4.0 * RATE_HZ
