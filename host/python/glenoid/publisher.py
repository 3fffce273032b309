"""For programs that make setpoints: the handshake with the bridge, stamps and sequence numbers.

    source = Publisher()
    source.arm(timeout_s=5.0)                      # drives enabled; raises BridgeError with the bridge's words otherwise
    source.publish(now_ns(), q_rad, dq_rad_per_s)  # begins where the arm is: source.feedback.position_rad
    source.request(command_v1_t.START)             # the bridge follows from now on; go on publishing at a steady rate
    source.request(command_v1_t.DISARM)

The bridge holds when the stream pauses for three of its periods, and stops when it ends. lcm_types/CHANNELS.md has the rules.
"""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable, Sequence
from typing import Protocol, TypeVar
from urllib.parse import parse_qs, urlsplit

import lcm

from glenoid.inputs import InputError
from glenoid.lcm_types import command_v1_t, device_v1_t, event_v1_t, feedback_v1_t, setpoint_v1_t, status_v1_t

DEFAULT_URL = "udpm://239.255.76.67:7667?ttl=0"
SETPOINT, FEEDBACK, STATUS = "GLENOID_SETPOINT", "GLENOID_FEEDBACK", "GLENOID_STATUS"
EVENT, COMMAND, DEVICE = "GLENOID_EVENT", "GLENOID_COMMAND", "GLENOID_DEVICE"
MOST_JOINTS = 16
STATES = {1: "IDLE", 2: "READY", 3: "RUN", 4: "HOLD", 5: "STOP", 6: "FAULT"}
#: LCM's queue keeps the oldest messages and drops the newest; it is emptied at every poll
QUEUE_CAPACITY = 4096
ASK_AGAIN_S = 0.5


class BridgeError(RuntimeError):
    """The bridge refuses, stopped, or does not answer; the text says which and what it said."""


class Message(Protocol):
    """A type of lcm_types."""

    def encode(self) -> bytes:
        """Bytes with the fingerprint in front."""


Kind = TypeVar("Kind", setpoint_v1_t, feedback_v1_t, status_v1_t, event_v1_t, command_v1_t, device_v1_t)


def now_ns() -> int:
    """CLOCK_MONOTONIC."""
    return time.clock_gettime_ns(time.CLOCK_MONOTONIC)


def checked_url(url: str, allow_network: bool = False) -> str:
    """The URL with its time to live written out.

    Raises:
        InputError: messages could leave this machine, and the network is not allowed.

    """
    if allow_network or url.startswith("memq://"):
        return url
    if not url.startswith("udpm://"):
        raise InputError(f"LCM URL {url!r}: only udpm:// and memq:// stay on this machine (--allow-network)")
    ttl = parse_qs(urlsplit(url).query).get("ttl")
    if ttl is None:
        return url + ("&" if "?" in url else "?") + "ttl=0"
    if ttl[-1] != "0":
        raise InputError(f"LCM URL {url!r}: ttl must be 0, so that setpoints stay on this machine (--allow-network)")
    return url


def decoded(kind: type[Kind], data: bytes) -> Kind | None:
    """A message of exactly this type, or None. All types have one length, which is checked before anything is decoded."""
    if len(data) != len(kind().encode()) or data[:8] != kind._get_packed_fingerprint():
        return None
    return kind.decode(data)


def text_of(characters: Sequence[int]) -> str:
    """UTF-8 up to the first zero."""
    return bytes(c & 0xFF for c in characters).partition(b"\0")[0].decode("utf-8", "replace")


