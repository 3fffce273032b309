"""A rehearsal in real time: the programs glenoid-bridge and glenoid-drives, LCM and a bus, as in earnest."""

from __future__ import annotations

import signal
import socket
import tempfile
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import lcm

from glenoid.inputs import InputError
from glenoid.lcm_types import command_v1_t, setpoint_v1_t
from glenoid.publisher import SETPOINT, BridgeError, Publisher, checked_url, now_ns
from glenoid.rehearse.heard import heard_record
from glenoid.rehearse.motion import Motion
from glenoid.rehearse.programs import Programs, programs, realtime_source
from glenoid.rehearse.record import Record
from glenoid.rehearse.scenario import FaultInput, Scenario
from glenoid.rehearse.sdo import SdoMaster
from glenoid.rehearse.stream import Stream, make_stream, with_faults
from glenoid.rehearse.virtual import AFTER_STOP_S

ARM_WAIT_S, IDLE_WAIT_S, TAIL_S = 10.0, 3.0, 0.1
#: the start is held so long, and START asked for so often meanwhile, until a busy machine has taken it
LEAD_S, ASK_AGAIN_S = 1.5, 0.25
#: a setpoint that is later than this is left out, not sent in a burst: as many periods
LATE_PERIODS = 2
ONLY_VIRTUAL = ("master_heartbeat_lost", "bus_stalled", "link_down")


@dataclass
class Heard:
    """All messages of the bridge, as they came: time of arrival, channel, bytes."""

    messages: list[tuple[int, str, bytes]] = field(default_factory=list)

    def take(self, channel: str, data: bytes) -> None:
        """A message."""
        self.messages.append((now_ns(), channel, data))


class Ears:
    """Hears every channel in a thread of its own."""

    def __init__(self, url: str) -> None:
        self.heard = Heard()
        self._lcm = lcm.LCM(checked_url(url))
        self._lcm.subscribe("GLENOID_.*", self.heard.take).set_queue_capacity(8192)
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._listen, daemon=True)

    def _listen(self) -> None:
        while not self._over.is_set():
            self._lcm.handle_timeout(50)

    def __enter__(self) -> Heard:
        self._thread.start()
        return self.heard

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join()


def encoded(stream: Stream, origin_ns: int, session: int) -> list[bytes]:
    """Every setpoint as it will be sent, whatever is wrong with it."""
    joints = stream.position_rad.shape[1]
    rest = (0.0,) * (16 - joints)
    out = []
    for k in range(len(stream.due_ns)):
        message = setpoint_v1_t()
        message.time_mono_ns = int(stream.stamp_ns[k]) + origin_ns
        message.sequence, message.session = int(stream.sequence[k]), session ^ int(stream.session_xor[k])
        message.count, message.valid_mask = joints, (1 << joints) - 1
        message.position_rad = (*stream.position_rad[k].tolist(), *rest)
        message.velocity_rad_per_s = (*stream.velocity_rad_per_s[k].tolist(), *rest)
        out.append(message.encode())
    return out


class Trouble:
    """Injects the faults that are not in the stream, each when its time has come."""

    def __init__(self, scenario: Scenario, publisher: Publisher, running: Programs, sdo: SdoMaster) -> None:
        self._publisher, self._running, self._sdo = publisher, running, sdo
        self._nodes = {str(joint["name"]): int(joint["node"]) for joint in scenario.config.joints}
        self._due: list[tuple[float, FaultInput, bool]] = []
        for fault in scenario.data.faults:
            if fault.kind.startswith("stream_"):
                continue
            self._due.append((fault.at_s, fault, True))
            if fault.duration_s is not None:
                self._due.append((fault.at_s + fault.duration_s, fault, False))
        self._due.sort(key=lambda item: item[0])

    def act(self, seconds: float) -> None:
        """Does what is due."""
        while self._due and self._due[0][0] <= seconds:
            _, fault, begins = self._due.pop(0)
            self._one(fault, begins)

    def _one(self, fault: FaultInput, begins: bool) -> None:
        nodes = list(self._nodes.values()) if fault.joint is None else [self._nodes[fault.joint]]
        if fault.kind == "estop" and begins:
            self._publisher.request(command_v1_t.ESTOP)
        elif fault.kind == "estop_input" and begins:
            self._running.bridge.send_signal(signal.SIGUSR1)
        elif fault.kind == "drive_heartbeat_lost" and begins:
            self._sdo.silence_heartbeat(nodes)
        elif fault.kind.startswith("drive_") or fault.kind == "bus_silent":
            self._sdo.inject(nodes, fault, begins)


