"""Emergency stop while the bus is stalled: glenoid-bridge, a source of setpoints and six glenoid-drives in motion."""

import math
import shutil
import signal
import struct
import subprocess
import time
from types import SimpleNamespace

import pytest
from glenoid.lcm_types import command_v1_t
from glenoid.publisher import Publisher, now_ns

PERIOD_S = 0.02  # of the bridge
AMPLITUDE_RAD, RATE_RAD_PER_S = 0.2, 4.0
SPEED_RAD_PER_S = AMPLITUDE_RAD * RATE_RAD_PER_S
PATIENCE_S = 30.0
COUNTS_PER_RAD = 100 * 16384 / (2 * math.pi)
FOLLOW = 0x0F  # controlword "enable operation": with it the drive follows the target
BRAKE_RAD_PER_S2 = 4.0  # less than any quick stop here takes


class Source:
    """Setpoints of a swing, 50 a second, for all joints alike."""

    def __init__(self):
        self.publisher = Publisher()
        self.begin = None

    def stream(self, seconds, until=()):
        """Sends for so long, or until the bridge is in one of the states."""
        end = time.monotonic() + seconds
        while time.monotonic() < end and self.publisher.state not in until:
            if self.begin is None:
                self.begin = time.monotonic()
            phase = RATE_RAD_PER_S * (time.monotonic() - self.begin)
            if self.publisher.session != 0:
                self.publisher.publish(
                    now_ns(),
                    [AMPLITUDE_RAD * (1.0 - math.cos(phase))] * 6,
                    [SPEED_RAD_PER_S * math.sin(phase)] * 6,
                )
            self.publisher.poll(PERIOD_S)

    def set_in_motion(self):
        self.publisher.arm(PATIENCE_S)
        self.publisher.publish(now_ns(), [0.0] * 6, [0.0] * 6)
        self.publisher.request(command_v1_t.START)
        self.stream(PATIENCE_S, until=("RUN",))
        assert self.publisher.state == "RUN", self.publisher.complaint("did not start")
        self.stream(0.6)


def rpdos(log):
    """(time in s, node, controlword, target in rad) of every RPDO1 of a log in candump's format."""
    out = []
    for line in log.read_text().splitlines():
        stamp, _, text = line.split()[:3]
        identifier, data = text.split("#")
        if int(identifier, 16) & 0x780 == 0x200:
            word, target = struct.unpack("<Hi", bytes.fromhex(data))
            out.append((float(stamp[1:-1]), int(identifier, 16) & 0x7F, word, target / COUNTS_PER_RAD))
    return out


def sent_by_master(log, until_s=math.inf):
    """How many SYNCs and RPDO1s a log holds up to an instant."""
    words = [line.split() for line in log.read_text().splitlines()]
    identifiers = [int(text.split("#")[0], 16) for stamp, _, text, *_ in words if float(stamp[1:-1]) <= until_s]
    return sum(identifier == 0x080 or identifier & 0x780 == 0x200 for identifier in identifiers)


def to_follow(frames, since_s):
    """Those that ask a drive to follow, from an instant on."""
    return [frame for frame in frames if frame[0] > since_s and frame[2] & FOLLOW == FOLLOW]


@pytest.fixture
def ears(link, tmp_path):
    """candump of what truly was on the bus."""
    if shutil.which("candump") is None:
        pytest.skip("no candump: apt-get install can-utils")
    log = tmp_path / "heard.log"
    with log.open("w") as into:
        process = subprocess.Popen(["candump", "-D", "-L", f"{link.name},200:780,080:7FF"], stdout=into)

    def heard():
        process.send_signal(signal.SIGINT)
        process.wait(PATIENCE_S)
        return rpdos(log)

    yield SimpleNamespace(stop=heard, log=log)
    process.kill()
    process.wait()


def stall(link, how):
    if how == "link down":
        link.set("down")
    elif how == "tbf":  # a burst of 8 frames, about half a cycle, then one in 16 s
        link.discipline("tbf", "rate", "8bit", "burst", 8 * 16, "limit", 16000)
    else:
        link.discipline("netem", "delay", "2s")


