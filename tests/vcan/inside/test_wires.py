"""The project's own bus tests, on the kernel's CAN."""

import os
import re
import subprocess

import pytest
from glenoid.inputs import InputError
from glenoid.programs import program


def test_ports_keep_their_laws(link):
    try:
        tests = program("wires_port_test")
    except InputError as error:
        pytest.skip(str(error))
    environment = {**os.environ, "GLENOID_VCAN": link.name, "PATH": os.environ["PATH"] + ":/usr/sbin:/sbin"}
    done = subprocess.run([tests], capture_output=True, text=True, check=False, env=environment)
    assert done.returncode == 0, done.stdout[-4000:]
    passed = re.findall(r"\[       OK \] (\S+)", done.stdout)
    skipped = re.findall(r"\[  SKIPPED \] (\S+)", done.stdout)
    assert [name for name in passed if "ocket" in name], done.stdout[-4000:]
    assert not [name for name in skipped if "ocket" in name], done.stdout[-4000:]
