"""The bus over UDP with python-can as the peer, both ways."""

import json
import random
import subprocess

import can
from glenoid.programs import program

COUNT = 200
PATIENCE_S = 20.0


def as_dict(message):
    return {
        "id": message.arbitration_id,
        "extended": message.is_extended_id,
        "remote": message.is_remote_frame,
        "size": message.dlc,
        "data": bytes(message.data).hex(),
    }


def random_messages(seed):
    source = random.Random(seed)
    for _ in range(COUNT):
        extended, remote, size = source.random() < 0.5, source.random() < 0.1, source.randrange(9)
        yield can.Message(
            arbitration_id=source.randrange(2**29 if extended else 2**11),
            is_extended_id=extended,
            is_remote_frame=remote,
            dlc=size,
            data=None if remote else source.randbytes(size),
        )


def test_python_can_and_the_port_understand_each_other(bus_address, python_bus):
    group, port = bus_address
    command = [program("wires_probe"), "exchange", f"udp:{group}:{port}", "7", str(COUNT)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as probe:
        assert json.loads(probe.stdout.readline()) == {"ready": True}
        probe.stdin.write("\n")
        probe.stdin.flush()
        sent = [json.loads(probe.stdout.readline()) for _ in range(COUNT)]
        heard = []
        while len(heard) < COUNT and (message := python_bus.recv(PATIENCE_S)) is not None:
            heard.append(as_dict(message))
        assert heard == sent

        messages = list(random_messages(8))
        for message in messages:
            python_bus.send(message)
        got = [json.loads(probe.stdout.readline()) for _ in range(COUNT)]
        assert got == [as_dict(message) for message in messages]
        assert probe.wait(PATIENCE_S) == 0


def test_frames_of_another_group_are_not_heard(bus_address):
    group, port = bus_address
    command = [program("wires_probe"), "exchange", f"udp:{group}:{port}", "7", "1"]
    with (
        can.Bus("239.74.163.99", interface="udp_multicast", port=port) as elsewhere,
        can.Bus(group, interface="udp_multicast", port=port) as here,
        subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as probe,
    ):
        probe.stdout.readline()
        probe.stdin.write("\n")
        probe.stdin.flush()
        probe.stdout.readline()
        elsewhere.send(can.Message(arbitration_id=0x99, is_extended_id=False))
        here.send(can.Message(arbitration_id=0x11, is_extended_id=False))
        assert json.loads(probe.stdout.readline())["id"] == 0x11
        assert probe.wait(PATIENCE_S) == 0
