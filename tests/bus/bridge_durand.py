"""Six drives that this project did not write: durand's CANopen slaves (PyPI), with a CiA 402 state machine on top.

Runs until SIGTERM and prints what each drive counted as JSON. durand has no heartbeat consumer: 1016h is added here.
"""

import argparse
import contextlib
import heapq
import itertools
import json
import os
import signal
import socket
import sys
import time
from pathlib import Path

import can
import durand
from durand import MinimalNode, Record, Variable
from durand.datatypes import DatatypeEnum as Type
from durand.network import NetworkABC
from durand.scheduler import AbstractScheduler
from durand.services.nmt import StateEnum

MASTER_HEARTBEAT = 0x77F
SO_RCVBUFFORCE = 33  # Linux; Python has no name for it


class Scheduler(AbstractScheduler):
    """durand's timers, run by the loop below."""

    def __init__(self):
        self.entries, self.number, self.cancelled = [], itertools.count(), set()

    def add(self, delay, callback, args=(), kwargs=None):
        entry = next(self.number)
        heapq.heappush(self.entries, (time.monotonic() + delay, entry, callback, args, kwargs or {}))
        return entry

    def cancel(self, entry):
        self.cancelled.add(entry)

    @property
    def lock(self):
        raise NotImplementedError

    def run_due(self):
        while self.entries and self.entries[0][0] <= time.monotonic():
            _, entry, callback, args, kwargs = heapq.heappop(self.entries)
            if entry in self.cancelled:
                self.cancelled.discard(entry)
            else:
                callback(*args, **kwargs)


class FanOut(NetworkABC):
    """durand's network for one of several nodes on one bus: each has its own callbacks."""

    def __init__(self, bus):
        self.bus, self.callbacks = bus, {}

    def add_subscription(self, cob_id, callback):
        self.callbacks[cob_id] = callback

    def remove_subscription(self, cob_id, callback=None):
        self.callbacks.pop(cob_id, None)

    def send(self, cob_id, msg):
        self.bus.send(can.Message(arbitration_id=cob_id, data=bytes(msg), is_extended_id=False))

    def receive(self, message):
        callback = self.callbacks.get(message.arbitration_id)
        if callback is not None:
            callback(message.arbitration_id, bytes(message.data))


def rows():
    """Objects beside durand's own: index, sub, type, value."""
    yield 0x1016, 1, Type.UNSIGNED32, 0
    yield 0x1029, 1, Type.UNSIGNED8, 0
    yield 0x6007, 0, Type.INTEGER16, 1
    yield 0x605A, 0, Type.INTEGER16, 2
    yield 0x605E, 0, Type.INTEGER16, 2
    yield 0x6040, 0, Type.UNSIGNED16, 0
    yield 0x6041, 0, Type.UNSIGNED16, 0x0240
    yield 0x6060, 0, Type.INTEGER8, 0
    yield 0x6061, 0, Type.INTEGER8, 0
    yield 0x6064, 0, Type.INTEGER32, 0
    yield 0x6065, 0, Type.UNSIGNED32, 0
    yield 0x6066, 0, Type.UNSIGNED16, 0
    yield 0x6077, 0, Type.INTEGER16, 0
    yield 0x607A, 0, Type.INTEGER32, 0
    yield 0x607D, 1, Type.INTEGER32, 0
    yield 0x607D, 2, Type.INTEGER32, 0
    yield 0x60C2, 1, Type.UNSIGNED8, 0
    yield 0x60C2, 2, Type.INTEGER8, 0
    yield 0x6502, 0, Type.UNSIGNED32, 0x3A5


