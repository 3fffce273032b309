"""The examples of docs/fmu.md run as they stand."""

import html
import re
import subprocess
import sys
import xml.etree.ElementTree as ET
import zipfile

import fmu_driver
import pytest

DESCRIPTION = ET.parse(fmu_driver.ROOT / "modelDescription.xml").getroot()
TABLES = (fmu_driver.ROOT / "docs/fmu.md").read_text(encoding="utf-8").partition("## Variables")[2]
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


def test_the_page_in_the_archive_says_what_every_variable_and_item_means(archive):
    with zipfile.ZipFile(archive.path) as packed:
        page = html.unescape(packed.read("documentation/index.html").decode())
    assert "@" not in page
    for variable in DESCRIPTION.iterfind("ModelVariables/*"):
        assert f"<td>{variable.attrib['name']}</td><td>{variable.attrib['valueReference']}</td>" in page
        assert f"<td>{variable.attrib['description']}</td>" in page
    for item in DESCRIPTION.iter("Item"):
        cells = (item.attrib["value"], item.attrib["name"], item.attrib["description"])
        assert "".join(f"<td>{cell}</td>" for cell in cells) in page


def test_the_table_of_the_documentation_is_that_of_the_description():
    for item in DESCRIPTION.iter("Item"):
        assert f"| {item.attrib['value']} | `{item.attrib['name']}` | {item.attrib['description']} |" in TABLES
    for variable in DESCRIPTION.iterfind("ModelVariables/*"):
        name = variable.attrib["name"].partition("[")[0]
        row = next(line for line in TABLES.splitlines() if line.startswith(f"| `{name}`"))
        cells = [cell.strip() for cell in row.strip("|").split("|")]
        first, _, last = cells[1].partition(" .. ")
        assert int(variable.attrib["valueReference"]) in range(int(first), int(last or first) + 1), name
        assert cells[2].startswith(variable.attrib["causality"])
        assert variable.get("unit", "") in cells[3].split(", ")
