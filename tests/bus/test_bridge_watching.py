"""Looking at glenoid-bridge while it runs: figures in a file and on LCM, and a second one that only listens."""

import json
import re
import subprocess
import sys
import time
from pathlib import Path

import lcm
from glenoid.lcm_types import figures_v1_t
from glenoid.programs import program

sys.path.insert(0, str(Path(__file__).parent))
from bridge_process import NODES


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
