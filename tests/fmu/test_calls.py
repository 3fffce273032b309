"""Order of calls, logging, and what importers get wrong."""

import ctypes
import subprocess
import sys
from pathlib import Path

import fmu_driver
import pytest

OK, WARNING, DISCARD, ERROR = range(4)
H = 1 / 512


def make(new, phase):
    """An instance in the given phase."""
    unit = new()
    if phase != "instantiated":
        assert unit.enter() == OK
    if phase in ("step", "terminated"):
        assert unit.exit() == OK
    if phase == "terminated":
        assert unit.call("Terminate") == OK
    unit.messages.clear()
    return unit


CALLS = {
    "enter": lambda unit: unit.enter(),
    "exit": lambda unit: unit.exit(),
    "step": lambda unit: unit.step(0.0, H),
    "terminate": lambda unit: unit.call("Terminate"),
    "set": lambda unit: unit.set("target[1]", 0.1),
}
ALLOWED = {
    "instantiated": {"enter", "terminate", "set"},
    "initialization": {"exit", "terminate", "set"},
    "step": {"step", "terminate", "set"},
    "terminated": set(),
}


@pytest.mark.parametrize("call", CALLS)
@pytest.mark.parametrize("phase", ALLOWED)
def test_calls_out_of_order_are_errors_with_a_message(new, phase, call):
    unit = make(new, phase)
    status = CALLS[call](unit)
    if call in ALLOWED[phase]:
        assert status == OK
        assert all(m.category == "logEvents" for m in unit.messages)
    else:
        assert status == ERROR
        assert "not allowed in state" in unit.messages[-1].text
        assert unit.messages[-1].category == "logStatusError"


@pytest.mark.parametrize("phase", ALLOWED)
def test_values_can_be_read_in_every_phase(new, phase):
    unit = make(new, phase)
    assert unit.get("subject.stature") == 1.75
    assert len(unit.outputs()) == len(unit.archive.outputs)


@pytest.mark.parametrize("name", ["subject.stature", "rhythm.model", "subject.female", "start.q[1]"])
def test_fixed_parameters_stay_fixed_while_stepping(new, name):
    unit = make(new, "step")
    assert unit.set(name, unit.get(name)) == ERROR
    assert name in unit.messages[-1].text


@pytest.mark.parametrize("name", ["q[1]", "status", "time"])
def test_outputs_and_time_cannot_be_set(new, name):
    unit = make(new, "step")
    assert unit.set(name, 1) == ERROR
    assert name in unit.messages[-1].text


@pytest.mark.parametrize("kind", ["real", "integer", "boolean"])
def test_unknown_value_references_are_errors(new, kind):
    for reference in (1, 99, 0x7FFFFFF1, 0xFFFFFFFF):
        for prefix in ("Get", "Set"):
            unit = make(new, "step")
            assert unit._access(prefix, kind, [reference], [0])[0] == ERROR
            assert str(reference) in unit.messages[-1].text


def test_a_variable_of_another_type_is_an_error(new):
    unit = make(new, "step")
    assert unit._access("Get", "integer", [unit.archive.variables["q[1]"].reference], [0])[0] == ERROR


def test_wrong_token_gives_no_instance_and_a_reason(new):
    unit = new(token="{00000000-0000-0000-0000-000000000000}")
    assert not unit.handle
    assert "token" in unit.messages[-1].text


def test_other_interface_types_give_no_instance_and_a_reason(archive):
    log = fmu_driver.Message
    messages = []
    token = archive.token.encode()
    if archive.version == 2:
        logger = fmu_driver.LOGGER2(lambda _e, _n, s, c, m: messages.append(log(s, c.decode(), m.decode())))
        callbacks = fmu_driver.Callbacks2(logger, None, None, None, None)
        assert not archive.library.fmi2Instantiate(b"x", 0, token, b"", ctypes.byref(callbacks), 0, 1)
    else:
        logger = fmu_driver.LOGGER3(lambda _e, s, c, m: messages.append(log(s, c.decode(), m.decode())))
        instantiate = archive.library.fmi3InstantiateModelExchange
        instantiate.restype = ctypes.c_void_p
        assert not instantiate(b"x", token, b"", ctypes.c_bool(False), ctypes.c_bool(True), None, logger)
    assert "co-simulation" in messages[-1].text


def test_log_off_means_off(new):
    unit = new(logging=False).initialize()
    assert unit.set("target", (9.0, 9.0, 9.0)) == DISCARD
    assert unit.set("target", (3.0, 3.0, 3.0)) == OK
    unit.run(0, 0.125, H)
    assert unit.step(7.0, H) == DISCARD
    assert unit.exit() == ERROR
    assert unit.messages == []
    assert not new(logging=False, token="{wrong}").handle


