"""What the tests of rehearsals share: shipped scenarios, runs in virtual time, and the command line in this process."""

import copy
import json
import sys
from pathlib import Path
from typing import NamedTuple

import pytest
import yaml
from glenoid.cli import main
from glenoid.rehearse.run import rehearse
from glenoid.rehearse.scenario import parse_scenario

sys.path.insert(0, str(Path(__file__).parent))
FOLDER = Path(__file__).resolve().parents[2] / "host/rehearsals"


class Outcome(NamedTuple):
    code: int
    out: str
    err: str

    @property
    def json(self):
        return json.loads(self.out, parse_constant=lambda text: pytest.fail(f"{text} is no JSON"))


@pytest.fixture
def run(capsys, monkeypatch):
    """Runs `glenoid ARGUMENTS` and returns exit status and output."""

    def call(*arguments):
        monkeypatch.setattr(sys, "argv", ["glenoid", *map(str, arguments)])
        capsys.readouterr()
        try:
            code = main()
        except SystemExit as stop:
            code = stop.code or 0
        out, err = capsys.readouterr()
        return Outcome(code, out, err)

    return call


@pytest.fixture
def scenario_of():
    """A shipped scenario with some of its keys replaced; a function takes the plain data and may change it."""

    def make(name, change=lambda data: None):
        path = FOLDER / f"{name}.yaml"
        data = copy.deepcopy(yaml.safe_load(path.read_text(encoding="utf-8")))
        change(data)
        return parse_scenario(data, path)

    return make


@pytest.fixture(scope="session")
def good_folder(tmp_path_factory):
    """The folder of the good rehearsal."""
    path = FOLDER / "reach_high.yaml"
    folder = tmp_path_factory.mktemp("good")
    rehearse(parse_scenario(yaml.safe_load(path.read_text(encoding="utf-8")), path), folder)
    return folder