def send(
    publisher: Publisher,
    sender: lcm.LCM,
    stream: Stream,
    origin_ns: int,
    period_ns: int,
    trouble: Trouble,
    tell: Callable[[float], None],
) -> list[int]:
    """Sends every setpoint when it is due, until the bridge has been stopped for a while. Instants of sending, 0: left out."""
    due = stream.due_ns.tolist()
    messages = encoded(stream, origin_ns, publisher.session)
    sent = [0] * len(due)
    ask_ns, stopped_ns = -0.9e9 * LEAD_S, 0
    end_ns = stream.end_ns if due else 0
    for k, message in enumerate(messages):
        while (left_ns := due[k] + origin_ns - now_ns()) > 0:
            time.sleep(min(1e-9 * left_ns, 2e-3))
            trouble.act(1e-9 * (now_ns() - origin_ns))
        trouble.act(1e-9 * (now_ns() - origin_ns))
        if left_ns > -LATE_PERIODS * period_ns:
            sender.publish(SETPOINT, message)
            sent[k] = now_ns()
        publisher.poll()
        if publisher.state == "READY" and ask_ns <= due[k] < 0:
            publisher.request(command_v1_t.START)
            ask_ns = due[k] + 1e9 * ASK_AGAIN_S
        if publisher.state in ("STOP", "FAULT"):
            stopped_ns = stopped_ns or now_ns()
            if now_ns() - stopped_ns > 1e9 * AFTER_STOP_S:
                break
        if k % 100 == 0:
            tell(max(0.0, due[k] / max(1, end_ns)))
    return sent


def wait_out(publisher: Publisher, trouble: Trouble, origin_ns: int, until_ns: int) -> None:
    """Goes on listening where the stream ended before the motion: the source fell silent."""
    while now_ns() < until_ns:
        publisher.poll(0.005)
        trouble.act(1e-9 * (now_ns() - origin_ns))


def disarm(publisher: Publisher, stages: list[str]) -> None:
    """Comes to rest and disarms; a latched stop is only watched until its power is gone."""
    if publisher.state in ("STOP", "FAULT"):
        end_ns = now_ns() + round(1e9 * AFTER_STOP_S)
        while now_ns() < end_ns:
            publisher.poll(0.01)
        return
    try:
        publisher.request(command_v1_t.DISARM)
        publisher.await_state("IDLE", IDLE_WAIT_S)
    except BridgeError as error:
        stages.append(str(error))
    end_ns = now_ns() + round(1e9 * TAIL_S)
    while now_ns() < end_ns:
        publisher.poll(0.01)


def refuse_what_needs_virtual_time(scenario: Scenario) -> None:
    """InputError for faults that the real programs cannot be given."""
    for k, fault in enumerate(scenario.data.faults):
        if fault.kind in ONLY_VIRTUAL:
            raise InputError(f"{scenario.path}: faults.{k}.kind = {fault.kind!r}: only in virtual time")


def own_port() -> int:
    """A UDP port nobody uses now."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("", 0))
        return int(probe.getsockname()[1])


def run_real_time(scenario: Scenario, motion: Motion, tell: Callable[[str, float], None]) -> Record:
    """Start-up, arming, the movements, disarming, with the real programs.

    Args:
        scenario: what to do.
        motion: of the source, a sample every setpoint period.
        tell: is told the stage and its share done.

    Raises:
        InputError: a program is missing or refuses its configuration, or LCM cannot be opened.

    """
    refuse_what_needs_virtual_time(scenario)
    config, given = scenario.config, scenario.data.real_time.placed(own_port())
    stages: list[str] = []
    sent: list[int] = []
    stream = with_faults(make_stream(motion, config.setpoint_period_ns, LEAD_S), scenario.data.faults, scenario.joints)
    origin_ns = now_ns()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        publisher = Publisher(given.lcm_url)
        with Ears(given.lcm_url) as heard:
            with programs(scenario, motion, given, folder) as running, SdoMaster(given.bus) as sdo:
                tell("start-up of the drives", 0.0)
                try:
                    wait_until_configured(publisher)
                    publisher.arm(ARM_WAIT_S)
                except BridgeError as error:
                    stages.append(str(error))
                else:
                    origin_ns = now_ns() + round(1e9 * LEAD_S)
                    trouble = Trouble(scenario, publisher, running, sdo)
                    with realtime_source(given.priority):
                        sent = send(
                            publisher,
                            lcm.LCM(checked_url(given.lcm_url)),
                            stream,
                            origin_ns,
                            config.setpoint_period_ns,
                            trouble,
                            lambda share: tell("movements", share),
                        )
                    length_ns = round(1e9 * motion.rows * motion.period_s)
                    if publisher.state not in ("STOP", "FAULT"):
                        wait_out(publisher, trouble, origin_ns, min(origin_ns + length_ns, now_ns() + round(2e9)))
                    disarm(publisher, stages)
            messages = list(heard.messages)
        return heard_record(
            scenario, messages, stream, sent, origin_ns, stages, read_frames(running.frames), running.counters()
        )


def wait_until_configured(publisher: Publisher) -> None:
    """BridgeError where the drives do not become operational."""
    end = time.monotonic() + ARM_WAIT_S
    while not publisher.await_status(ARM_WAIT_S).configured:
        if time.monotonic() > end:
            raise BridgeError(publisher.complaint("did not configure every drive"))
        publisher.poll(0.02)


def read_frames(path: Path) -> list[Any]:
    """Frames of a candump log, times as ns of CLOCK_MONOTONIC."""
    import can

    offset_ns = time.time_ns() - now_ns()
    with can.CanutilsLogReader(str(path)) as log:
        return [(round(1e6 * message.timestamp) * 1000 - offset_ns, message) for message in log]
