"""Parameter sets of the SSP standard (SystemStructureParameterValues 1.0) for subjects and devices.

`python -m glenoid.ssv --out FOLDER` writes one per shipped subject and complete device; the build puts them into the FMU's
resources. `read` gives them back as start values. Needs no compiled module.
"""

from __future__ import annotations

import argparse
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

from glenoid.devices import Device, load_device
from glenoid.inputs import SubjectInput, load_subject
from glenoid.parameters import (
    GIRDLE_DRIVES,
    GIRDLE_ORDER,
    NO_RANGE_RAD,
    device_parameters,
    subject_lacks,
    subject_parameters,
)

SSV = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"
SSC = "http://ssp-standard.org/SSP1/SystemStructureCommon"
BASE_UNITS: dict[str, dict[str, str]] = {"m": {"m": "1"}, "kg": {"kg": "1"}, "rad": {"rad": "1"}, "1": {}}
ENUMERATIONS = {"GirdleOrder": GIRDLE_ORDER, "GirdleDrives": GIRDLE_DRIVES}
ENUMERATION_OF = {"exo.girdleOrder": "GirdleOrder", "exo.girdleDrives": "GirdleDrives"}
LENGTHS = (
    "subject.stature",
    "subject.upperArmLength",
    "subject.forearmLength",
    "subject.shoulderDistance",
    "exo.girdleLink",
)


def unit_of(name: str) -> str:
    """Unit of a real parameter, as in modelDescription.xml."""
    if name.startswith("exo.axis"):
        return "1"
    if name == "subject.mass":
        return "kg"
    return "m" if name in LENGTHS else "rad"


def add_parameter(parent: ET.Element, name: str, value: Any) -> None:
    """One parameter with the type of its value."""
    parameter = ET.SubElement(parent, f"{{{SSV}}}Parameter", name=name)
    if name in ENUMERATION_OF:
        kind = ENUMERATION_OF[name]
        item = next(item for item, number in ENUMERATIONS[kind].items() if number == value)
        ET.SubElement(parameter, f"{{{SSV}}}Enumeration", name=kind, value=item)
    elif isinstance(value, bool):
        ET.SubElement(parameter, f"{{{SSV}}}Boolean", value=str(value).lower())
    else:
        ET.SubElement(parameter, f"{{{SSV}}}Real", value=repr(float(value)), unit=unit_of(name))


def document(name: str, values: dict[str, Any], description: str) -> bytes:
    """A parameter set as XML; the same input gives the same bytes."""
    ET.register_namespace("ssv", SSV)
    ET.register_namespace("ssc", SSC)
    root = ET.Element(f"{{{SSV}}}ParameterSet", version="1.0", name=name, description=description)
    parameters = ET.SubElement(root, f"{{{SSV}}}Parameters")
    for key, value in values.items():
        add_parameter(parameters, key, value)
    if used := {ENUMERATION_OF[key] for key in values if key in ENUMERATION_OF}:
        section = ET.SubElement(root, f"{{{SSV}}}Enumerations")
        for kind in sorted(used):
            enumeration = ET.SubElement(section, f"{{{SSC}}}Enumeration", name=kind)
            for item, number in ENUMERATIONS[kind].items():
                ET.SubElement(enumeration, f"{{{SSC}}}Item", name=item, value=str(number))
    units = ET.SubElement(root, f"{{{SSV}}}Units")
    for unit in sorted({element.attrib["unit"] for element in parameters.iter() if "unit" in element.attrib}):
        ET.SubElement(ET.SubElement(units, f"{{{SSC}}}Unit", name=unit), f"{{{SSC}}}BaseUnit", BASE_UNITS[unit])
    ET.indent(root)
    return b'<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(root) + b"\n"


def not_in_the_fmu(keys: list[str]) -> str:
    """A remark about figures that the set cannot carry."""
    return f" Without {', '.join(keys)}, which the FMU has no parameters for." if keys else ""


def subject_set(subject: SubjectInput) -> bytes:
    """Parameter set of a person."""
    text = "Complete: lengths of 0 are scaled from stature." + not_in_the_fmu(subject_lacks(subject))
    return document(subject.name or "subject", subject_parameters(subject), text)


def device_set(device: Device) -> bytes:
    """Parameter set of a complete device. InputError for a template."""
    text = f"Complete: axes, mounts, girdle and joint ranges; a joint without a range has {NO_RANGE_RAD:g} rad."
    return document(device.data.name, device_parameters(device), text)


def read(path: str | Path) -> dict[str, Any]:
    """Start values of a parameter set, by variable; an enumeration as its number."""
    root = ET.parse(path).getroot()
    items = {
        (enumeration.get("name"), item.get("name")): int(item.attrib["value"])
        for enumeration in root.iter(f"{{{SSC}}}Enumeration")
        for item in enumeration
    }
    values: dict[str, Any] = {}
    for parameter in root.iter(f"{{{SSV}}}Parameter"):
        element = parameter[0]
        text, kind = element.attrib["value"], element.tag.rpartition("}")[2]
        if kind == "Enumeration":
            values[parameter.attrib["name"]] = items[element.get("name"), text]
        else:
            values[parameter.attrib["name"]] = text in ("true", "1") if kind == "Boolean" else float(text)
    return values


def write_all(host: Path, out: Path) -> None:
    """Sets of every subject and every complete device in the folders of `host`; others are removed from `out`."""
    sets = {f"subjects/{path.stem}.ssv": subject_set(load_subject(path)) for path in (host / "subjects").glob("*.yaml")}
    devices = [load_device(path) for path in (host / "exoskeletons").glob("*.yaml")]
    sets |= {f"exoskeletons/{device.path.stem}.ssv": device_set(device) for device in devices if not device.missing}
    for old in out.rglob("*.ssv"):
        old.unlink()
    for name, content in sets.items():
        (out / name).parent.mkdir(parents=True, exist_ok=True)
        (out / name).write_bytes(content)


def main() -> None:
    """Command line of the build."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--host", type=Path, required=True, help="folder with subjects/ and exoskeletons/")
    parser.add_argument("--out", type=Path, required=True, help="folder of the sets")
    arguments = parser.parse_args()
    write_all(arguments.host, arguments.out)


if __name__ == "__main__":
    main()
