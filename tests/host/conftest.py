"""What the host tests share: the command line in this process, plain tasks, and the random source."""

import os
import sys
from pathlib import Path

import hypothesis
import pytest
from command_line import run as run
from glenoid.inputs import ReachInput

sys.path.insert(0, str(Path(__file__).parent))

# GLENOID_TEST_COUNT cases per law; derandomised unless GLENOID_TEST_SEED asks for others.
hypothesis.settings.register_profile(
    "glenoid",
    max_examples=int(os.environ.get("GLENOID_TEST_COUNT", "40")),
    derandomize="GLENOID_TEST_SEED" not in os.environ,
    deadline=None,
    database=None,
)
hypothesis.settings.load_profile("glenoid")


@pytest.fixture(scope="session")
def plain_reach():
    return ReachInput(start_q_deg=(15, -30, 30, 60), target_m=(0.20, 0.42, 0.25))


def pytest_report_header():
    return f"hypothesis: {hypothesis.settings().max_examples} examples a law"