class Drive:
    """One durand node and the motor it pretends to have: it is at its target with the next SYNC."""

    def __init__(self, bus, number):
        self.network = FanOut(bus)
        self.node = MinimalNode(self.network, number)
        self.od = self.node.object_dictionary
        for index, sub, kind, value in rows():
            if sub == 0:
                self.od[index] = Variable(kind, "rw", value)
            else:
                if index not in self.od:
                    self.od[index] = Record()
                self.od[index][sub] = Variable(kind, "rw", value)
        self.od[0x1000] = Variable(Type.UNSIGNED32, "ro", 0x00020192)
        self.od.update_callbacks[(0x6040, 0)].add(self.control)
        self.od.update_callbacks[(0x607A, 0)].add(self.move)
        self.od.update_callbacks[(0x6060, 0)].add(lambda value: self.od.write(0x6061, 0, value))
        self.node.sync.callbacks.add(self.count_sync)
        self.master_heard = None
        self.network.add_subscription(MASTER_HEARTBEAT, self.hear_master)
        self.number, self.state, self.target_came = number, 0x40, False
        self.counts = {"syncs": 0, "missed_cycles": 0, "setpoints": 0, "moves": 0, "heartbeat_losses": 0}
        self.largest_step, self.first_position, self.span = 0, None, [0, 0]

    def write_status(self):
        following = 0x1000 if self.state == 0x27 else 0
        self.od.write(0x6041, 0, 0x0200 | self.state | following)

    def control(self, word):
        state = self.state
        if state == 0x08:
            state = 0x40 if word & 0x80 else 0x08
        elif not word & 0x02:
            state = 0x40
        elif not word & 0x04:
            state = 0x07 if state in (0x27, 0x07) else 0x40
        elif word & 0x0F == 0x06:
            state = 0x21
        elif word & 0x0F == 0x07 and state in (0x21, 0x23, 0x27):
            state = 0x23
        elif word & 0x0F == 0x0F and state in (0x23, 0x27):
            state = 0x27
        self.state = state
        self.write_status()

    def move(self, target):
        self.target_came = True
        self.counts["setpoints"] += 1
        if self.state != 0x27:
            return
        step = target - self.od.read(0x6064, 0)
        self.largest_step = max(self.largest_step, abs(step))
        self.counts["moves"] += step != 0
        self.span = [min(self.span[0], target), max(self.span[1], target)]
        self.od.write(0x6064, 0, target)

    def count_sync(self):
        self.counts["syncs"] += 1
        if self.state == 0x27 and not self.target_came:
            self.counts["missed_cycles"] += 1
        self.target_came = False

    def hear_master(self, _cob_id, _data):
        self.master_heard = time.monotonic()

    def watch_master(self):
        """Heartbeat consumer: 8130h, quick stop, pre-operational."""
        wait_s = 1e-3 * (self.od.read(0x1016, 1) & 0xFFFF)
        if not wait_s or self.master_heard is None or time.monotonic() - self.master_heard < wait_s:
            return
        self.master_heard = None
        self.counts["heartbeat_losses"] += 1
        if self.state == 0x27:
            self.state = 0x07
            self.write_status()
        self.node.emcy.set(0x8130, 0x11)
        self.node.nmt.set_state(StateEnum.PRE_OPERATIONAL)

    def report(self):
        return self.counts | {
            "node": self.number,
            "state": self.state,
            "position": self.od.read(0x6064, 0),
            "largest_step": self.largest_step,
            "span": self.span,
            "following_window": self.od.read(0x6065, 0),
        }


def dropped(udp_socket):
    """Datagrams the kernel threw away because this process did not read them in time."""
    inode = str(os.fstat(udp_socket.fileno()).st_ino)
    lines = Path("/proc/net/udp").read_text().splitlines()[1:]
    return sum(int(line.split()[-1]) for line in lines if line.split()[9] == inode)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--group", default="239.74.163.2")
    parser.add_argument("--port", type=int, default=43113)
    parser.add_argument("--drives", type=int, default=6)
    options = parser.parse_args()
    scheduler = Scheduler()
    durand.set_scheduler(scheduler)
    over = []
    signal.signal(signal.SIGTERM, lambda *_: over.append(True))
    with can.Bus(options.group, interface="udp_multicast", port=options.port, receive_own_messages=False) as bus:
        udp_socket = socket.socket(fileno=os.dup(bus.fileno()))
        for option in (socket.SO_RCVBUF, SO_RCVBUFFORCE):
            with contextlib.suppress(OSError):
                udp_socket.setsockopt(socket.SOL_SOCKET, option, 16 * 1024 * 1024)
        drives = [Drive(bus, number) for number in range(1, options.drives + 1)]
        print("ready", file=sys.stderr, flush=True)
        while not over:
            message = bus.recv(0.005)
            if message is not None and not message.is_error_frame:
                for drive in drives:
                    drive.network.receive(message)
            scheduler.run_due()
            for drive in drives:
                drive.watch_master()
        lost = dropped(udp_socket)
    print(json.dumps([drive.report() | {"dropped": lost} for drive in drives]))


if __name__ == "__main__":
    main()
