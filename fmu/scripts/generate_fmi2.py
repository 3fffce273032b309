"""Writes the FMI 2.0 description from the FMI 3.0 one: same names, same value references.

usage: generate_fmi2.py modelDescription.xml OUTPUT.xml [SOURCE_FILE...]
"""

from __future__ import annotations

import sys
import xml.etree.ElementTree as ET
from pathlib import Path

from description import read_tree

ROOT_ATTRIBUTES = (
    "modelName", "description", "author", "version", "copyright", "license", "generationTool", "generationDateAndTime",
    "variableNamingConvention",
)  # fmt: skip
FLAGS = {
    "canHandleVariableCommunicationStepSize": "canHandleVariableCommunicationStepSize",
    "canGetAndSetFMUState": "canGetAndSetFMUstate",
    "canSerializeFMUState": "canSerializeFMUstate",
    "maxOutputDerivativeOrder": "maxOutputDerivativeOrder",
    "modelIdentifier": "modelIdentifier",
}
TYPES = {"Float64": "Real", "Enumeration": "Enumeration", "Boolean": "Boolean"}


def child(parent: ET.Element, path: str) -> ET.Element:
    """The child that must be there."""
    found = parent.find(path)
    if found is None:
        raise ValueError(f"no {path}")
    return found


def copy_attributes(source: ET.Element, target: ET.Element, names: tuple[str, ...]) -> None:
    """Copies the attributes that are present."""
    for name in names:
        if name in source.attrib:
            target.set(name, source.attrib[name])


def add_types(source: ET.Element, target: ET.Element) -> None:
    """EnumerationType -> SimpleType/Enumeration."""
    definitions = ET.SubElement(target, "TypeDefinitions")
    for enumeration in child(source, "TypeDefinitions"):
        simple = ET.SubElement(definitions, "SimpleType")
        copy_attributes(enumeration, simple, ("name", "description"))
        items = ET.SubElement(simple, "Enumeration")
        for item in enumeration:
            copy_attributes(item, ET.SubElement(items, "Item"), ("name", "value", "description"))


def add_variable(variable: ET.Element, target: ET.Element) -> None:
    """One typed element of FMI 3 -> ScalarVariable with a typed child."""
    scalar = ET.SubElement(target, "ScalarVariable")
    copy_attributes(variable, scalar, ("name", "valueReference", "description", "causality", "variability", "initial"))
    typed = ET.SubElement(scalar, TYPES[variable.tag])
    copy_attributes(variable, typed, ("declaredType", "unit", "displayUnit", "min", "max", "start"))


def add_structure(source: ET.Element, target: ET.Element) -> None:
    """Value references -> indices from 1, in ascending order."""
    index = {v.attrib["valueReference"]: k for k, v in enumerate(child(source, "ModelVariables"), start=1)}
    structure = ET.SubElement(target, "ModelStructure")
    for tag, group in (("Output", "Outputs"), ("InitialUnknown", "InitialUnknowns")):
        unknowns = ET.SubElement(structure, group)
        for entry in sorted(source.findall(f"ModelStructure/{tag}"), key=lambda e: index[e.attrib["valueReference"]]):
            known = sorted(index[reference] for reference in entry.attrib["dependencies"].split())
            ET.SubElement(
                unknowns,
                "Unknown",
                index=str(index[entry.attrib["valueReference"]]),
                dependencies=" ".join(map(str, known)),
            )


def convert(source: ET.Element, source_files: list[str]) -> ET.Element:
    """FMI 2.0 tree of an FMI 3.0 tree."""
    root = ET.Element("fmiModelDescription", fmiVersion="2.0", guid=source.attrib["instantiationToken"])
    copy_attributes(source, root, ROOT_ATTRIBUTES)
    simulation = ET.SubElement(root, "CoSimulation")
    for name, value in child(source, "CoSimulation").attrib.items():
        simulation.set(FLAGS[name], value)
    if source_files:
        files = ET.SubElement(simulation, "SourceFiles")
        for name in source_files:
            ET.SubElement(files, "File", name=name)
    root.append(child(source, "UnitDefinitions"))
    add_types(source, root)
    root.append(child(source, "LogCategories"))
    root.append(child(source, "DefaultExperiment"))
    variables = ET.SubElement(root, "ModelVariables")
    for variable in child(source, "ModelVariables"):
        add_variable(variable, variables)
    add_structure(source, root)
    return root


if __name__ == "__main__":
    tree = convert(read_tree(Path(sys.argv[1])), sys.argv[3:])
    ET.indent(tree)
    ET.ElementTree(tree).write(sys.argv[2], encoding="UTF-8", xml_declaration=True)
