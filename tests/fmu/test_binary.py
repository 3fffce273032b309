"""The archives and the libraries in them: what is exported, what is needed, what is not inside."""

import filecmp
import re
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ET
import zipfile
from pathlib import Path

import fmu_driver
import pytest

ROOT = fmu_driver.ROOT
HEADERS = ROOT / "fmu/headers"


def read(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def standard_functions(version):
    """Every function of the headers: some importers look for those of the other interface types too."""
    text = (HEADERS / f"fmi{version}/fmi{version}Functions.h").read_text(encoding="utf-8")
    return re.findall(rf"FMI{version}_Export\s+fmi{version}\w+TYPE\s+(fmi{version}\w+);", text)


def test_the_headers_declare_what_the_standards_name():
    """34 of FMI 2.0 for co-simulation and 10 for model exchange; 75 of FMI 3.0."""
    assert (len(standard_functions(2)), len(standard_functions(3))) == (44, 75)


@pytest.mark.parametrize("version", [2, 3])
def test_every_function_is_exported(archive, version):
    exported = set(read("nm", "-D", "--defined-only", archive.library_path).split())
    assert set(standard_functions(version)) <= exported


def test_nothing_else_is_exported(archive):
    symbols = [line.split()[-1] for line in read("nm", "-D", "--defined-only", archive.library_path).splitlines()]
    assert [s for s in symbols if not re.match(r"fmi[23][A-Z]", s)] == []


def test_only_the_c_library_is_needed(archive):
    needed = re.findall(r"\(NEEDED\).*\[(.*)\]", read("readelf", "-dW", archive.library_path))
    assert set(needed) <= {"libc.so.6", "libm.so.6", "libdl.so.2", "libpthread.so.0", "ld-linux-x86-64.so.2"}
    assert "not found" not in read("ldd", "-r", archive.library_path)


@pytest.mark.parametrize("name", ["sin", "cos", "acos", "atan2", "erf"])
def test_mathematical_functions_are_those_of_the_c_library(archive, name):
    """zig's run-time library has its own, which give other bits than the core gets elsewhere."""
    assert re.search(rf"^\s+U {name}(@|$)", read("nm", "-D", archive.library_path), re.MULTILINE)


def test_old_systems_can_load_it(archive, build_folder):
    if not (build_folder / "binaries").exists():
        pytest.skip("built without ziglang: the glibc floor is that of this machine")
    versions = re.findall(r"GLIBC_(\d+)\.(\d+)", read("objdump", "-T", archive.library_path))
    assert max((int(a), int(b)) for a, b in versions) <= (2, 17)


def test_no_path_of_the_build_is_inside(archive):
    data = archive.library_path.read_bytes()
    assert str(ROOT).encode() not in data
    assert re.findall(rb"/(?:home|root|tmp|build)/[\w./+-]{4,80}", data) == []


def test_loading_and_unloading_leave_no_trace(archive):
    dynamic = read("readelf", "-dlW", archive.library_path)
    for word in ("TEXTREL", "STATIC_TLS", "NODELETE", "RPATH", "RUNPATH"):
        assert word not in dynamic
    assert " u " not in read("nm", "-D", archive.library_path)  # GNU_UNIQUE keeps a library loaded


UNLOAD = """
import ctypes, pathlib, sys
sys.path.insert(0, sys.argv[1])
import fmu_driver
archive = fmu_driver.Archive(pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3]))
with fmu_driver.Instance(archive, logging=False, logger=False) as unit:
    unit.initialize().run(0, 0.25, 1 / 512)
handle = archive.library._handle
ctypes.CDLL(None).dlclose(ctypes.c_void_p(handle))
assert "Glenoid.so" not in pathlib.Path("/proc/self/maps").read_text()
"""


def test_the_process_ends_well_after_unloading(archive, tmp_path):
    """Destructors of static objects run when the library goes, not later."""
    command = [sys.executable, "-c", UNLOAD, str(Path(__file__).parent), str(archive.path), str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


def test_archive_entries_are_plain(archive):
    with zipfile.ZipFile(archive.path) as packed:
        assert packed.testzip() is None
        for entry in packed.infolist():
            assert entry.compress_type in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
            assert entry.extract_version <= 20
            assert entry.date_time == (1980, 1, 1, 0, 0, 0)
            entry.filename.encode("ascii")


@pytest.mark.parametrize(
    "name",
    ["documentation/index.html", "documentation/reach.svg", "documentation/licenses/license.txt",
     "documentation/licenses/eigen-MPL-2.0.txt", "documentation/licenses/fmi-headers-BSD-2-Clause.txt",
     "terminalsAndIcons/icon.png", "terminalsAndIcons/icon.svg", "extra/org.fmi-standard.fmi-ls-ref/Glenoid_out.csv"],
)  # fmt: skip
def test_archive_is_complete(archive, name):
    assert (archive.folder / name).stat().st_size > 100


def test_the_icon_is_a_picture(archive):
    data = (archive.folder / ("model.png" if archive.version == 2 else "terminalsAndIcons/icon.png")).read_bytes()
    assert data.startswith(b"\x89PNG\r\n\x1a\n")
    assert data[16:24] == (200).to_bytes(4, "big") * 2


def test_links_of_the_documentation_lead_somewhere(archive):
    page = (archive.folder / "documentation/index.html").read_text(encoding="utf-8")
    assert "@" not in re.sub(r"[\w.]+@[\w.]+", "", page)
    for target in re.findall(r'(?:href|src)="([^"]+)"', page):
        assert (archive.folder / "documentation" / target).exists(), target
    for name in archive.variables:
        assert f"<td>{name}</td>" in page


def test_the_same_input_packs_to_the_same_bytes(build_folder, tmp_path):
    arguments = build_folder / "package.args"
    command = [sys.executable, str(ROOT / "fmu/scripts/package.py"), f"@{arguments}", "--output", str(tmp_path)]
    subprocess.run(command, check=True)
    for name in fmu_driver.FILES.values():
        assert filecmp.cmp(build_folder / name, tmp_path / name, shallow=False), name


def test_both_archives_hold_the_same_sources(archives):
    two, three = (
        {p.relative_to(a.folder): p.read_bytes() for p in (a.folder / "sources").rglob("*.*")}
        for a in archives.values()
    )
    assert two == three
    listed = {file.attrib["name"] for file in archives["fmi2"].root.iter("File")}
    build = ET.parse(archives["fmi3"].folder / "sources/buildDescription.xml")
    assert listed == {file.attrib["name"] for file in build.iter("SourceFile")}


@pytest.mark.skipif(shutil.which("cmake") is None, reason="fmpy compile needs cmake")
def test_shipped_sources_compile_and_give_the_same_numbers(archives, tmp_path, monkeypatch):
    import fmpy.build

    archive = archives["fmi3"]
    folder = tmp_path / "sources only"
    shutil.copytree(archive.folder, folder)
    shutil.rmtree(folder / "binaries")
    build = tmp_path / "build"
    build.mkdir()
    monkeypatch.setenv("CMAKE_BUILD_PARALLEL_LEVEL", "2")
    fmpy.build.build_platform_binary(folder, build)
    (library,) = folder.glob("binaries/*/*.so")
    compiled = fmu_driver.Archive(archive.path, tmp_path / "again", library=library)
    with fmu_driver.Instance(archive) as a, fmu_driver.Instance(compiled) as b:
        assert a.initialize().run(0, 1.75, 1 / 64) == b.initialize().run(0, 1.75, 1 / 64)
