"""Who may know whom: fmu -> core <- host -> lcm_types, and what the core must not use."""

import re

import pytest
from repository import files_of, name_of

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', re.MULTILINE)
CPP = (".cpp", ".hpp", ".h")
STANDARD = {
    "algorithm",
    "array",
    "bit",
    "cfloat",
    "charconv",
    "climits",
    "cmath",
    "compare",
    "concepts",
    "cstddef",
    "cstdint",
    "cstdio",
    "cstdlib",
    "cstring",
    "exception",
    "functional",
    "initializer_list",
    "iterator",
    "limits",
    "memory",
    "new",
    "numbers",
    "numeric",
    "optional",
    "span",
    "stdexcept",
    "string",
    "string_view",
    "tuple",
    "type_traits",
    "utility",
    "variant",
    "vector",
    "stddef.h",
    "immintrin.h",
}
SUNDIALS = ("cvode/", "nvector/", "sunmatrix/", "sunlinsol/", "sunnonlinsol/", "sundials/", "kinsol/")
# What a room may not include: parts of paths.
FORBIDDEN = {
    "fmu": ("host/", "lcm", "bridge/", "linux/can", "nanobind"),
    "host": ("fmi2", "fmi3", "fmu/"),
    "core": ("fmi2", "fmi3", "fmu/", "host/", "lcm", "linux/can", "nanobind"),
}
CORE_CALLS = re.compile(
    r"std::(cout|cerr|clog|thread|mutex|chrono|ofstream|ifstream|filesystem)|\b(fopen|f?printf|getenv|clock_gettime)\s*\("
)


# Headers that may define a macro, with the reason.
MACROS = {"core/src/kernels.hpp": "an attribute that only some compilers have cannot be named otherwise"}


def includes(path):
    return [(quote, target) for quote, target in INCLUDE.findall(path.read_text(encoding="utf-8"))]


@pytest.mark.parametrize("room", sorted(FORBIDDEN))
def test_room_includes_nothing_of_a_room_it_must_not_know(room):
    bad = [
        f"{name_of(path)}: {target}"
        for path in files_of(room, *CPP)
        if "headers/" not in name_of(path)
        for _, target in includes(path)
        if any(part in target for part in FORBIDDEN[room])
    ]
    assert not bad


def test_lcm_types_know_nobody():
    assert not [name_of(path) for path in files_of("lcm_types", *CPP, ".lcm") if includes(path)]


def is_foreign(quote, target):
    if quote == '"':
        return False
    return not (target in STANDARD or target.startswith("Eigen/") or target.startswith(SUNDIALS))


def test_core_includes_only_eigen_the_standard_library_and_sundials():
    bad = [f"{name_of(p)}: {t}" for p in files_of("core", *CPP) for q, t in includes(p) if is_foreign(q, t)]
    assert not bad


def test_sundials_is_in_one_file_of_the_core():
    users = [name_of(p) for p in files_of("core", *CPP) if any(t.startswith(SUNDIALS) for _, t in includes(p))]
    assert users == ["core/src/geodesic_ivp.cpp"]


def test_core_has_no_threads_clocks_files_or_logging():
    bad = [name_of(p) for p in files_of("core", *CPP) if CORE_CALLS.search(p.read_text(encoding="utf-8"))]
    assert not bad


def test_headers_have_no_macros_and_are_guarded():
    for path in files_of("core", ".hpp") + files_of("host", ".hpp"):
        text = path.read_text(encoding="utf-8")
        assert text.startswith("#pragma once"), name_of(path)
        assert "#define" not in text or name_of(path) in MACROS, name_of(path)
