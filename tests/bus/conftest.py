"""What the bus tests share: simulated drives on a bus of their own, and python-can on the same bus."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import can
import lcm
import pytest
from glenoid.fmus import fmu_path
from glenoid.inputs import InputError
from glenoid.programs import program

sys.path.insert(0, str(Path(__file__).parent))
from bridge_process import Bridge

FIRST_PORT = 43200  # beside python-can's 43113, so that nobody else is heard


class Drives:
    """A running glenoid-drives."""

    def __init__(self, url, *arguments):
        self.url = url
        self.process = subprocess.Popen(
            [program("glenoid-drives"), "--bus", url, *map(str, arguments)],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        first = self.process.stderr.readline()
        assert first.endswith("ready\n"), first + self.process.stderr.read()

    def stop(self):
        """Ends the program; its report."""
        self.process.send_signal(signal.SIGTERM)
        out, _ = self.process.communicate(timeout=20)
        assert self.process.returncode == 0
        return json.loads(out)


@pytest.fixture
def bus_address():
    """Group and port that no other test run on this machine uses."""
    return "239.74.163.2", FIRST_PORT + os.getpid() % 5000


@pytest.fixture
def url():
    """Of LCM, with a multicast port that no other test run on this machine uses."""
    address = f"udpm://239.255.76.67:{20000 + os.getpid() % 20000}?ttl=0"
    try:
        lcm.LCM(address)
    except RuntimeError:
        pytest.skip("no multicast route")
    return address


@pytest.fixture(scope="session")
def fmu():
    """The FMU for FMI 3.0."""
    try:
        return fmu_path("3")
    except InputError as error:
        pytest.skip(str(error))


@pytest.fixture
def drives(bus_address):
    """Starts drives with the arguments given; ends them with the test."""
    running = []

    def start(*arguments):
        running.append(Drives("udp:{}:{}".format(*bus_address), *arguments))
        return running[-1]

    yield start
    for one in running:
        one.process.kill()
        one.process.communicate()


@pytest.fixture
def python_bus(bus_address):
    group, port = bus_address
    with can.Bus(group, interface="udp_multicast", port=port, receive_own_messages=False) as bus:
        yield bus


@pytest.fixture
def start(tmp_path, bus_address):
    running = []

    def begin(changes=None, arguments=()):
        running.append(Bridge(tmp_path, bus_address, changes, arguments))
        return running[-1]

    yield begin
    for one in running:
        one.close()
