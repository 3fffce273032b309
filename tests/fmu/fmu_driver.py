"""Drives one FMU archive of either version directly through its C functions: every status and message is seen.

The archives are those in GLENOID_BUILD_DIR/fmu (default build/fmu).
"""

import ctypes
import os
import platform
import xml.etree.ElementTree as ET
import zipfile
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ.get("GLENOID_BUILD_DIR", ROOT / "build"))
FILES = {"fmi2": "Glenoid_fmi2.fmu", "fmi3": "Glenoid.fmu"}
SEED = int(os.environ.get("GLENOID_TEST_SEED", "20261122"))

OK, WARNING, DISCARD, ERROR = range(4)
KINDS = {"Real": "real", "Float64": "real", "Enumeration": "integer", "Boolean": "boolean"}
# kind -> (FMI 2 suffix, FMI 2 type), (FMI 3 suffix, FMI 3 type)
ACCESS = {
    "real": (("Real", ctypes.c_double), ("Float64", ctypes.c_double)),
    "integer": (("Integer", ctypes.c_int), ("Int64", ctypes.c_int64)),
    "boolean": (("Boolean", ctypes.c_int), ("Boolean", ctypes.c_bool)),
}
LOGGER2 = ctypes.CFUNCTYPE(
    None, ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_char_p
)  # the dots take no arguments
LOGGER3 = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_char_p)


class Callbacks2(ctypes.Structure):
    _fields_ = [
        ("logger", LOGGER2),
        ("allocate", ctypes.c_void_p),
        ("free", ctypes.c_void_p),
        ("finished", ctypes.c_void_p),
        ("environment", ctypes.c_void_p),
    ]


class Message(NamedTuple):
    status: int
    category: str
    text: str


class Variable(NamedTuple):
    name: str
    reference: int
    kind: str
    causality: str
    variability: str
    start: float | None
    minimum: float
    maximum: float
    unit: str
    element: ET.Element


def read_variable(element: ET.Element) -> Variable:
    typed = element if element.tag in KINDS else next(child for child in element if child.tag in KINDS)
    number = {"true": 1.0, "false": 0.0}
    start = typed.get("start")
    return Variable(
        element.attrib["name"],
        int(element.attrib["valueReference"]),
        KINDS[typed.tag],
        element.attrib["causality"],
        element.attrib["variability"],
        None if start is None else number.get(start) if start in number else float(start),
        float(typed.get("min", "-inf")),
        float(typed.get("max", "inf")),
        typed.get("unit", ""),
        typed,
    )


class Archive:
    """An unpacked FMU with its library loaded."""

    def __init__(self, path: Path, folder: Path, library: Path | None = None):
        self.path, self.folder = path, folder
        with zipfile.ZipFile(path) as archive:
            archive.extractall(folder)
        self.root = ET.parse(folder / "modelDescription.xml").getroot()
        self.version = int(self.root.attrib["fmiVersion"][0])
        self.token = self.root.get("guid") or self.root.attrib["instantiationToken"]
        machine = platform.machine()
        binaries = "linux64" if self.version == 2 else f"{machine}-linux"
        self.library_path = library or folder / "binaries" / binaries / "Glenoid.so"
        self.library = ctypes.CDLL(str(self.library_path))
        self.library.fmi2Instantiate.restype = ctypes.c_void_p
        self.library.fmi3InstantiateCoSimulation.restype = ctypes.c_void_p
        self.variables = {v.name: v for v in map(read_variable, self.root.find("ModelVariables"))}
        self.outputs = [v for v in self.variables.values() if v.causality == "output"]
        experiment = self.root.find("DefaultExperiment").attrib
        self.step = float(experiment["stepSize"])


