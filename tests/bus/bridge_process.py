"""A running glenoid-bridge with six drives of another project (durand) and a source of setpoints, on UDP."""

import json
import math
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import yaml
from glenoid.lcm_types import command_v1_t
from glenoid.programs import program
from glenoid.publisher import Publisher, now_ns

HERE = Path(__file__).parent
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


LINE = re.compile(r"\((\d+\.\d+)\) (\w+) ([0-9A-F]+)#([0-9A-F]*)")


def frames_of(log):
    """Time, identifier and data of every frame of a log."""
    for line in log.read_text().splitlines():
        time_s, _, identifier, data = LINE.fullmatch(line).groups()
        yield float(time_s), int(identifier, 16), bytes.fromhex(data)
