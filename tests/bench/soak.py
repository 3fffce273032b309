"""Soak: glenoid-bridge and six glenoid-drives move for a long time. What the drives missed, and whether memory stays flat.

Ends with 0 when no drive missed a cycle while it was enabled, the bridge was in RUN to the end, and neither program
grew after its first minute. Prints one JSON object. An idle timer of the highest priority runs beside on every processor:
how often the machine itself wakes a program up too late for a cycle, how many of the cycles left out coincide with that, and
how much time its host took away.
"""

import argparse
import json
import multiprocessing
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import yaml
from bridge_bench import GROUP, six_drives, stream
from glenoid.programs import program
from glenoid.publisher import STATES, BridgeError, Publisher
from punctuality import be_punctual, cycle_listener, idle_timer, machine, misses, stolen_s

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


class Watchers:
    """An idle timer on every processor and a listener to the cycles, beside a run."""

    def __init__(self, rate_hz, lcm_url):
        self.period_ns = round(1e9 / rate_hz)
        self._over = multiprocessing.Event()
        self._processors = sorted(os.sched_getaffinity(0))
        self._timers, self._gaps = multiprocessing.Queue(), multiprocessing.Queue()
        ears = (lcm_url, self.period_ns, self._over, self._gaps)
        self._running = [multiprocessing.Process(target=cycle_listener, args=ears, daemon=True)]
        for processor in self._processors:
            timer = (processor, self.period_ns, self._over, self._timers)
            self._running.append(multiprocessing.Process(target=idle_timer, args=timer, daemon=True))
        self._begin_s, self._stolen_s = time.monotonic(), stolen_s()
        for one in self._running:
            one.start()

    def figures(self):
        """Ends them; what the machine did, and which of the cycles left out that explains."""
        self._over.set()
        timers = [self._timers.get(timeout=60) for _ in self._processors]
        found = self._gaps.get(timeout=60)
        late = [span for _, _, spans in timers for span in spans]
        return {
            "machine": machine(timers, stolen_s() - self._stolen_s, time.monotonic() - self._begin_s),
            "cycles_left_out": misses(found, late, self.period_ns),
        }


def soak(options, folder):
    """The figures of the run."""
    config, stats, report = folder / "soak.yaml", folder / "stats.json", folder / "drives.json"
    url, lcm_url = f"udp:{GROUP}:{options.port}", f"udpm://239.255.76.67:{options.port + 1}?ttl=0"
    config.write_text(yaml.safe_dump(configuration(url, options.rate_hz)))
    drives = subprocess.Popen(
        [program("glenoid-drives"), "--bus", url, "--profile", options.profile, "--report", report, "--realtime"]
    )
    command = [program("glenoid-bridge"), config, "--stats", stats, "--lcm-url", lcm_url, "--quiet"]
    bridge = subprocess.Popen(command, stdout=sys.stderr)  # its warnings; the JSON is to be alone
    memory = {"bridge": [], "drives": []}

    def watch(t):
        if t >= SETTLED_S:
            memory["bridge"].append(memory_kb(bridge))
            memory["drives"].append(memory_kb(drives))

    try:
        source = Publisher(lcm_url)
        source.await_status(10)
        source.arm(60)
        watchers = Watchers(options.rate_hz, lcm_url)
        begin = time.monotonic()
        be_punctual(options.source_priority)
        end = "to the end"
        try:
            stream(source, options.rate_hz, 60 * options.minutes, watch)
        except BridgeError as error:
            end = f"{error} after {(time.monotonic() - begin) / 60:.1f} min"
        state = STATES[source.status.state]
        events = list(source.events)
        figures = watchers.figures()
    finally:
        for one in (bridge, drives):
            one.terminate()
            one.wait()
    growth = {name: (max(kb) - kb[0] if kb else None) for name, kb in memory.items()}
    return {
        "ran": end,
        "state_at_the_end": state,
        "events": events,
        "memory_growth_kB": growth,
        **figures,
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
