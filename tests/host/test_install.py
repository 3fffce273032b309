"""`pip install .`: the metadata that pip asks for first, and what is said on a machine that lacks something.

The whole of it takes minutes; docs/install.md has the commands.
"""

import os
import shutil
import subprocess
import sys

import pytest
from places import ROOT

METADATA = """
import sys
from scikit_build_core.build import prepare_metadata_for_build_wheel
print(prepare_metadata_for_build_wheel(sys.argv[1]))
"""


def test_metadata_can_be_made(tmp_path):
    pytest.importorskip("scikit_build_core")
    done = subprocess.run(
        [sys.executable, "-c", METADATA, tmp_path], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    folder = tmp_path / done.stdout.split()[-1]
    text = (folder / "METADATA").read_text(encoding="utf-8")
    assert "Name: glenoid" in text
    assert "License-File: LICENSE" in text
    assert (folder / "licenses/LICENSE").read_bytes() == (ROOT / "LICENSE").read_bytes()
    assert "glenoid = glenoid.cli:main" in (folder / "entry_points.txt").read_text(encoding="utf-8")


@pytest.mark.skipif(shutil.which("cmake") is None, reason="no cmake on PATH")
def test_everything_that_the_machine_lacks_is_named_at_once(tmp_path):
    done = subprocess.run(
        ["cmake", "-S", ROOT, "-B", tmp_path, "-DGLENOID_BUILD_FMU=OFF", "-DGLENOID_BUILD_TESTS=OFF",
         "-DCMAKE_DISABLE_FIND_PACKAGE_Eigen3=ON", "-DCMAKE_DISABLE_FIND_PACKAGE_yaml-cpp=ON"],
        capture_output=True, text=True, check=False, env=os.environ | {"CXXFLAGS": "", "CFLAGS": ""},
    )  # fmt: skip
    assert done.returncode != 0
    message = " ".join(done.stderr.split())
    for words in (
        "Eigen 3.4 (Debian: libeigen3-dev)",
        "yaml-cpp (Debian: libyaml-cpp-dev)",
        "apt-get install libeigen3",
    ):
        assert words in message
    assert "libsundials-dev" not in message
