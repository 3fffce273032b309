"""Writes the type stubs of the Python bindings, which lcm-gen leaves without types.

Usage: stubs.py OUTPUT.pyi TYPE.lcm...
"""

import re
import sys
from pathlib import Path

PYTHON_TYPE = {
    "double": "float",
    "float": "float",
    "int64_t": "int",
    "int32_t": "int",
    "int16_t": "int",
    "int8_t": "int",
}
MEMBER = re.compile(r"^(?:const )?(\w+)\s+(.+);$")
COMMENT = re.compile(r"\s*//.*")


def stub_of(source: str) -> str:
    """Class of one .lcm file: constants, members, and what lcm-gen adds to each type."""
    lines = [COMMENT.sub("", line).strip() for line in source.splitlines()]
    name = next(line.split()[1] for line in lines if line.startswith("struct "))
    body = [f"class {name}:"]
    for line in lines[lines.index(f"struct {name} {{") + 1 :]:
        if (match := MEMBER.match(line)) is None:
            continue
        kind = PYTHON_TYPE[match[1]]
        for entry in match[2].split(","):
            member, *sizes = entry.split("=")[0].strip().split("[")
            body.append(f"    {member}: {'Sequence[' * len(sizes)}{kind}{']' * len(sizes)}")
    body += ["    def encode(self) -> bytes: ...", "    @staticmethod", f"    def decode(data: bytes) -> {name}: ..."]
    body += ["    @staticmethod", "    def _get_packed_fingerprint() -> bytes: ...", ""]
    return "\n".join(body)


def main(output: str, *sources: str) -> None:
    """One stub file for all types."""
    stubs = [stub_of(Path(source).read_text(encoding="utf-8")) for source in sources]
    Path(output).write_text("\n".join(["from collections.abc import Sequence\n", *stubs]), encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
