"""The examples of docs/fmu.md run as they stand."""

import re
import subprocess
import sys

import fmu_driver
import pytest

EXAMPLES = re.findall(
    r"^```python\n(.*?)^```", (fmu_driver.ROOT / "docs/fmu.md").read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE
)


@pytest.mark.parametrize("number", range(len(EXAMPLES)))
def test_the_example_runs(number, build_folder, tmp_path):
    (tmp_path / "build").mkdir()
    (tmp_path / "build/fmu").symlink_to(build_folder)
    command = [sys.executable, "-W", "error::SyntaxWarning", "-c", EXAMPLES[number]]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_there_are_examples():
    assert len(EXAMPLES) == 2