def categories(unit, on, *names):
    array = (ctypes.c_char_p * max(len(names), 1))(*[name.encode() for name in names])
    flag = ctypes.c_bool(on) if unit.archive.version == 3 else ctypes.c_int(on)
    return unit.call("SetDebugLogging", flag, ctypes.c_size_t(len(names)), array)


def test_categories_select_messages(new):
    unit = new().initialize()
    assert categories(unit, True, "logEvents") == OK
    assert unit.step(7.0, H) == DISCARD
    assert unit.messages == []
    assert unit.step(0.0, H) == OK
    assert [m.category for m in unit.messages] == ["logEvents"]
    assert categories(unit, True) == OK
    assert unit.step(7.0, H) == DISCARD
    assert unit.messages[-1].category == "logStatusDiscard"
    assert categories(unit, True, "noSuchCategory") == WARNING
    assert categories(unit, False) == OK
    count = len(unit.messages)
    assert unit.step(7.0, H) == DISCARD
    assert len(unit.messages) == count


def test_every_category_is_declared(new):
    unit = new()
    declared = {category.attrib["name"] for category in unit.archive.root.find("LogCategories")}
    for name in declared:
        assert categories(unit, True, name) == OK


def test_percent_signs_are_doubled_for_the_variadic_logger_only(archives):
    """The token is echoed in the message: FMI 2 importers run the text through printf."""
    for archive in archives.values():
        texts = []
        unit = fmu_driver.Instance.__new__(fmu_driver.Instance)
        unit._log = lambda _s, _c, text, texts=texts: texts.append(text)
        unit.__init__(archive, token="%s%n")
        assert not unit.handle
        expected = b"%%s%%n" if archive.version == 2 else b"%s%n"
        assert b"token = " + expected in texts[-1]


UNSUPPORTED = {
    2: ["CancelStep"],
    3: ["EnterEventMode", "EnterStepMode", "EnterConfigurationMode", "EvaluateDiscreteStates"],
}


def test_functions_of_other_kinds_of_fmu_are_errors(new, archive):
    for name in UNSUPPORTED[archive.version]:
        unit = make(new, "step")
        assert unit.call(name) == ERROR
        assert "does not offer" in unit.messages[-1].text


@pytest.mark.parametrize("resources", [None, b"", b"/no/such/folder", b"file:///a%20b/resources", b"file:/a/", b"\xff"])
def test_the_resource_path_does_not_matter(new, resources):
    plain = new().initialize()
    unit = new(resources=resources).initialize()
    assert unit.run(0, 0.25, H) == plain.run(0, 0.25, H)


def test_missing_callbacks_are_borne(new, archive):
    unit = new(logger=False).initialize()
    assert unit.step(9.0, H) == DISCARD
    assert unit.step(0.0, H) == OK
    if archive.version == 2:
        handle = archive.library.fmi2Instantiate(None, 1, archive.token.encode(), None, None, 0, 1)
        assert handle
        archive.library.fmi2FreeInstance(ctypes.c_void_p(handle))


def test_null_instance_and_null_pointers_are_errors_not_crashes(new, archive):
    prefix = f"fmi{archive.version}"
    for name in ("Terminate", "Reset", "ExitInitializationMode"):
        assert getattr(archive.library, prefix + name)(None) == ERROR
    getattr(archive.library, prefix + "FreeInstance")(None)
    unit = make(new, "step")
    sizes = (None, ctypes.c_size_t(1), None) + ((ctypes.c_size_t(1),) if archive.version == 3 else ())
    for prefix in ("Get", "Set"):
        suffix = fmu_driver.ACCESS["real"][archive.version - 2][0]
        assert unit.call(prefix + suffix, *sizes) == DISCARD
    assert unit.step(0.0, H) == OK


CONSOLE = """
import sys, pathlib, json
sys.path.insert(0, sys.argv[1])
import fmu_driver
archive = fmu_driver.Archive(pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3]))
with fmu_driver.Instance(archive, logging=False) as unit:
    unit.initialize()
    unit.set("target", (3.0, 3.0, 3.0))
    unit.run(0, 0.25, 1 / 512)
    unit.step(9.0, 1.0)
    unit.exit()
"""


