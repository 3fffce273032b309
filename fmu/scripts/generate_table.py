"""Writes the compiled variable table (a C++ header) from modelDescription.xml.

usage: generate_table.py modelDescription.xml OUTPUT.hpp
"""

from __future__ import annotations

import math
import re
import sys
from pathlib import Path

from description import Variable, read_tree, read_variables

KINDS = {"Float64": "Real", "Enumeration": "Enumeration", "Boolean": "Boolean"}


def cpp_number(value: float) -> str:
    """Literal with the same bits."""
    if math.isinf(value):
        return f"{'-' if value < 0 else ''}std::numeric_limits<double>::infinity()"
    return repr(value)


def constant_name(name: str) -> str:
    """limits.lower[1] -> kLimitsLower: the first component names the vector."""
    words = re.split(r"[._]", re.sub(r"\[\d+\]$", "", name))
    return "k" + "".join(word[0].upper() + word[1:] for word in words)


def table_row(variable: Variable) -> str:
    """One initializer of the table."""
    numbers = (variable.start or 0.0, variable.minimum, variable.maximum)
    return (
        f"    {{{variable.reference}, Kind::{KINDS[variable.tag]}, Causality::{variable.causality.capitalize()}, "
        f"Variability::{variable.variability.capitalize()}, {', '.join(cpp_number(n) for n in numbers)}, "
        f'"{variable.name}", "{variable.unit if variable.unit != "1" else ""}"}},'
    )


def index_constants(variables: list[Variable]) -> list[str]:
    """Enumerators with the table index of every scalar and of the first component of every vector."""
    return [
        f"  {constant_name(v.name)} = {index},"
        for index, v in enumerate(variables)
        if not re.search(r"\[(?!1\])\d+\]$", v.name)
    ]


def check_vectors(variables: list[Variable]) -> None:
    """Components of a vector follow one another, from 1."""
    for previous, current in zip(variables, variables[1:], strict=False):
        match = re.fullmatch(r"(.*)\[(\d+)\]", current.name)
        if match and int(match[2]) > 1 and previous.name != f"{match[1]}[{int(match[2]) - 1}]":
            raise ValueError(f"{current.name} does not follow {match[1]}[{int(match[2]) - 1}]")


def header(path: Path) -> str:
    """Text of the header."""
    root = read_tree(path)
    variables = read_variables(root)
    check_vectors(variables)
    indices = {v.reference: index for index, v in enumerate(variables)}
    references = [indices.get(k, -1) for k in range(max(indices) + 1)]
    rows = [", ".join(map(str, references[k : k + 24])) for k in range(0, len(references), 24)]
    return "\n".join(
        [
            "// Generated from modelDescription.xml by generate_table.py.",
            "#pragma once",
            "",
            "#include <array>",
            "#include <cstdint>",
            "#include <limits>",
            "",
            "namespace glenoid::fmu {",
            "",
            f'inline constexpr char kInstantiationToken[] = "{root.attrib["instantiationToken"]}";',
            "",
            "/// Index of a variable, or of the first component of a vector, in kVariables.",
            "enum Index : std::size_t {",
            *index_constants(variables),
            "};",
            "",
            f"inline constexpr std::array<Variable, {len(variables)}> kVariables = {{{{",
            *map(table_row, variables),
            "}};",
            "",
            "/// Index of each value reference in kVariables, -1 in the gaps.",
            f"inline constexpr std::array<std::int16_t, {len(references)}> kIndexOfReference = {{",
            *(f"    {row}," for row in rows),
            "};",
            "",
            "}  // namespace glenoid::fmu",
            "",
        ]
    )


if __name__ == "__main__":
    Path(sys.argv[2]).write_text(header(Path(sys.argv[1])), encoding="ascii")
