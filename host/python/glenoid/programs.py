"""The programs in C++: where they are, and running one in place of this process."""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path
from typing import NoReturn

from glenoid.inputs import InputError


def program(name: str) -> Path:
    """Path of a program: in the build tree this package runs from (build/bin), else on PATH.

    Raises:
        InputError: there is none.
    """
    built = Path(__file__).absolute().parents[2] / "bin" / name
    found = str(built) if built.is_file() else shutil.which(name)
    if found is None:
        raise InputError(f"no program {name}: build it (make) or put it on PATH")
    return Path(found)


def become(name: str, arguments: list[str]) -> NoReturn:
    """Replaces this process by a program."""
    path = program(name)
    sys.stdout.flush()
    os.execv(path, [name, *arguments])
