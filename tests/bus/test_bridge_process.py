"""The program glenoid-bridge with six drives of another project (durand), on UDP: motion, decoders, and what a process can suffer.

GLENOID_TEST_BRIDGE_SECONDS  length of the motion (8)
"""

import json
import math
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import lcm
import pytest
import yaml
from glenoid.lcm_types import command_v1_t, figures_v1_t
from glenoid.programs import program
from glenoid.publisher import Publisher, now_ns

HERE = Path(__file__).parent
SECONDS = float(os.environ.get("GLENOID_TEST_BRIDGE_SECONDS", "8"))
PERIOD_MS = 2
AMPLITUDE_RAD, RATE_RAD_PER_S = 0.3, 1.5
COUNTS_PER_RAD = 100 * 16384 / (2 * math.pi)
NODES = range(1, 7)

# Waits of this machine are the machine's: patient supervision, so that only what is under test can stop the motion.
PATIENT = {
    "setpoints": {
        "period_ms": 10,
        "delay_ms": 60,
        "hold_after_ms": 400,
        "quick_stop_after_ms": 900,
        "disarm_after_ms": 1500,
        "max_age_ms": 900,
    },
    "heartbeat": {
        "master_period_ms": 20,
        "drive_waits_ms": 1000,
        "drive_period_ms": 100,
        "drive_timeout_ms": 3000,
    },
    "supervision": {"feedback_misses": 500, "transmit_skips": 100, "sdo_timeout_ms": 1000, "state_timeout_ms": 5000},
}


def configuration(url, **changes):
    return {
        "exoskeletons": {
            "six": {
                "sync": {"period_ms": PERIOD_MS, "rpdo_phase": 0.6},
                **(PATIENT | changes),
                "buses": [{"name": "arm", "url": url}],
                "joint_defaults": {
                    "bus": "arm",
                    "gear": {"ratio": 100, "sign": 1, "encoder_counts_per_turn": 16384},
                    "limits": {
                        "lower_rad": -1.5,
                        "upper_rad": 1.5,
                        "velocity_rad_per_s": 2.0,
                        "acceleration_rad_per_s2": 20.0,
                    },
                    "following_error": {"window_rad": 0.5, "time_ms": 2000},
                },
                "joints": [{"name": f"joint{n}", "node": n} for n in NODES],
            }
        }
    }


