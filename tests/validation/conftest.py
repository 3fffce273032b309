"""Where the shared module of this folder is found, and the measured reaches."""

import json
import sys
from pathlib import Path
from typing import NamedTuple

import pytest

sys.path.insert(0, str(Path(__file__).parent))

from glenoid.cli import main
from made_movements import REACHES


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


@pytest.fixture(scope="session")
def reaches():
    if not REACHES.is_file():
        pytest.skip(f"no measured reaches at {REACHES}: set GLENOID_REACHES")
    return REACHES
