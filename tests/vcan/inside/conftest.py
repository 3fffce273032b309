"""Inside: vcan0 of this network, the tools that change it, and simulated drives on it."""

import contextlib
import json
import os
import signal
import struct
import subprocess
import time
from pathlib import Path
from types import SimpleNamespace

import can
import pytest
import yaml
from glenoid.inputs import InputError
from glenoid.programs import program

ROOT = Path(__file__).resolve().parents[3]

INTERFACE = "vcan0"
SBIN = {**os.environ, "PATH": os.environ.get("PATH", "") + ":/usr/sbin:/sbin"}
PATIENCE_S = 30.0
QUEUE = 32
BRIDGE_PERIOD_MS = 20
# Periods of a machine with one slow processor; the tests of the bridge state its own in virtual time.
TIMES = {
    "sync": {"period_ms": BRIDGE_PERIOD_MS, "rpdo_phase": 0.5},
    "setpoints": {
        "period_ms": BRIDGE_PERIOD_MS,
        "delay_ms": 100,
        "hold_after_ms": 500,
        "quick_stop_after_ms": 2000,
        "disarm_after_ms": 4000,
    },
    "heartbeat": {
        "master_id": 127,
        "master_period_ms": 50,
        "drive_waits_ms": 2000,
        "drive_period_ms": 100,
        "drive_timeout_ms": 5000,
    },
}


def command(*words):
    return subprocess.run(words, env=SBIN, check=True, capture_output=True, text=True).stdout


@pytest.fixture(autouse=True)
def link():
    """The interface as every test finds it: up, with a short queue and no queueing discipline."""

    def discipline(*words):
        """Puts a queueing discipline in place; without words takes it away."""
        if words:
            done = subprocess.run(
                ["tc", "qdisc", "replace", "dev", INTERFACE, "root", *map(str, words)],
                env=SBIN,
                capture_output=True,
                text=True,
                check=False,
            )
            if done.returncode != 0:
                pytest.skip(f"no {words[0]} in this kernel: {done.stderr.strip()}")
        else:
            subprocess.run(["tc", "qdisc", "del", "dev", INTERFACE, "root"], env=SBIN, capture_output=True, check=False)

    def state(word):
        command("ip", "link", "set", INTERFACE, word)

    discipline()
    command("ip", "link", "set", INTERFACE, "txqueuelen", str(QUEUE))
    state("up")
    yield SimpleNamespace(name=INTERFACE, discipline=discipline, set=state)
    state("up")
    discipline()


@pytest.fixture
def bus(link):
    """python-can's SocketCAN interface."""
    with can.Bus(link.name, interface="socketcan") as opened:
        yield opened


