"""What the tests of rehearsals share: shipped scenarios, runs in virtual time, and the command line in this process."""

import copy
import sys
from pathlib import Path

import pytest
import yaml
from command_line import run as run
from glenoid.rehearse.run import rehearse
from glenoid.rehearse.scenario import parse_scenario

sys.path.insert(0, str(Path(__file__).parent))
FOLDER = Path(__file__).resolve().parents[2] / "host/rehearsals"


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