class Bridge:
    """A running glenoid-bridge, its drives and a source of setpoints."""

    def __init__(self, tmp_path, address, changes=None, arguments=()):
        group, port = address
        self.log, self.stats = tmp_path / "frames.log", tmp_path / "stats.json"
        config = tmp_path / "six.yaml"
        config.write_text(yaml.safe_dump(configuration(f"udp:{group}:{port}", **(changes or {}))))
        self.drives = subprocess.Popen(
            [sys.executable, HERE / "bridge_durand.py", "--group", group, "--port", str(port)],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        assert self.drives.stderr.readline() == "ready\n"
        self.lcm_url = url = f"udpm://239.255.76.67:{port + 6000}?ttl=0"
        self.output = (tmp_path / "bridge.txt").open("w+")
        self.process = subprocess.Popen(
            [program("glenoid-bridge"), config, "--log", self.log, "--stats", self.stats, "--lcm-url", url, *arguments],
            stdout=self.output,
            stderr=subprocess.STDOUT,
            stdin=subprocess.PIPE,
        )
        self.source = Publisher(url)

    def said(self):
        self.output.seek(0)
        return "\n".join(line for line in self.output.read().splitlines() if "read back" not in line)

    def arm(self):
        self.source.await_status(20)
        end = time.monotonic() + 30
        while self.said().count(" operational") < len(NODES):
            assert time.monotonic() < end, self.said()
            self.source.poll(0.1)
        time.sleep(0.1)
        self.source.arm(20)
        self.begin_ns = now_ns()

    def motion(self, time_ns):
        t = 1e-9 * (time_ns - self.begin_ns)
        angle = AMPLITUDE_RAD * (1 - math.cos(RATE_RAD_PER_S * t))
        speed = AMPLITUDE_RAD * RATE_RAD_PER_S * math.sin(RATE_RAD_PER_S * t)
        return [angle] * 6, [speed] * 6

    def stream(self, seconds, until=None):
        """Setpoints every 10 ms for so long, or until the bridge is in one of these states."""
        begin = time.monotonic()
        number = 0
        while time.monotonic() - begin < seconds:
            at_ns = now_ns()
            if self.source.session:
                self.source.publish(at_ns, *self.motion(at_ns))
            self.source.poll()
            if until and self.source.state in until:
                return
            number += 1
            time.sleep(max(0.0, begin + 0.01 * number - time.monotonic()))

    def run(self, seconds=1.0):
        self.arm()
        self.stream(0.1)
        self.source.request(command_v1_t.START)
        self.stream(5.0, until=("RUN",))
        assert self.source.state == "RUN", self.said()
        self.stream(seconds)
        assert self.source.state == "RUN", self.said()

    def stop_drives(self):
        self.drives.send_signal(signal.SIGTERM)
        out, errors = self.drives.communicate(timeout=20)
        assert self.drives.returncode == 0, errors
        return json.loads(out)

    def stop(self):
        """SIGTERM: a controlled stop. Exit status."""
        self.process.send_signal(signal.SIGTERM)
        return self.process.wait(timeout=20)

    def close(self):
        for process in (self.process, self.drives):
            if process.poll() is None:
                process.kill()
            process.wait()
        for stream in (self.drives.stdout, self.drives.stderr, self.process.stdin):
            if not stream.closed:
                stream.close()
        self.output.close()


@pytest.fixture
def start(tmp_path, bus_address):
    running = []

    def begin(changes=None, arguments=()):
        running.append(Bridge(tmp_path, bus_address, changes, arguments))
        return running[-1]

    yield begin
    for one in running:
        one.close()


LINE = re.compile(r"\((\d+\.\d+)\) (\w+) ([0-9A-F]+)#([0-9A-F]*)")


def frames_of(log):
    """Time, identifier and data of every frame of a log."""
    for line in log.read_text().splitlines():
        time_s, _, identifier, data = LINE.fullmatch(line).groups()
        yield float(time_s), int(identifier, 16), bytes.fromhex(data)


def target_of(data):
    return int.from_bytes(data[2:6], "little", signed=True)


def check_log(frames):
    """Identifiers, lengths, order within a cycle, and steps of the targets."""
    known = {0x000: 2, 0x080: 0, 0x77F: 1}
    for node in NODES:
        known |= {0x080 + node: 8, 0x180 + node: 8, 0x200 + node: 6}
        known |= {0x580 + node: 8, 0x600 + node: 8, 0x700 + node: 1}
    assert {identifier for _, identifier, _ in frames} <= set(known)
    assert not [(i, d) for _, i, d in frames if len(d) != known[i]]
    last, order_breaks, cycles = {}, 0, 0
    in_cycle = Counter()
    for _, identifier, data in frames:
        if identifier == 0x080:
            assert all(count <= 1 for key, count in in_cycle.items() if key < 0x300)  # one command to move a cycle
            in_cycle.clear()
            cycles += 1
        elif 0x200 < identifier < 0x280:
            in_cycle[identifier] += data[0] == 0x0F  # a stop may follow at any time
            if data[0] == 0x0F and identifier in last:
                # The limiter: velocity limit times the period, and a count of rounding.
                assert abs(target_of(data) - last[identifier]) <= 2.0 * 1e-3 * PERIOD_MS * COUNTS_PER_RAD + 1
            last[identifier] = target_of(data)
        elif 0x180 < identifier < 0x200:
            order_breaks += any(0x200 < key < 0x280 for key in in_cycle)
    return cycles, order_breaks


def test_six_foreign_drives_follow_a_motion_that_independent_decoders_read(start, tmp_path):
    bridge = start()
    bridge.run(SECONDS)
    feedback = bridge.source.feedback
    assert max(abs(p - c) for p, c in zip(feedback.position_rad[:6], feedback.command_rad[:6], strict=True)) < 0.2
    bridge.source.request(command_v1_t.DISARM)
    bridge.stream(2.0, until=("IDLE",))
    assert bridge.stop() == 0, bridge.said()
    drives = bridge.stop_drives()
    stats = json.loads(bridge.stats.read_text())
    frames = list(frames_of(bridge.log))
    cycles, order_breaks = check_log(frames)
    print(f"{cycles} cycles, {stats['late_cycles']} left out by the bridge, {order_breaks} answers behind the RPDOs")
    assert abs(cycles - stats["cycles"]) <= 1
    # Every SYNC reached every drive, and every one but those the bridge left out had its RPDO before it.
    for drive in drives:
        print(drive)
        if drive["dropped"]:
            print("the drives' process did not read all that came: counts of it say nothing")
        else:
            assert drive["missed_cycles"] == 0
            assert drive["syncs"] >= cycles - 1
        assert drive["largest_step"] <= 2.0 * 1e-3 * PERIOD_MS * COUNTS_PER_RAD + 1
        assert drive["span"][1] > (2 * AMPLITUDE_RAD if SECONDS > 3 else 0.1) * 0.98 * COUNTS_PER_RAD
        assert drive["state"] != 0x27
    # Periods: absolute deadlines. The mean over the run is the period to a microsecond, whatever the jitter.
    syncs = [t for t, identifier, _ in frames if identifier == 0x080]
    mean_ms = 1e3 * (syncs[-1] - syncs[0]) / (len(syncs) - 1 + stats["late_cycles"])
    assert mean_ms == pytest.approx(PERIOD_MS, abs=0.005)
    check_with_tshark(bridge.log, frames)
    check_with_cantools(frames, tmp_path)


def check_with_tshark(log, frames):
    if shutil.which("tshark") is None:
        print("tshark is not here: not decoded by it")
        return
    fields = ["can.id", "canopen.function_code", "canopen.node_id", "canopen.em.err_code"]
    arguments = [part for field in fields for part in ("-e", field)]
    out = subprocess.run(
        ["tshark", "-r", log, "-d", "can.subdissector,canopen", "-T", "fields", "-E", "separator=,", *arguments],
        capture_output=True,
        text=True,
        check=True,
    ).stdout.splitlines()
    assert len(out) == len(frames)
    codes = Counter()
    for row, (_, identifier, _) in zip(out, frames, strict=True):
        can_id, function, node = row.split(",")[:3]
        assert int(can_id, 0) == identifier
        assert int(function, 0) == identifier >> 7
        assert not node or int(node, 0) == identifier & 0x7F
        codes[identifier >> 7] += 1
    assert {0x0, 0x1, 0x3, 0x4, 0xB, 0xC, 0xE} <= set(codes)  # NMT, SYNC, TPDO1, RPDO1, SDO both ways, heartbeat


def check_with_cantools(frames, tmp_path):
    import cantools

    path = tmp_path / "pdos.dbc"
    path.write_text(
        'VERSION ""\n\nBU_: M D\n\n'
        'BO_ 513 RPDO1: 6 M\n SG_ controlword : 0|16@1+ (1,0) [0|0] "" D\n SG_ target : 16|32@1- (1,0) [0|0] "" D\n\n'
        'BO_ 385 TPDO1: 8 D\n SG_ statusword : 0|16@1+ (1,0) [0|0] "" M\n SG_ position : 16|32@1- (1,0) [0|0] "" M\n'
        ' SG_ torque : 48|16@1- (1,0) [0|0] "" M\n'
    )
    database = cantools.database.load_file(path)
    enabled, targets = 0, []
    for _, identifier, data in frames:
        if identifier == 0x201:
            values = database.decode_message(identifier, data)
            if values["controlword"] == 0x0F:
                targets.append(values["target"])
        elif identifier == 0x181:
            enabled += database.decode_message(identifier, data)["statusword"] & 0x106F == 0x1027 & 0x106F
    assert enabled > 500
    assert max(targets) - min(targets) > 0.1 * COUNTS_PER_RAD


def test_figures_can_be_looked_at_while_it_runs(start):
    bridge = start()
    heard = []
    listener = lcm.LCM(bridge.lcm_url)
    listener.subscribe("GLENOID_FIGURES", lambda _, data: heard.append(figures_v1_t.decode(data)))
    bridge.run(0.5)
    files = []
    end = time.monotonic() + 20
    while time.monotonic() < end and (len(heard) < 3 or len(files) < 3):
        bridge.stream(0.05)
        listener.handle_timeout(0)
        figures = json.loads(bridge.stats.read_text())  # whole whenever it is read
        if not files or files[-1]["cycles"] != figures["cycles"]:
            files.append(figures)
    for values in ([h.cycles for h in heard], [f["cycles"] for f in files]):
        assert len(values) >= 3
        assert values == sorted(values)
    assert heard[-1].values[figures_v1_t.CYCLE_CPU] > 0
    assert heard[-1].p50_us[figures_v1_t.CYCLE_CPU] <= heard[-1].p99_us[figures_v1_t.CYCLE_CPU]
    assert files[-1]["cycle_cpu_us"]["count"] > files[0]["cycle_cpu_us"]["count"]


def test_monitor_says_in_words_what_happens_on_the_buses(start, tmp_path):
    bridge = start()
    bridge.run(0.3)
    words = [program("glenoid-bridge"), tmp_path / "six.yaml", "--monitor", "--duration", "6"]
    listener = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
    bridge.stream(2.5)
    bridge.process.kill()  # the drives miss their master and say so
    seen, _ = listener.communicate(timeout=20)
    assert listener.returncode == 0
    assert re.search(r"SYNC [1-9]\d*/s", seen), seen
    for node in NODES:
        assert f"node {node}: operational" in seen
        assert re.search(rf"\[{node}\] operation enabled -?\d+\.\d+ rad", seen), seen
        assert f"node {node}: EMCY 8130h heartbeat of the master lost" in seen, seen
        assert f"node {node}: pre-operational" in seen, seen


def last_target(frames):
    return [(data[0], target_of(data)) for _, identifier, data in frames if identifier == 0x201][-1]


def test_local_emergency_stop_by_signal_stops_all_and_is_latched(start):
    bridge = start()
    bridge.run(0.5)
    before_s = time.time()
    bridge.process.send_signal(signal.SIGUSR1)
    bridge.stream(3.0, until=("STOP",))
    assert bridge.source.state == "STOP", bridge.said()
    bridge.stream(0.5)
    bridge.source.request(command_v1_t.ARM)
    bridge.stream(0.3)
    assert bridge.source.state == "STOP"
    assert bridge.stop() == 1  # ended with a latched stop
    frames = list(frames_of(bridge.log))
    after = [(t, d[0], target_of(d)) for t, i, d in frames if i == 0x201 and t >= before_s]
    stops = [t for t, word, _ in after if word == 0x02]
    print(f"quick stop {1e3 * (stops[0] - before_s):.1f} ms after the signal, last command {after[-1][2]}")
    assert not [t for t, word, _ in after if word == 0x0F and t > stops[0]]
    drives = bridge.stop_drives()
    assert all(drive["state"] != 0x27 for drive in drives)


def test_local_emergency_stop_by_descriptor(start):
    bridge = start(arguments=["--estop-stdin"])
    bridge.run(0.3)
    bridge.process.stdin.write(b"\n")
    bridge.process.stdin.flush()
    bridge.stream(3.0, until=("STOP",))
    assert bridge.source.state == "STOP", bridge.said()


def test_killed_bridge_leaves_drives_that_stop_by_themselves(start):
    bridge = start()
    bridge.run(0.5)
    bridge.process.kill()
    bridge.process.wait()
    frames = list(frames_of(bridge.log))
    time.sleep(1.5)  # the drives wait for the master for a second
    drives = bridge.stop_drives()
    print(f"last command in the log {last_target(frames)}; drives: {[(d['state'], d['position']) for d in drives]}")
    for drive in drives:
        assert drive["heartbeat_losses"] == 1
        assert drive["state"] == 0x07  # quick stop active
        # Nothing moved after the last command was taken over.
        assert drive["position"] in (drive["span"][0], drive["position"])
        assert drive["largest_step"] <= 2.0 * 1e-3 * PERIOD_MS * COUNTS_PER_RAD + 1


def test_stopped_and_continued_bridge_does_not_burst(start):
    bridge = start()
    bridge.run(0.5)
    bridge.process.send_signal(signal.SIGSTOP)
    time.sleep(1.2)
    bridge.process.send_signal(signal.SIGCONT)
    bridge.stream(3.0, until=("STOP", "FAULT"))
    assert bridge.source.state in ("STOP", "FAULT"), bridge.said()
    bridge.stream(0.3)
    bridge.stop()
    frames = list(frames_of(bridge.log))
    syncs = [t for t, identifier, _ in frames if identifier == 0x080]
    gap = max(range(1, len(syncs)), key=lambda k: syncs[k] - syncs[k - 1])
    print(f"silent for {1e3 * (syncs[gap] - syncs[gap - 1]):.0f} ms")
    assert syncs[gap] - syncs[gap - 1] > 1.0
    # Behind the gap the grid goes on: as many SYNCs as periods, and no command to move.
    rest = [t for t in syncs if t >= syncs[gap]]
    assert len(rest) <= (rest[-1] - rest[0]) * 1e3 / PERIOD_MS + 2
    cycles, _ = check_log(frames)
    assert cycles == len(syncs)
    assert not [t for t, i, d in frames if 0x200 < i < 0x280 and d[0] == 0x0F and t > syncs[gap]]


def test_dead_man_self_test_passes_with_drives_that_watch_and_fails_without(start):
    quick = {"heartbeat": {**PATIENT["heartbeat"], "drive_waits_ms": 200}}
    bridge = start(changes=quick, arguments=["--selftest-deadman"])
    assert bridge.process.wait(timeout=40) == 0, bridge.said()
    assert "PASS" in bridge.said()


def test_end_by_signal_comes_to_rest_and_releases_the_drives(start):
    bridge = start()
    bridge.run(0.5)
    assert bridge.stop() == 0, bridge.said()
    drives = bridge.stop_drives()
    for drive in drives:
        assert drive["heartbeat_losses"] == 0
        assert drive["state"] in (0x21, 0x40)
