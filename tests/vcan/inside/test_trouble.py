"""A bus that loses, delays, stalls or goes away, with simulated drives on it."""

import errno
import math
import socket
import struct
import time

import pytest

SETPOINTS = 100


def raw_socket(name):
    raw = socket.socket(socket.PF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
    raw.bind((name,))
    raw.setblocking(False)
    return raw


def frame(identifier, data):
    return struct.pack("=IB3x8s", identifier, len(data), data)


def setpoint(node, target):
    return frame(0x200 + node, struct.pack("<Hi", 0x06, target))


def test_loss_reaches_the_drives_at_its_rate(link, drives, master):
    running = drives("--nodes", "1")
    master.map_position(1)
    link.discipline("netem", "loss", "20%", "limit", 1000)
    sent, answered = 500, 0
    for _ in range(sent):
        master.send(0x080)
        answered += master.hear(0x181, 0.02) is not None
    link.discipline()
    # SYNC and answer each get through with 0.8; six standard deviations of a binomial
    mean, deviation = sent * 0.64, math.sqrt(sent * 0.64 * 0.36)
    assert abs(answered - mean) < 6 * deviation
    heard = running.stop()["drives"][0]["syncs"]
    assert answered <= heard < sent


def test_delay_is_seen_twice_in_an_answer(link, drives, master):
    drives("--nodes", "1")
    master.map_position(1)
    delay_s = 0.05
    link.discipline("netem", "delay", f"{delay_s * 1000:.0f}ms", "limit", 1000)
    begin = time.monotonic()
    master.send(0x080)
    assert master.hear(0x181) is not None
    assert time.monotonic() - begin >= 2 * delay_s


def test_a_bus_of_1_Mbit_refuses_a_burst_and_the_drives_stay(link, drives, master):
    drives("--nodes", "1")
    master.read(1, 0x1000)
    link.discipline("tbf", "rate", "1152kbit", "burst", 32, "limit", 160)
    refusals, taken = [], 0
    begin = time.monotonic()
    with raw_socket(link.name) as raw:
        while not refusals and time.monotonic() - begin < 20.0:  # a slow machine may not fill the queue in one burst
            for k in range(200):
                try:
                    raw.send(frame(0x555, bytes((k,))))
                    taken += 1
                except OSError as error:
                    refusals.append(error.errno)
    passed_s = time.monotonic() - begin
    assert refusals
    assert set(refusals) <= {errno.ENOBUFS, errno.EAGAIN}
    # 16 bytes a frame: no more than the queue and the burst hold and the rate lets through
    assert taken <= (160 + 32) / 16 + passed_s * 1152e3 / (8 * 16) + 1
    time.sleep(0.1)
    assert master.read(1, 0x1000) & 0xFFFF == 0x0192


def test_drives_come_back_with_the_link(link, drives, master):
    running = drives("--nodes", "1")
    master.read(1, 0x1000)
    link.set("down")
    time.sleep(0.3)
    assert running.process.poll() is None
    link.set("up")
    master.forget_error()
    assert master.read(1, 0x1000) & 0xFFFF == 0x0192


@pytest.mark.parametrize("purged", [True, False], ids=["purged", "as the kernel leaves it"])
def test_setpoints_behind_a_stalled_bus(link, drives, master, purged):
    """The writer dies while 100 setpoints wait. After the purge (link down and up) none may reach the drive; without it all
    do, which shows that the danger is real."""
    running = drives("--nodes", "1")
    master.map_position(1)
    before = master.read(1, 0x607A)
    link.discipline("netem", "delay", "3s", "limit", 1000)
    with raw_socket(link.name) as raw:
        for k in range(SETPOINTS):
            raw.send(setpoint(1, 1000 + k))
    if purged:
        link.set("down")
        link.set("up")
        master.forget_error()
    time.sleep(3.5)
    link.discipline()
    stale = [m for m in master.drain() if m.arbitration_id == 0x201]
    master.send(0x080)
    after = master.read(1, 0x607A)
    taken = running.stop()["drives"][0]["setpoints"]
    if purged:
        assert (len(stale), after, taken) == (0, before, 0)
    else:
        assert (len(stale), after, taken) == (SETPOINTS, 1000 + SETPOINTS - 1, 1)