def recover(link, how):
    """The bus carries frames again: what is still queued first."""
    if how == "link down":
        link.set("up")
    elif how == "tbf":
        link.discipline("tbf", "rate", "1152kbit", "burst", 1600, "limit", 16000)
    else:
        time.sleep(2.2)
        link.discipline()


def run(link, how, pressed, own, source):
    """In motion, stall, emergency stop, recovery. When it was pressed, by the clock on the wall."""
    source.set_in_motion()
    stall(link, how)
    source.stream(2.5 * PERIOD_S)  # setpoints pile up
    pressed_s = time.time()
    if pressed == "button":
        own.process.stdin.write(b"\n")
        own.process.stdin.flush()
    else:
        source.publisher.request(command_v1_t.ESTOP)
    source.stream(2.0, until=("STOP", "FAULT"))
    assert source.publisher.state in ("STOP", "FAULT"), source.publisher.complaint("did not stop")
    source.stream(0.3)  # the source does not know, and goes on
    recover(link, how)
    source.stream(0.7)
    return pressed_s


def check_nothing_stale(frames, report, pressed_s):
    """No order to follow, and the drives stand at the last target that was on the bus."""
    assert to_follow(frames, pressed_s) == []
    for one in report["drives"]:
        last = [f for f in to_follow(frames, 0.0) if f[1] == one["node"]][-1]
        # The last one may have waited for a SYNC in vain, or the quick stop found the drive on its way and took its ramp.
        may = SPEED_RAD_PER_S * PERIOD_S + SPEED_RAD_PER_S**2 / (2 * BRAKE_RAD_PER_S2)
        assert abs(one["position_rad"] - last[3]) < may, (one["node"], one["position_rad"], last)
        assert one["setpoints"] <= len([f for f in frames if f[1] == one["node"]])


@pytest.mark.parametrize(("how", "pressed"), [("tbf", "message"), ("netem", "button"), ("link down", "message")])
def test_no_queued_setpoint_moves_a_drive(link, bridge, drives, patient, ears, how, pressed):
    running = drives("--nodes", "1-6", "--profile", patient)
    own, source = bridge("--estop-stdin"), Source()
    pressed_s = run(link, how, pressed, own, source)
    source.publisher.request(command_v1_t.ARM)
    source.stream(0.5)
    assert source.publisher.state in ("STOP", "FAULT"), "latched"
    report, (said, log) = running.stop(), own.stop()
    frames = ears.stop()
    if how == "netem":
        assert sent_by_master(log) > sent_by_master(ears.log), (
            "some were handed to the kernel and never were on the bus"
        )
    assert max(abs(f[3]) for f in frames) > 0.05, "the arm moved" + said
    check_nothing_stale(frames, report, pressed_s)


def test_without_the_right_to_purge_they_would_and_the_bridge_says_so(link, bridge, drives, patient, ears):
    """The same with a bridge that may not take the link down: the danger is real, and it asks for help instead of arming."""
    if shutil.which("setpriv") is None:
        pytest.skip("no setpriv: apt-get install util-linux")
    drives("--nodes", "1-6", "--profile", patient)
    own = bridge("--estop-stdin", before=["setpriv", "--bounding-set=-net_admin", "--inh-caps=-net_admin"])
    source = Source()
    source.set_in_motion()
    stall(link, "netem")
    source.stream(2.5 * PERIOD_S)
    pressed_s = time.time()
    own.process.stdin.write(b"\n")
    own.process.stdin.flush()
    source.stream(2.0, until=("STOP", "FAULT"))
    source.stream(0.3)
    assert source.publisher.status.purge_needed, own.stop()
    source.publisher.request(command_v1_t.RESET_FAULT)
    source.stream(0.3)
    source.publisher.request(command_v1_t.ARM)
    source.stream(0.3)
    assert source.publisher.state != "READY"
    recover(link, "netem")
    time.sleep(0.5)
    _, log = own.stop()
    ears.stop()
    assert sent_by_master(ears.log) >= sent_by_master(log, pressed_s), "all that was queued reached the bus in the end"
