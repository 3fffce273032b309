"""The repository as a whole: length of files, links, labels, and what must not be in it."""

import re

import pytest
from repository import ROOT, TEXT, files_of, name_of

AIM_LINES, MOST_LINES = 200, 400
# Files that may be longer, with the reason.
LONG_FILES: dict[str, str] = {
    "modelDescription.xml": "the one table of variables",
    "cmake/requirements.txt": "a lock file",
    "core/src/motion.cpp": "the facade: accepting, sampling and stopping share one state",
    "tests/core/motion_test.cpp": "laws of the facade, one a test",
    "tests/core/exo_motion_test.cpp": "laws of the device along whole motions, one a test",
    "tests/core/exoskeleton_test.cpp": "laws of the transformation and of the girdle, one a test",
    "tests/core/geodesic_test.cpp": "laws of the solver, one a test",
    "tests/bus/bridge_fault_test.cpp": "one fault a test",
}
SOURCES = (".cpp", ".hpp", ".h", ".py", ".sh", ".cmake", ".txt", ".xml")
ROOT_ENTRIES = {
    "CMakeLists.txt",
    "core",
    "fmu",
    "lcm_types",
    "host",
    "tests",
    "modelDescription.xml",
    "README.md",
    "LICENSE",
    "CHANGELOG.md",
    "CONTRIBUTING.md",
    "Makefile",
    "CMakePresets.json",
    "pyproject.toml",
    ".clang-format",
    ".ci",
    "cmake",
    "docs",
    ".git",
    ".gitignore",
    "build",
}
# Paths of somebody's machine, and references to a tracker that a reader of the repository does not have.
UNWANTED = re.compile(r"(?<![\w.}/$])/(work|home|root|Users)/\w|\b(TODO|FIXME|XXX)\b|\bissue #?\d", re.IGNORECASE)
LABEL = re.compile(r"\b([A-Z])(\d{1,2})(?:-\1(\d{1,2}))?\b")
LINK = re.compile(r"\]\(([^)\s]+)")
NAMED_FILE = re.compile(r"`((?:core|fmu|host|lcm_types|tests|docs|cmake)/[\w./-]+)`")


def is_official(path):
    return "fmu/headers/" in name_of(path)


def test_no_source_file_is_longer_than_it_may_be(capsys):
    lengths = {
        name_of(path): len(path.read_text(encoding="utf-8").splitlines())
        for path in files_of(".", *SOURCES)
        if not is_official(path)
    }
    for name, lines in sorted(lengths.items(), key=lambda item: -item[1]):
        if lines > AIM_LINES:
            print(f"{lines:5d} lines: {name}")
    too_long = {name: lines for name, lines in lengths.items() if lines > MOST_LINES and name not in LONG_FILES}
    assert not too_long


def test_root_holds_only_what_a_person_expects():
    hidden_caches = {entry.name for entry in ROOT.iterdir() if entry.name.endswith("_cache")} | {".hypothesis"}
    assert {entry.name for entry in ROOT.iterdir()} - hidden_caches <= ROOT_ENTRIES


def test_no_machine_paths_or_loose_ends():
    bad = []
    for path in files_of("."):
        if (path.suffix in TEXT or path.name in ("Makefile", "run")) and path.name != "test_repository.py":
            lines = path.read_text(encoding="utf-8").splitlines()
            bad += [f"{name_of(path)}:{k}: {line.strip()}" for k, line in enumerate(lines, 1) if UNWANTED.search(line)]
    assert not bad


def test_no_measurement_data_is_in_the_repository():
    assert not [name_of(p) for p in files_of(".") if p.suffix in {".npz", ".c3d", ".trc", ".mat", ".parquet", ".h5"}]


def test_the_measured_example_carries_its_licence():
    licence = (ROOT / "host/examples/LICENSE_UE_ADL").read_text(encoding="utf-8")
    assert "MIT License" in licence
    assert "MiaH-kin" in licence
    example = (ROOT / "host/examples/reach_to_head.yaml").read_text(encoding="utf-8")
    assert "UE_ADLdatabase, San Francisco State University" in example


def test_changelog_has_a_place_for_the_next_change():
    assert "\n## Unreleased\n" in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")


def test_version_is_written_once():
    version = re.search(r"project\(glenoid VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8"))[1]
    written = [name_of(p) for p in files_of(".", ".py", ".toml", ".cpp", ".hpp") if f'"{version}"' in p.read_text()]
    assert not written


def labels_in(comment):
    """Every label of a comment, ranges written out: E1-E3 is E1, E2, E3."""
    for letter, first, last in LABEL.findall(comment):
        for number in range(int(first), int(last or first) + 1):
            yield f"{letter}{number}"


@pytest.mark.parametrize("header", files_of("core/include", ".hpp", ".h"), ids=lambda path: path.name)
def test_every_equation_label_in_a_header_exists(header):
    equations = (ROOT / "docs/equations.md").read_text(encoding="utf-8")
    known = set(re.findall(r"\*\*([A-Z]\d+)\*\*", equations))
    comments = re.findall(r"//[/!]*<?(.*)", header.read_text(encoding="utf-8"))
    cited = {label for comment in comments for label in labels_in(comment)}
    assert cited <= known


DOCUMENTS = files_of(".", ".md")


def anchors_of(document):
    """What a link may name after #: the headings as web pages of repositories write them."""
    headings = re.findall(r"^#+ (.*)$", document.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("document", DOCUMENTS, ids=name_of)
def test_links_resolve(document):
    bad = []
    for target in LINK.findall(document.read_text(encoding="utf-8")):
        name, _, anchor = target.partition("#")
        if "://" in target or target.startswith("mailto:"):
            continue
        path = document.parent / name if name else document
        if not path.exists() or (anchor and anchor not in anchors_of(path)):
            bad.append(target)
    assert not bad


@pytest.mark.parametrize("document", DOCUMENTS, ids=name_of)
def test_files_that_a_document_names_exist(document):
    named = set(NAMED_FILE.findall(document.read_text(encoding="utf-8")))
    assert not {name for name in named if not (ROOT / name).exists()}


def test_every_document_is_reached_from_the_readme():
    reached, open_ends = set(), [ROOT / "README.md"]
    while open_ends:
        document = open_ends.pop()
        reached.add(document)
        targets = {(document.parent / t.partition("#")[0]).resolve() for t in LINK.findall(document.read_text("utf-8"))}
        open_ends += [t for t in targets if t.suffix == ".md" and t.is_file() and t not in reached]
    assert not {name_of(d) for d in files_of("docs", ".md") if d not in reached}
