"""Fixtures: the archives under test, each unpacked once, and instances of them."""

import random
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))
import fmu_driver


def pytest_report_header():
    return f"FMUs: {fmu_driver.BUILD / 'fmu'}, seed {fmu_driver.SEED} (GLENOID_TEST_SEED)"


@pytest.fixture(scope="session")
def build_folder():
    return fmu_driver.BUILD / "fmu"


@pytest.fixture(scope="session")
def archives(tmp_path_factory, build_folder):
    return {
        key: fmu_driver.Archive(build_folder / name, tmp_path_factory.mktemp(f"unpacked {key}"))
        for key, name in fmu_driver.FILES.items()
    }


@pytest.fixture(scope="session", params=list(fmu_driver.FILES))
def archive(request, archives):
    """Each archive in turn."""
    return archives[request.param]


@pytest.fixture
def new(archive):
    """Makes instances of the archive and frees them at the end of the test."""
    made = []

    def make(**options):
        made.append(fmu_driver.Instance(archive, **options))
        return made[-1]

    yield make
    for instance in made:
        instance.free()


@pytest.fixture
def rng():
    return random.Random(fmu_driver.SEED)


@pytest.fixture(scope="session")
def core():
    """The Python module over the core."""
    return pytest.importorskip("glenoid._core", reason="the Python module glenoid is not installed")
