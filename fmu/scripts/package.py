"""Packs Glenoid.fmu (FMI 3.0) and Glenoid_fmi2.fmu (FMI 2.0); the same input gives the same bytes.

Called by fmu/CMakeLists.txt; --help lists the arguments.
"""

from __future__ import annotations

import argparse
import html
import math
import re
import subprocess
import xml.etree.ElementTree as ET
import zipfile
from pathlib import Path

from description import Variable, read_tree, read_variables
from draw_icon import icon_png
from generate_fmi2 import convert
from reference import csv_text, picture_svg, run

Files = dict[str, bytes]
# Names of FMI 2.0; the standard has none for aarch64.
FMI2_PLATFORMS = {"x86_64-linux": "linux64", "x86_64-windows": "win64", "x86_64-darwin": "darwin64"}


def row_of(*cells: str) -> str:
    """A row of a table in index.html."""
    return "<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in cells) + "</tr>"


def start_of(variable: Variable, degrees: bool) -> str:
    """Start value as people read it."""
    if variable.start is None:
        return ""
    if variable.tag == "Boolean":
        return ("false", "true")[int(variable.start)]
    shown = degrees and variable.start != 0.0 and abs(variable.start) < 1e9
    return f"{variable.start:.6g}" + (f" ({math.degrees(variable.start):.3g} deg)" if shown else "")


def variable_rows(root: ET.Element) -> str:
    """Rows of the table of variables in index.html."""
    rows = []
    for element, v in zip(root.iterfind("ModelVariables/*"), read_variables(root), strict=True):
        limits = "" if v.tag == "Boolean" or v.minimum == float("-inf") else f"{v.minimum:.6g} .. {v.maximum:.6g}"
        kind = element.get("declaredType", v.unit)
        start = start_of(v, element.get("displayUnit") == "deg")
        rows.append(row_of(v.name, str(v.reference), v.causality, kind, start, limits, v.description))
    return "\n".join(rows)


def enumeration_rows(root: ET.Element) -> str:
    """Rows of the table of enumerations in index.html."""
    return "\n".join(
        row_of(kind.attrib["name"], item.attrib["value"], item.attrib["name"], item.get("description", ""))
        for kind in root.iter("EnumerationType")
        for item in kind
    )


def eigen_files(arguments: argparse.Namespace, include: list[str]) -> Files:
    """Every file of the Eigen modules that the sources use, for all processors."""
    command = [
        arguments.compiler,
        "-std=c++20",
        "-M",
        *include,
        "-I",
        str(arguments.eigen),
        *map(str, arguments.sources),
    ]
    listing = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    used = {Path(name).resolve() for name in re.findall(r"[^\s\\:]+", listing)}
    eigen = arguments.eigen.resolve()
    relative = {path.relative_to(eigen) for path in used if path.is_relative_to(eigen)}
    modules = {path.parts[2] for path in relative if path.parts[:2] == ("Eigen", "src")}
    found = {path for module in modules for path in (eigen / "Eigen/src" / module).rglob("*.h")}
    found |= {eigen / path for path in relative}
    return {f"sources/{path.relative_to(eigen).as_posix()}": path.read_bytes() for path in found}


def build_description(names: list[str]) -> bytes:
    """sources/buildDescription.xml: C++20, one include directory, function names without prefix."""
    root = ET.Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = ET.SubElement(
        root, "BuildConfiguration", modelIdentifier="Glenoid", description="Any C++20 compiler"
    )
    files = ET.SubElement(
        configuration, "SourceFileSet", language="C++20", compiler="gcc", compilerOptions="-O3 -ffp-contract=off"
    )
    for name in names:
        ET.SubElement(files, "SourceFile", name=name)
    ET.SubElement(files, "PreprocessorDefinition", name="FMI3_OVERRIDE_FUNCTION_PREFIX")
    ET.SubElement(files, "PreprocessorDefinition", name="NDEBUG")
    ET.SubElement(files, "IncludeDirectory", name=".")
    ET.indent(root)
    return b'<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(root) + b"\n"


def source_files(arguments: argparse.Namespace) -> tuple[Files, list[str]]:
    """Contents of sources/, and the names of the files to compile."""
    root: Path = arguments.root
    files: Files = {}
    names = []
    for source in arguments.sources:
        folder = "core" if source.is_relative_to(root / "core") else "fmu"
        names.append(f"{folder}/{source.name}")
        files[f"sources/{names[-1]}"] = source.read_bytes()
    for folder, pattern in (
        ("core", "core/src/*.hpp"),
        ("fmu", "fmu/src/*.hpp"),
        ("glenoid", "core/include/glenoid/*.hpp"),
    ):
        files |= {f"sources/{folder}/{path.name}": path.read_bytes() for path in root.glob(pattern)}
    for version in ("fmi2", "fmi3"):
        files |= {f"sources/{version}/{p.name}": p.read_bytes() for p in (root / "fmu/headers" / version).glob("*.h")}
    files["sources/fmu/variable_table.hpp"] = arguments.table.read_bytes()
    include = [
        f"-I{p}" for p in (root / "core/include", root / "fmu/headers", root / "fmu/src", arguments.table.parent)
    ]
    files |= eigen_files(arguments, include)
    files["sources/buildDescription.xml"] = build_description(names)
    return files, names


