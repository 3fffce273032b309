"""Where the shared module of this folder is found, and the measured reaches."""

import sys
from pathlib import Path

import pytest
from command_line import run as run

sys.path.insert(0, str(Path(__file__).parent))

from made_movements import REACHES


@pytest.fixture(scope="session")
def reaches():
    if not REACHES.is_file():
        pytest.skip(f"no measured reaches at {REACHES}: set GLENOID_REACHES")
    return REACHES
