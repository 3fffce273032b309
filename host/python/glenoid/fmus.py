"""Where the FMUs are, and what they are."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

from glenoid.inputs import InputError

FILES = {"3": "Glenoid.fmu", "2": "Glenoid_fmi2.fmu"}


def fmu_folder() -> Path:
    """Folder of the FMUs: GLENOID_FMU_DIR, or fmu/ of the build tree that this package runs from."""
    given = os.environ.get("GLENOID_FMU_DIR")
    return Path(given) if given else Path(__file__).absolute().parents[2] / "fmu"


def fmu_path(version: str) -> Path:
    """Path of the FMU for FMI `version` ("2" or "3"). InputError if it is not there."""
    path = fmu_folder() / FILES[version]
    if not path.is_file():
        raise InputError(f"{path}: no such FMU; build it with `make build` or set GLENOID_FMU_DIR")
    return path


def sha256(path: Path) -> str:
    """Hash of a file, hexadecimal."""
    return hashlib.sha256(path.read_bytes()).hexdigest()