def test_nothing_is_written_to_the_console(archive, tmp_path):
    folder = str(Path(__file__).parent)
    command = [sys.executable, "-c", CONSOLE, folder, str(archive.path), str(tmp_path)]
    done = subprocess.run(command, capture_output=True, check=True)
    assert (done.stdout, done.stderr) == (b"", b"")


SHIM = r"""
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stddef.h>
volatile long allocations = 0;
void* malloc(size_t n) { static void* (*real)(size_t); if (!real) real = (void* (*)(size_t))dlsym(RTLD_NEXT, "malloc");
  allocations++; return real(n); }
void* realloc(void* p, size_t n) { static void* (*real)(void*, size_t);
  if (!real) real = (void* (*)(void*, size_t))dlsym(RTLD_NEXT, "realloc"); allocations++; return real(p, n); }
void* aligned_alloc(size_t a, size_t n) { static void* (*real)(size_t, size_t);
  if (!real) real = (void* (*)(size_t, size_t))dlsym(RTLD_NEXT, "aligned_alloc"); allocations++; return real(a, n); }
int posix_memalign(void** p, size_t a, size_t n) { static int (*real)(void**, size_t, size_t);
  if (!real) real = (int (*)(void**, size_t, size_t))dlsym(RTLD_NEXT, "posix_memalign"); allocations++; return real(p, a, n); }
typedef int (*step2)(void*, double, double, int);
typedef int (*step3)(void*, double, double, int, int*, int*, int*, double*);
typedef int (*set2)(void*, const unsigned*, size_t, const double*);
typedef int (*set3)(void*, const unsigned*, size_t, const double*, size_t);
/* Steps of h with a new target every 20 steps; returns the allocations in them, or -1 - status. */
long run(int version, void* step, void* set, void* instance, double h, int steps) {
  const unsigned references[3] = {300, 301, 302};
  const long before = allocations;
  for (int k = 0; k < steps; ++k) {
    int a, b, c; double t;
    if (k % 20 == 0) {
      const double target[3] = {0.20 - 0.01 * (k / 20 % 5), 0.42, 0.25 - 0.03 * (k / 20 % 3)};
      version == 2 ? ((set2)set)(instance, references, 3, target) : ((set3)set)(instance, references, 3, target, 3);
    }
    const int status = version == 2 ? ((step2)step)(instance, k * h, h, 0) : ((step3)step)(instance, k * h, h, 0, &a, &b, &c, &t);
    if (status) return -1 - status;
  }
  return allocations - before;
}
"""
COUNT = """
import sys, pathlib, ctypes
sys.path.insert(0, sys.argv[1])
import fmu_driver
archive = fmu_driver.Archive(pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3]))
shim = ctypes.CDLL(None)
shim.run.restype = ctypes.c_long
with fmu_driver.Instance(archive, logging=False, logger=False) as unit:
    unit.initialize()
    v = archive.version
    step, put = getattr(archive.library, f"fmi{v}DoStep"), getattr(archive.library, "fmi2SetReal" if v == 2 else "fmi3SetFloat64")
    pointers = [ctypes.cast(f, ctypes.c_void_p) for f in (step, put)]
    print(shim.run(v, *pointers, unit.handle, ctypes.c_double(1 / 512), 1000), ctypes.c_long.in_dll(shim, "allocations").value)
"""


def test_steps_do_not_touch_the_heap(archive, tmp_path):
    """Counted by a malloc in front of libc's, re-planning included."""
    source, shim = tmp_path / "shim.c", tmp_path / "shim.so"
    source.write_text(SHIM)
    subprocess.run(["cc", "-O1", "-fno-builtin", "-shared", "-fPIC", "-o", shim, source, "-ldl"], check=True)
    command = [sys.executable, "-c", COUNT, str(Path(__file__).parent), str(archive.path), str(tmp_path / "u")]
    done = subprocess.run(command, capture_output=True, text=True, env={"LD_PRELOAD": str(shim)}, check=False)
    assert done.returncode == 0, done.stderr
    in_steps, total = map(int, done.stdout.split())
    assert total > 1000  # the counter is at work
    assert in_steps == 0


def test_real_status_answers_after_a_refused_step(archives):
    with fmu_driver.Instance(archives["fmi2"]) as unit:
        unit.initialize()
        unit.run(0, 0.25, H)
        assert unit.step(0.25, -1.0) == DISCARD
        time, terminated = ctypes.c_double(), ctypes.c_int(7)
        assert unit.call("GetRealStatus", 2, ctypes.byref(time)) == OK
        assert unit.call("GetBooleanStatus", 3, ctypes.byref(terminated)) == OK
        assert (time.value, terminated.value) == (0.25, 0)
