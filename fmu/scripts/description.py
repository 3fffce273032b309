"""Reads modelDescription.xml (FMI 3.0), the one hand-kept list of variables."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path

VARIABLE_TAGS = ("Float64", "Enumeration", "Boolean")


@dataclass(frozen=True)
class Variable:
    """One scalar variable; numbers in the unit of the variable, Booleans as 0 and 1."""

    name: str
    reference: int
    tag: str
    causality: str
    variability: str
    description: str
    unit: str
    start: float | None
    minimum: float
    maximum: float


def _number(text: str) -> float:
    return {"true": 1.0, "false": 0.0}[text] if text in ("true", "false") else float(text)


def read_variable(element: ET.Element) -> Variable:
    """Converts one element of ModelVariables.

    Raises:
        ValueError: the element is of a type that the FMU does not use, or an attribute is missing.
    """
    if element.tag not in VARIABLE_TAGS:
        raise ValueError(f"{element.get('name')}: type {element.tag} is not one of {VARIABLE_TAGS}")
    start = element.get("start")
    bounds = (0.0, 1.0) if element.tag == "Boolean" else (-math.inf, math.inf)
    required = ("name", "valueReference", "causality", "variability", "description")
    missing = [key for key in required if not element.get(key)]
    if missing:
        raise ValueError(f"{element.get('name')}: no {', '.join(missing)}")
    return Variable(
        name=element.attrib["name"],
        reference=int(element.attrib["valueReference"]),
        tag=element.tag,
        causality=element.attrib["causality"],
        variability=element.attrib["variability"],
        description=element.attrib["description"],
        unit=element.get("unit", ""),
        start=None if start is None else _number(start),
        minimum=float(element.get("min", bounds[0])),
        maximum=float(element.get("max", bounds[1])),
    )


def read_tree(path: Path) -> ET.Element:
    """Root element of a description."""
    return ET.parse(path).getroot()


def read_variables(root: ET.Element) -> list[Variable]:
    """All variables in the order of the file.

    Raises:
        ValueError: a name or value reference occurs twice, or read_variable refuses one.
    """
    container = root.find("ModelVariables")
    if container is None:
        raise ValueError("no ModelVariables")
    variables = [read_variable(element) for element in container]
    for kind, keys in (("name", [v.name for v in variables]), ("reference", [v.reference for v in variables])):
        if len(set(keys)) != len(keys):
            raise ValueError(f"a {kind} occurs twice")
    return variables
