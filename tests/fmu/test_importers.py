"""Importers of other houses give FMPy's numbers: 1e-9, or the digits that they print."""

import csv
import importlib.util
import os
import shutil
import subprocess
import sys
from pathlib import Path

import fmpy
import fmu_driver
import pytest

STEP, STEPS = 0.01, 70  # in the middle of the movement


def need(module):
    if importlib.util.find_spec(module) is None:
        pytest.skip(f"{module} is not installed (dependency group importers)")


def real_outputs(archive):
    return [v for v in archive.outputs if v.kind == "real"]


@pytest.fixture(scope="module")
def expected(archives):
    """FMPy's values of every real output after STEPS steps; both versions are equal (test_equality)."""
    names = [v.name for v in real_outputs(archives["fmi3"])]
    result = fmpy.simulate_fmu(
        str(archives["fmi3"].path), output=names, stop_time=STEP * STEPS, step_size=STEP, output_interval=STEP,
        fmi_type="CoSimulation",
    )  # fmt: skip
    return {name: result[name] for name in names}


def compare(expected, found, tolerance):
    assert len(found) > 20
    for name, value in found.items():
        assert value == pytest.approx(expected[name], rel=tolerance, abs=tolerance), name


FMULOADER = """
import json, sys
path, step, steps, names, references, version, token = json.loads(sys.argv[1])
if version == 2:
    from fmuloader.fmi2 import Fmi2Slave, Fmi2Type
    s = Fmi2Slave(path, model_identifier="Glenoid"); s.instantiate("i", Fmi2Type.CO_SIMULATION, guid=token)
    s.setup_experiment(start_time=0.0); s.enter_initialization_mode(); get = s.get_real
else:
    from fmuloader.fmi3 import Fmi3Slave
    s = Fmi3Slave(path, model_identifier="Glenoid"); s.instantiate_co_simulation("i", instantiation_token=token)
    s.enter_initialization_mode(start_time=0.0); get = s.get_float64
s.exit_initialization_mode()
for k in range(steps): s.do_step(k * step, step)
print(json.dumps(dict(zip(names, map(float, get(references))))))
"""
LIBCOSIM = """
import json, sys
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave
path, step, steps, names, references, version, token = json.loads(sys.argv[1])
log_output_level(CosimLogLevel.ERROR)
execution = CosimExecution.from_step_size(round(step * 1e9))
slave = CosimLocalSlave(path, "i")
assert slave.ptr(), "not loaded"
index = execution.add_local_slave(slave)
observer = CosimObserver.create_last_value()
execution.add_observer(observer)
assert execution.step(steps)
print(json.dumps(dict(zip(names, map(float, observer.last_real_values(index, references))))))
"""


def run_script(script, archive):
    """Runs an importer in a process of its own: some crash instead of raising."""
    import json

    outputs = real_outputs(archive)
    arguments = (
        str(archive.path), STEP, STEPS, [v.name for v in outputs], [v.reference for v in outputs], archive.version,
        archive.token,
    )  # fmt: skip
    done = subprocess.run(
        [sys.executable, "-c", script, json.dumps(arguments)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


def test_fmuloader_agrees(archive, expected):
    need("fmuloader")
    compare({name: rows[-1] for name, rows in expected.items()}, run_script(FMULOADER, archive), 1e-9)


def test_libcosim_agrees(archives, expected):
    need("libcosimpy")
    found = run_script(LIBCOSIM, archives["fmi2"])  # it knows no FMI 3
    compare({name: rows[-1] for name, rows in expected.items()}, found, 1e-9)


def test_ecos_agrees(archive, expected, tmp_path):
    need("ecospy")
    import ecospy

    programs = tmp_path / "ecos"
    shutil.copytree(Path(ecospy.__file__).parent / "binaries", programs)
    for program in programs.iterdir():
        program.chmod(0o755)  # the wheel forgets it
    environment = os.environ | {"LD_LIBRARY_PATH": str(programs)}
    if "not found" in subprocess.run(["ldd", programs / "ecos"], capture_output=True, text=True, check=True).stdout:
        pytest.skip("ecos needs libtbb12")
    times = ["--stopTime", str(STEP * STEPS), "--stepSize", str(STEP)]
    command = [programs / "ecos", "simulate", "--path", archive.path, *times]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    (table,) = tmp_path.glob("*.csv")
    with table.open() as lines:
        rows = list(csv.reader(lines))
    header = [column.strip().split("[REAL]")[0].split("::")[-1] for column in rows[0]]
    last = dict(zip(header, rows[-1], strict=True))
    found = {name: float(last[name]) for name in expected if name in last}
    moment = round(float(last["time"]) / STEP)  # the last row may be one step before the end
    assert moment >= STEPS - 1
    compare(
        {name: rows[moment] for name, rows in expected.items()}, found, 1e-6
    )  # six digits after the point are printed


def test_fmpy_steps_by_hand_agree(archive, expected):
    with fmu_driver.Instance(archive) as unit:
        unit.initialize()
        for k in range(STEPS):
            assert unit.step(k * STEP, STEP) == 0
        found = {v.name: unit.get(v.name) for v in real_outputs(archive)}
    compare({name: rows[-1] for name, rows in expected.items()}, found, 1e-12)