class Publisher:
    """A source of setpoints. Not for several threads.

    Args:
        url: of LCM; must keep to this machine unless `allow_network`.
        allow_network: other transports and times to live too.

    Raises:
        InputError: see `checked_url`, or LCM cannot be opened.

    """

    def __init__(self, url: str = DEFAULT_URL, allow_network: bool = False) -> None:
        try:
            self._lcm = lcm.LCM(checked_url(url, allow_network))
        except RuntimeError as error:
            hint = "multicast needs a route: ip link set lo up; ip route add 224.0.0.0/4 dev lo"
            raise InputError(f"LCM {url}: {error}; {hint}") from error
        self.status: status_v1_t | None = None
        self.feedback: feedback_v1_t | None = None
        self.device: device_v1_t | None = None
        self.events: deque[str] = deque(maxlen=16)
        self._sequence = self._command_sequence = self._last_session = 0
        for channel, handler in (
            (STATUS, self._on_status),
            (FEEDBACK, self._on_feedback),
            (EVENT, self._on_event),
            (DEVICE, self._on_device),
        ):
            self._lcm.subscribe(channel, handler).set_queue_capacity(QUEUE_CAPACITY)

    def _on_status(self, _channel: str, data: bytes) -> None:
        self.status = decoded(status_v1_t, data) or self.status

    def _on_feedback(self, _channel: str, data: bytes) -> None:
        self.feedback = decoded(feedback_v1_t, data) or self.feedback

    def _on_device(self, _channel: str, data: bytes) -> None:
        self.device = decoded(device_v1_t, data) or self.device

    def _on_event(self, _channel: str, data: bytes) -> None:
        if (event := decoded(event_v1_t, data)) is not None and event.severity >= event_v1_t.WARNING:
            self.events.append(text_of(event.text))

    @property
    def session(self) -> int:
        """Token of the session; 0 before arming and when the bridge ended it."""
        return self.status.session if self.status is not None else 0

    @property
    def state(self) -> str:
        """State of the bridge, "SILENT" before its first status."""
        return STATES.get(self.status.state, "?") if self.status is not None else "SILENT"

    def poll(self, timeout_s: float = 0.0) -> bool:
        """Takes in all that arrived, waiting at most so long for the first message. False where none came."""
        heard = False
        wait_ms = max(0, math.ceil(1e3 * timeout_s))
        while self._lcm.handle_timeout(0 if heard else wait_ms) > 0:
            heard = True
        return heard

    def request(self, command: int) -> None:
        """Sends one of the constants of command_v1_t, with the token of the session."""
        message = command_v1_t()
        self._command_sequence += 1
        message.time_mono_ns, message.sequence = now_ns(), self._command_sequence
        message.session, message.command = self.session, command
        self._lcm.publish(COMMAND, message.encode())

    def await_status(self, timeout_s: float) -> status_v1_t:
        """The newest status. BridgeError where none comes."""
        return self._await(lambda: self.status, timeout_s, "no bridge: GLENOID_STATUS is silent")

    def await_device(self, timeout_s: float) -> device_v1_t:
        """What the bridge drives. BridgeError where it does not say."""
        complaint = "the bridge does not say what it drives: GLENOID_DEVICE is silent"
        return self._await(lambda: self.device, timeout_s, complaint)

    def _await(self, newest: Callable[[], Kind | None], timeout_s: float, complaint: str) -> Kind:
        end = time.monotonic() + timeout_s
        while (message := newest()) is None:
            if time.monotonic() > end:
                raise BridgeError(complaint)
            self.poll(0.05)
        return message

    def await_state(self, wanted: str, timeout_s: float, ask: int | None = None) -> None:
        """Waits for a state, asking for it by a command every half second. BridgeError with the bridge's words."""
        end, again = time.monotonic() + timeout_s, time.monotonic()
        while True:
            if ask is not None and time.monotonic() >= again:
                self.request(ask)
                again += ASK_AGAIN_S
            self.poll(0.02)
            if self.state == wanted:
                return
            if self.state in ("STOP", "FAULT") or time.monotonic() > end:
                raise BridgeError(self.complaint(f"did not come to {wanted}"))

    def arm(self, timeout_s: float = 5.0) -> None:
        """Has the drives enabled where they are, and takes the new token. BridgeError with the bridge's words."""
        self.await_status(timeout_s)
        self.await_state("READY", timeout_s, ask=command_v1_t.ARM)
        if self.session == 0:
            raise BridgeError(self.complaint("gave no token"))

    def complaint(self, what: str) -> str:
        """What the bridge did, its state, and what it said last."""
        fault = f", fault {self.status.fault}" if self.status is not None and self.status.fault else ""
        said = "; ".join(dict.fromkeys(list(self.events)[-3:]))
        return f"the bridge {what} (state {self.state}{fault})" + (f": {said}" if said else "")

    def publish(self, time_mono_ns: int, position_rad: Sequence[float], velocity_rad_per_s: Sequence[float]) -> None:
        """Where the joints shall be at an instant of CLOCK_MONOTONIC, in the order of exo.q.

        Raises:
            BridgeError: there is no session.
            ValueError: no joints or more than 16, lengths differ, or a value is not finite.

        """
        if self.session == 0:
            raise BridgeError(self.complaint("has no session"))
        data = setpoint_bytes(time_mono_ns, self._next_sequence(), self.session, position_rad, velocity_rad_per_s)
        self._lcm.publish(SETPOINT, data)

    def _next_sequence(self) -> int:
        if self._last_session != self.session:
            self._last_session, self._sequence = self.session, 0
        self._sequence += 1
        return self._sequence


def setpoint_bytes(
    time_mono_ns: int, sequence: int, session: int, position_rad: Sequence[float], velocity_rad_per_s: Sequence[float]
) -> bytes:
    """A setpoint message; see `Publisher.publish`."""
    count = len(position_rad)
    if not 1 <= count <= MOST_JOINTS or len(velocity_rad_per_s) != count:
        raise ValueError(f"{count} positions and {len(velocity_rad_per_s)} velocities: 1 to 16 of each, equally many")
    if not all(map(math.isfinite, (*position_rad, *velocity_rad_per_s))):
        raise ValueError("a setpoint must be finite")
    rest = (0.0,) * (MOST_JOINTS - count)
    message = setpoint_v1_t()
    message.time_mono_ns, message.sequence, message.session = time_mono_ns, sequence, session
    message.count, message.valid_mask = count, (1 << count) - 1
    message.position_rad, message.velocity_rad_per_s = (*position_rad, *rest), (*velocity_rad_per_s, *rest)
    return message.encode()