def common_files(arguments: argparse.Namespace, description: ET.Element) -> Files:
    """What both archives hold besides description, binaries and sources."""
    package = arguments.root / "fmu/package"
    rows = run(arguments.reference_library, description)
    page = (package / "index.html").read_text(encoding="utf-8")
    page = page.replace("@VERSION@", arguments.version).replace("@VARIABLES@", variable_rows(description))
    page = page.replace("@ENUMERATIONS@", enumeration_rows(description))
    reference = "extra/org.fmi-standard.fmi-ls-ref"
    files = {
        "documentation/index.html": page.encode(),
        "documentation/reach.svg": picture_svg(rows).encode(),
        "documentation/licenses/license.txt": (arguments.root / "LICENSE").read_bytes(),
        "terminalsAndIcons/terminalsAndIcons.xml": (package / "terminalsAndIcons.xml").read_bytes(),
        "terminalsAndIcons/icon.png": icon_png(),
        "terminalsAndIcons/icon.svg": (package / "icon.svg").read_bytes(),
        f"{reference}/fmi-ls-manifest.xml": (package / "fmi-ls-manifest.xml").read_bytes(),
        f"{reference}/Glenoid_out.csv": csv_text(rows).encode(),
    }
    if arguments.resources is not None:
        sets = arguments.resources.rglob("*.ssv")
        files |= {f"resources/{path.relative_to(arguments.resources).as_posix()}": path.read_bytes() for path in sets}
    for licence in (package / "licenses").glob("*.txt"):
        files[f"documentation/licenses/{licence.name}"] = licence.read_bytes()
    return files


def write_archive(path: Path, files: Files) -> None:
    """ZIP with sorted entries and a fixed time stamp; appears whole or not at all."""
    partial = path.with_suffix(".partial")
    with zipfile.ZipFile(partial, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name in sorted(files, key=lambda n: (n != "modelDescription.xml", n)):
            entry = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = (0o755 if name.startswith("binaries/") else 0o644) << 16
            entry.create_system = 3
            archive.writestr(entry, files[name])
    partial.replace(path)


def parse_arguments() -> argparse.Namespace:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, fromfile_prefix_chars="@")
    parser.add_argument("--root", type=Path, required=True, help="source tree")
    parser.add_argument("--version", required=True, help="must be the version in modelDescription.xml")
    parser.add_argument("--output", type=Path, required=True, help="folder of the archives")
    parser.add_argument("--table", type=Path, required=True, help="variable_table.hpp")
    parser.add_argument("--eigen", type=Path, required=True, help="include directory that holds Eigen/")
    parser.add_argument("--compiler", required=True, help="lists the Eigen headers in use")
    parser.add_argument("--reference-library", type=Path, required=True, help="library that runs here")
    parser.add_argument("--library", nargs=2, action="append", required=True, metavar=("PLATFORM", "FILE"))
    parser.add_argument("--resources", type=Path, help="folder of parameter sets (*.ssv)")
    parser.add_argument("--sources", nargs="+", type=Path, required=True)
    return parser.parse_args()


def main() -> None:
    """Writes both archives.

    Raises:
        ValueError: modelDescription.xml has another version than the project.
    """
    arguments = parse_arguments()
    description_path = arguments.root / "modelDescription.xml"
    description = read_tree(description_path)
    if description.get("version") != arguments.version:
        raise ValueError(f"modelDescription.xml: version must be {arguments.version}")
    files = common_files(arguments, description)
    sources, names = source_files(arguments)
    libraries = {platform: Path(file) for platform, file in arguments.library}

    archive3 = {"modelDescription.xml": description_path.read_bytes(), **files, **sources}
    archive2 = {"model.png": files["terminalsAndIcons/icon.png"], **files, **sources}
    tree = convert(description, names)
    ET.indent(tree)
    archive2["modelDescription.xml"] = b'<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(tree) + b"\n"
    for platform, file in libraries.items():
        archive3[f"binaries/{platform}/{file.name}"] = file.read_bytes()
        if platform in FMI2_PLATFORMS:
            archive2[f"binaries/{FMI2_PLATFORMS[platform]}/{file.name}"] = file.read_bytes()
    write_archive(arguments.output / "Glenoid.fmu", archive3)
    write_archive(arguments.output / "Glenoid_fmi2.fmu", archive2)


if __name__ == "__main__":
    main()
