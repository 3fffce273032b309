"""The command line of `glenoid` in the process of the tests; a conftest imports `run` to have the fixture."""

import json
import sys
from typing import NamedTuple

import pytest
from glenoid.cli import main


class Outcome(NamedTuple):
    """Exit status and what was printed."""

    code: int
    out: str
    err: str

    @property
    def json(self):
        """Standard output as strict JSON."""
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
