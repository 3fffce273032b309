"""The program glenoid-bridge with six drives of another project (durand), on UDP: motion, decoders, and what a process can suffer.

GLENOID_TEST_BRIDGE_SECONDS  length of the motion (8)
"""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import pytest
from glenoid.lcm_types import command_v1_t

sys.path.insert(0, str(Path(__file__).parent))
from bridge_process import AMPLITUDE_RAD, COUNTS_PER_RAD, NODES, PATIENT, PERIOD_MS, frames_of

SECONDS = float(os.environ.get("GLENOID_TEST_BRIDGE_SECONDS", "8"))


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