class Master:
    """The least that a CANopen master needs, over python-can."""

    def __init__(self, bus):
        self.bus = bus

    def send(self, identifier, data=b""):
        self.bus.send(can.Message(arbitration_id=identifier, data=data, is_extended_id=False))

    def hear(self, identifier, seconds=PATIENCE_S):
        """The next frame of an identifier, None if it does not come."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0:
            message = self.bus.recv(left)
            if message is not None and message.arbitration_id == identifier and not message.is_error_frame:
                return message
        return None

    def forget_error(self):
        """An interface that went down leaves one error in every socket on it."""
        with contextlib.suppress(can.CanOperationError):
            self.bus.recv(0)

    def drain(self):
        """Everything that is there."""
        found = []
        while (message := self.bus.recv(0.05)) is not None:
            found.append(message)
        return found

    def request(self, node, data):
        """SDO request and answer; repeated while the drive boots."""
        end = time.monotonic() + PATIENCE_S
        while time.monotonic() < end:
            self.send(0x600 + node, data)
            answer = self.hear(0x580 + node, 1.0)
            if answer is not None:
                return bytes(answer.data)
        pytest.fail(f"node {node} does not answer")

    def write(self, node, index, sub, value, size):
        data = struct.pack("<BHBi", 0x23 | (4 - size) << 2, index, sub, value)
        assert self.request(node, data)[0] == 0x60

    def read(self, node, index, sub=0):
        answer = self.request(node, struct.pack("<BHBi", 0x40, index, sub, 0))
        assert answer[0] != 0x80
        return struct.unpack("<i", answer[4:8])[0]

    def map_position(self, node):
        """RPDO1 {6040h, 607Ah} and TPDO1 {6041h, 6064h}, both with every SYNC; then operational."""
        for base, entries in ((0x1400, (0x60400010, 0x607A0020)), (0x1800, (0x60410010, 0x60640020))):
            identifier = (0x200 if base == 0x1400 else 0x40000180) + node  # bit 30: no remote frames
            self.write(node, base, 1, identifier - 2**31, 4)
            self.write(node, base + 0x200, 0, 0, 1)
            for sub, entry in enumerate(entries, 1):
                self.write(node, base + 0x200, sub, entry, 4)
            self.write(node, base + 0x200, 0, len(entries), 1)
            self.write(node, base, 2, 1, 1)
            self.write(node, base, 1, identifier, 4)
        self.write(node, 0x60C2, 1, 10, 1)
        self.write(node, 0x6060, 0, 8, 1)
        self.send(0x000, bytes((0x01, node)))


@pytest.fixture
def master(bus):
    return Master(bus)


@pytest.fixture
def drives(link):
    """Starts glenoid-drives on the interface; `stop()` gives its report."""
    running = []

    def start(*arguments):
        words = [program("glenoid-drives"), "--bus", f"socketcan:{link.name}", *map(str, arguments)]
        process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        running.append(process)
        first = process.stderr.readline()
        assert first.endswith("ready\n"), first

        def stop():
            process.send_signal(signal.SIGTERM)
            out, _ = process.communicate(timeout=PATIENCE_S)
            return json.loads(out)

        return SimpleNamespace(process=process, stop=stop)

    yield start
    for process in running:
        process.kill()
        process.communicate()


@pytest.fixture
def patient(tmp_path):
    """Profile of drives for which SYNC may come 2 s late."""
    path = tmp_path / "patient.yaml"
    path.write_text('name: patient\nobjects: {"2F10h:02": 2000000}\n')
    return path


@pytest.fixture
def bridge_data(link):
    """Configuration of a bridge on the interface, as plain data."""
    config = yaml.safe_load((ROOT / "host/bridge/examples/six_drives.yaml").read_text(encoding="utf-8"))
    arm = config["exoskeletons"]["six_drives"]
    arm.update(TIMES)
    arm.pop("device", None)  # these tests drive another
    arm["joint_defaults"]["limits"]["step_rad"] = 1.0  # setpoints are 0.1 s ahead of the commands, or more
    for joint in arm["joints"][2:5]:
        joint["limits"] = {"lower_rad": -2.8, "upper_rad": 2.8}
    arm["buses"][0]["url"] = f"socketcan:{link.name}"
    return config


@pytest.fixture
def bridge(bridge_data, tmp_path):
    """Starts glenoid-bridge on the interface; `stop()` gives what it said and its log of frames."""
    try:
        path = program("glenoid-bridge")
    except InputError as error:
        pytest.skip(str(error))
    file, log = tmp_path / "bridge.yaml", tmp_path / "frames.log"
    file.write_text(yaml.safe_dump(bridge_data), encoding="utf-8")
    running = []

    def start(*arguments, before=()):
        """`before` is put in front of the program."""
        output = (tmp_path / "bridge.txt").open("w+")
        words = [*before, path, file, "--priority", "0", "--log", log, *arguments]
        process = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=output, stderr=subprocess.STDOUT)
        running.append(process)

        def stop():
            process.send_signal(signal.SIGTERM)
            process.wait(PATIENCE_S)
            output.seek(0)
            return output.read(), log

        return SimpleNamespace(process=process, stop=stop)

    yield start
    for process in running:
        process.kill()
        process.wait()
