"""Soak: glenoid-bridge and six glenoid-drives move for a long time. What the drives missed, and whether memory stays flat.

Ends with 0 when no drive missed a cycle while it was enabled, the bridge was in RUN to the end, and neither program
grew after its first minute. Prints one JSON object. An idle timer of the highest priority runs beside: how often the
machine itself wakes a program up too late for a cycle.
"""

import argparse
import json
import math
import multiprocessing
import os
import subprocess
import tempfile
import time
from pathlib import Path

import yaml
from bridge_bench import GROUP, six_drives, stream
from glenoid.programs import program
from glenoid.publisher import STATES, BridgeError, Publisher

SETTLED_S = 60.0  #: memory is compared with what it was then
PAGE_KB = 4
GROWTH_KB = 4 * PAGE_KB  #: a few pages of a stack may still be touched


def configuration(url, rate_hz):
    device = six_drives(url, rate_hz)
    device["supervision"] = {"feedback_misses": 100, "transmit_skips": 100}
    device["heartbeat"] |= {"drive_waits_ms": 500, "drive_timeout_ms": 1000}
    return {"exoskeletons": {"soak": device}}


def memory_kb(process):
    """Resident memory."""
    fields = dict(line.split(":", 1) for line in Path(f"/proc/{process.pid}/status").read_text().splitlines())
    return int(fields["VmRSS"].split()[0])


def be_punctual(priority):
    """SCHED_FIFO for this program, where permitted."""
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
    except PermissionError:
        print("no right to SCHED_FIFO: the source runs as an ordinary program", flush=True)


def watch_machine(rate_hz, seconds, result):
    """Wake-ups of a program that does nothing else, by absolute deadlines: how many, and how many half a period late."""
    be_punctual(99)
    begin, woken, late, number = time.monotonic(), 0, 0, 0
    while number < seconds * rate_hz:
        number = max(number + 1, math.ceil((time.monotonic() - begin) * rate_hz))
        due = begin + number / rate_hz
        time.sleep(max(0.0, due - time.monotonic()))
        woken += 1
        late += time.monotonic() - due > 0.5 / rate_hz
    result.put({"wake_ups": woken, "half_a_period_late": late, "periods_slept_through": number - woken})


def soak(options, folder):
    """The figures of the run."""
    config, stats, report = folder / "soak.yaml", folder / "stats.json", folder / "drives.json"
    url, lcm_url = f"udp:{GROUP}:{options.port}", f"udpm://239.255.76.67:{options.port + 1}?ttl=0"
    config.write_text(yaml.safe_dump(configuration(url, options.rate_hz)))
    drives = subprocess.Popen(
        [program("glenoid-drives"), "--bus", url, "--profile", options.profile, "--report", report, "--realtime"]
    )
    bridge = subprocess.Popen([program("glenoid-bridge"), config, "--stats", stats, "--lcm-url", lcm_url, "--quiet"])
    machine = multiprocessing.Queue()
    idle = multiprocessing.Process(target=watch_machine, args=(options.rate_hz, 60 * options.minutes, machine))
    memory = {"bridge": [], "drives": []}

    def watch(t):
        if t >= SETTLED_S:
            memory["bridge"].append(memory_kb(bridge))
            memory["drives"].append(memory_kb(drives))

    woken = None
    try:
        source = Publisher(lcm_url)
        source.await_status(10)
        source.arm(60)
        idle.start()
        begin = time.monotonic()
        be_punctual(options.source_priority)
        end = "to the end"
        try:
            stream(source, options.rate_hz, 60 * options.minutes, watch)
        except BridgeError as error:
            end = f"{error} after {(time.monotonic() - begin) / 60:.1f} min"
        state = STATES[source.status.state]
        events = list(source.events)
        woken = machine.get(timeout=60) if end == "to the end" else None
    finally:
        if idle.is_alive():
            idle.terminate()
        for one in (bridge, drives):
            one.terminate()
            one.wait()
    growth = {name: (max(kb) - kb[0] if kb else None) for name, kb in memory.items()}
    return {
        "ran": end,
        "state_at_the_end": state,
        "events": events,
        "memory_growth_kB": growth,
        "machine": woken,
        "drives": json.loads(report.read_text()),
        "bridge": json.loads(stats.read_text()),
    }


def main():
    parser = argparse.ArgumentParser(prog="glenoid-bench soak", description=__doc__)
    parser.add_argument("--minutes", type=float, default=30.0)
    parser.add_argument("--rate-hz", type=int, default=500)
    parser.add_argument(
        "--profile", default="patient", help="of the drives; others stop at a SYNC that is a millisecond late"
    )
    parser.add_argument("--port", type=int, default=43990)
    parser.add_argument("--source-priority", type=int, default=40, help="SCHED_FIFO of the source")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        figures = soak(options, Path(folder))
    print(json.dumps(figures, indent=2))
    missed = [drive["missed_cycles"] for drive in figures["drives"]["drives"]]
    grown = [kb for kb in figures["memory_growth_kB"].values() if kb is not None and kb > GROWTH_KB]
    return int(any(missed) or bool(grown) or figures["state_at_the_end"] != "RUN")


if __name__ == "__main__":
    raise SystemExit(main())
