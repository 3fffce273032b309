"""A second master on the bus that makes simulated drives misbehave, by their object 2F00h."""

from __future__ import annotations

import struct
import time
from typing import Any

import can

from glenoid.inputs import InputError
from glenoid.rehearse.scenario import FaultInput

INJECTION, PRODUCER_HEARTBEAT = 0x2F00, 0x1017
SDO_REQUEST = 0x600
#: numbers of 2F00h:01
KINDS = {
    "drive_drop": 1,
    "drive_delay": 2,
    "drive_vanish": 3,
    "bus_silent": 3,
    "drive_emcy": 4,
    "drive_reboot": 5,
    "drive_stuck_encoder": 6,
    "drive_bus_off": 7,
    "drive_jam": 8,
}
#: command byte of an expedited download by its size
DOWNLOAD = {1: 0x2F, 2: 0x2B, 4: 0x23}
#: a server answers one request before it takes the next
BETWEEN_S = 0.004


class SdoMaster:
    """Writes objects without waiting for the answers, which the bridge's own exchange is not disturbed by.

    Args:
        url: udp:GROUP[:PORT] or socketcan:NAME.

    """

    def __init__(self, url: str) -> None:
        kind, _, rest = url.partition(":")
        try:
            if kind == "socketcan":
                self._bus: Any = can.Bus(interface="socketcan", channel=rest)
            elif kind == "udp":
                group, _, port = rest.partition(":")
                self._bus = can.Bus(interface="udp_multicast", channel=group, port=int(port or 43113), hop_limit=0)
            else:
                raise InputError(f"real_time.bus = {url!r}: must be udp:GROUP[:PORT] or socketcan:NAME")
        except (OSError, can.CanError) as error:
            raise InputError(f"real_time.bus = {url!r}: {error}") from error

    def __enter__(self) -> SdoMaster:
        return self

    def __exit__(self, *_: object) -> None:
        self._bus.shutdown()

    def _write(self, node: int, index: int, sub: int, size: int, value: int) -> None:
        data = struct.pack("<BHBI", DOWNLOAD[size], index, sub, value)
        self._bus.send(can.Message(arbitration_id=SDO_REQUEST + node, data=data, is_extended_id=False))

    def inject(self, nodes: list[int], fault: FaultInput, begins: bool) -> None:
        """Starts or ends a fault of these drives."""
        amount = round(fault.figure * (1000.0 if fault.kind == "drive_delay" else 1.0))
        if begins:
            for sub, value in ((2, amount), (3, 0)):
                for node in nodes:
                    self._write(node, INJECTION, sub, 4, value)
                time.sleep(BETWEEN_S)
        for node in nodes:
            self._write(node, INJECTION, 1, 1, KINDS[fault.kind] if begins else 0)

    def silence_heartbeat(self, nodes: list[int]) -> None:
        """Takes the drives' heartbeats away."""
        for node in nodes:
            self._write(node, PRODUCER_HEARTBEAT, 0, 2, 0)
