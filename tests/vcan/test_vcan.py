"""Runs the suite of tests/vcan/inside on a real Linux vcan0 and shows each of its tests as one here.

Natively where the kernel has vcan, else in a user-mode Linux (tests/support/with_vcan.py). Where neither works all of them
are skipped, with the reasons.
"""

import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

HERE = Path(__file__).resolve().parent
RUNNER = HERE.parent / "support/with_vcan.py"
LIMIT_S = 600
NO_WAY = 125
NAMES = sorted(
    f"{file.stem}::{line.split('(')[0].removeprefix('def ')}"
    for file in (HERE / "inside").glob("test_*.py")
    for line in file.read_text(encoding="utf-8").splitlines()
    if line.startswith("def test_")
)


@pytest.fixture(scope="session")
def outcomes(tmp_path_factory):
    """Outcome and text of every test, from one start of the machine."""
    directory = tmp_path_factory.mktemp("vcan")
    report = directory / "inside.xml"
    inner = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--import-mode=importlib"]
    inner += [f"--junitxml={report}", f"--basetemp={directory / 'inside'}", str(HERE / "inside")]
    command = [sys.executable, str(RUNNER), "--echo", "--timeout", str(LIMIT_S), "--", *inner]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode == NO_WAY:
        pytest.skip(done.stderr.strip())
    if not report.is_file():
        pytest.fail(f"exit status {done.returncode}\n{done.stdout}\n{done.stderr}")
    results = {}
    for case in ElementTree.parse(report).getroot().iter("testcase"):
        name = f"{case.get('classname').rsplit('.', 1)[-1]}::{case.get('name').split('[')[0]}"
        trouble = next((child for child in case if child.tag in ("failure", "error", "skipped")), None)
        if trouble is not None:
            results[name] = trouble.tag, trouble.text or trouble.get("message")
        else:
            results.setdefault(name, ("passed", ""))  # of several cases the one that did not pass counts
    return results


@pytest.mark.parametrize("name", NAMES)
def test_on_vcan0(outcomes, name):
    outcome, text = outcomes.get(name, ("error", "was not run"))
    if outcome == "skipped":
        pytest.skip(text)
    if outcome != "passed":
        pytest.fail(text, pytrace=False)
