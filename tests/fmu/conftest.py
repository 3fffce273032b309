"""Archives under test: GLENOID_BUILD_DIR/fmu (default build/fmu), each unpacked once."""

import importlib.util
import os
import random
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ.get("GLENOID_BUILD_DIR", ROOT / "build"))
FILES = {"fmi2": "Glenoid_fmi2.fmu", "fmi3": "Glenoid.fmu"}
SEED = int(os.environ.get("GLENOID_TEST_SEED", "20261122"))


def load(name):
    """A module beside this file or in fmu/scripts, without a package."""
    for folder in (Path(__file__).parent, ROOT / "fmu/scripts"):
        if (folder / f"{name}.py").exists():
            specification = importlib.util.spec_from_file_location(name, folder / f"{name}.py")
            module = importlib.util.module_from_spec(specification)
            specification.loader.exec_module(module)
            return module
    raise ModuleNotFoundError(name)


driver = load("driver")


def pytest_report_header():
    return f"FMUs: {BUILD / 'fmu'}, seed {SEED} (GLENOID_TEST_SEED)"


@pytest.fixture(scope="session")
def build_folder():
    return BUILD / "fmu"


@pytest.fixture(scope="session")
def archives(tmp_path_factory, build_folder):
    return {
        key: driver.Archive(build_folder / name, tmp_path_factory.mktemp(f"unpacked {key}")) for key, name in FILES.items()
    }


@pytest.fixture(scope="session", params=list(FILES))
def archive(request, archives):
    """Each archive in turn."""
    return archives[request.param]


@pytest.fixture
def new(archive):
    """Makes instances of the archive and frees them at the end of the test."""
    made = []

    def make(**options):
        made.append(driver.Instance(archive, **options))
        return made[-1]

    yield make
    for instance in made:
        instance.free()


@pytest.fixture
def rng():
    return random.Random(SEED)


@pytest.fixture(scope="session")
def core():
    """The Python module over the core."""
    return pytest.importorskip("glenoid._core", reason="the Python module glenoid is not installed")