class Instance:
    """One instance; use as a context manager. `messages` holds what the FMU logged."""

    def __init__(self, archive: Archive, logging=True, token=None, resources=b"", logger=True):
        self.archive, self.fmi = archive, archive.library
        self.messages: list[Message] = []
        token = (token or archive.token).encode()
        if archive.version == 2:
            self._logger = LOGGER2(lambda _e, _n, s, c, m: self._log(s, c, m)) if logger else LOGGER2()
            self._callbacks = Callbacks2(self._logger, None, None, None, None)
            handle = self.fmi.fmi2Instantiate(
                b"test", 1, token, resources, ctypes.byref(self._callbacks), 0, int(logging)
            )
        else:
            self._logger = LOGGER3(lambda _e, s, c, m: self._log(s, c, m)) if logger else LOGGER3()
            flags = [ctypes.c_bool(False), ctypes.c_bool(logging), ctypes.c_bool(False), ctypes.c_bool(False)]
            handle = self.fmi.fmi3InstantiateCoSimulation(
                b"test", token, resources, *flags, None, ctypes.c_size_t(0), None, self._logger, None
            )
        self.handle = ctypes.c_void_p(handle)

    def _log(self, status, category, text):
        self.messages.append(Message(status, category.decode(), text.decode().replace("%%", "%")))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.free()

    def free(self):
        if self.handle:
            self.call("FreeInstance")
            self.handle = ctypes.c_void_p()

    def call(self, name, *arguments):
        """Calls fmi2NAME or fmi3NAME with this instance; returns the status."""
        return getattr(self.fmi, f"fmi{self.archive.version}{name}")(self.handle, *arguments)

    # Life cycle

    def enter(self, start=0.0, stop=None):
        times = (ctypes.c_double(start), ctypes.c_bool(stop is not None), ctypes.c_double(stop or 0.0))
        if self.archive.version == 3:
            return self.call("EnterInitializationMode", ctypes.c_bool(False), ctypes.c_double(0), *times)
        status = self.call("SetupExperiment", 0, ctypes.c_double(0), times[0], int(stop is not None), times[2])
        return status or self.call("EnterInitializationMode")

    def exit(self):
        return self.call("ExitInitializationMode")

    def initialize(self, start=0.0, stop=None, **values):
        assert self.enter(start, stop) == OK
        for name, value in values.items():
            assert self.set(name, value) == OK, self.messages
        assert self.exit() == OK, self.messages
        return self

    def step(self, time, size):
        if self.archive.version == 2:
            return self.call("DoStep", ctypes.c_double(time), ctypes.c_double(size), 0)
        flags = (ctypes.c_bool * 3)()
        self.last = ctypes.c_double()
        pointers = [ctypes.byref(flags, k) for k in range(3)]
        arguments = (ctypes.c_double(time), ctypes.c_double(size), ctypes.c_bool(False), *pointers)
        return self.call("DoStep", *arguments, ctypes.byref(self.last))

    def run(self, start, stop, size):
        """Steps on the grid start + k size; returns the outputs after every step."""
        rows = []
        for k in range(round((stop - start) / size)):
            assert self.step(start + k * size, size) == OK, self.messages
            rows.append(self.outputs())
        return rows

    # Values

    def _access(self, prefix, kind, references, values):
        suffix, number = ACCESS[kind][self.archive.version - 2]
        n = len(references)
        buffer = (number * n)(*values)
        sizes = (ctypes.c_size_t(n),) if self.archive.version == 2 else (ctypes.c_size_t(n), buffer, ctypes.c_size_t(n))
        tail = (sizes[0], buffer) if self.archive.version == 2 else sizes
        return self.call(prefix + suffix, (ctypes.c_uint32 * n)(*references), *tail), list(buffer)

    def set(self, name, value):
        """Status of setting a variable; `target` and other vectors take a sequence."""
        if name in self.archive.variables:
            variable = self.archive.variables[name]
            numbers = [int(value) if variable.kind != "real" else float(value)]
            return self._access("Set", variable.kind, [variable.reference], numbers)[0]
        first = self.archive.variables[f"{name}[1]"]
        return self._access("Set", "real", [first.reference + k for k in range(len(value))], map(float, value))[0]

    def get(self, name):
        names = (
            [name]
            if name in self.archive.variables
            else [n for n in self.archive.variables if n.startswith(name + "[")]
        )
        variables = [self.archive.variables[n] for n in names]
        status, values = self._access("Get", variables[0].kind, [v.reference for v in variables], [0] * len(variables))
        assert status == OK, self.messages
        return values[0] if name in self.archive.variables else values

    def outputs(self):
        """Every output, in the order of the description."""
        return tuple(self.numbers(list(self.archive.outputs)))

    def numbers(self, variables):
        found = {}
        for kind in ACCESS:
            chosen = [v for v in variables if v.kind == kind]
            status, values = self._access("Get", kind, [v.reference for v in chosen], [0] * len(chosen))
            assert status == OK, self.messages
            found |= {v.name: value for v, value in zip(chosen, values, strict=True)}
        return [found[v.name] for v in variables]

    # State

    def _state(self, word):
        return word.replace("State", "state") if self.archive.version == 2 else word

    def save(self):
        state = ctypes.c_void_p()
        assert self.call(self._state("GetFMUState"), ctypes.byref(state)) == OK
        return state

    def restore(self, state):
        return self.call(self._state("SetFMUState"), state)

    def release(self, state):
        assert self.call(self._state("FreeFMUState"), ctypes.byref(state)) == OK
        assert not state

    def serialize(self, state):
        size = ctypes.c_size_t()
        assert self.call(self._state("SerializedFMUStateSize"), state, ctypes.byref(size)) == OK
        data = (ctypes.c_ubyte * size.value)()
        assert self.call(self._state("SerializeFMUState"), state, data, size) == OK
        return bytes(data)

    def deserialize(self, data):
        state = ctypes.c_void_p()
        name = "DeSerializeFMUstate" if self.archive.version == 2 else "DeserializeFMUState"
        buffer = (ctypes.c_ubyte * max(len(data), 1)).from_buffer_copy(data or b"\0")
        return self.call(name, buffer, ctypes.c_size_t(len(data)), ctypes.byref(state)), state
