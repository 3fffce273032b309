"""The commands of docs/bridge.md, as they stand there. A machine without vcan runs them ten times slower: the test says what changes."""

import os
import re
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parents[3]
SLOW_MS = 20
PATIENCE_S = 60.0
TIMES = {
    "sync": {"period_ms": SLOW_MS, "rpdo_phase": 0.5},
    "setpoints": {"period_ms": SLOW_MS, "delay_ms": 100, "hold_after_ms": 500, "quick_stop_after_ms": 2000},
    "heartbeat": {"master_period_ms": 50, "drive_waits_ms": 2000, "drive_timeout_ms": 5000},
}


def commands():
    """Drives, bridge and source of the document."""
    text = (ROOT / "docs/bridge.md").read_text(encoding="utf-8")
    block = re.search(r"Three terminals:\n\n```sh\n(.*?)```", text, re.DOTALL)[1]
    lines = [shlex.split(line) for line in block.strip().splitlines()]
    assert [line[:2] for line in lines] == [["build/venv/bin/glenoid", word] for word in ("drives", "bridge", "source")]
    return [[sys.executable, "-m", "glenoid", *line[1:]] for line in lines]


def slowed(drives, bridge, source, folder):
    """The same with longer periods, for a user-mode Linux on one busy processor."""
    config = yaml.safe_load((ROOT / bridge[4]).read_text(encoding="utf-8"))
    arm = config["exoskeletons"]["six_drives"]
    arm.update(TIMES)
    arm["setpoints"]["disarm_after_ms"] = 4000
    arm["joint_defaults"]["limits"]["step_rad"] = 1.0
    file, profile = folder / "slow.yaml", folder / "patient.yaml"
    file.write_text(yaml.safe_dump(config), encoding="utf-8")
    profile.write_text('name: patient\nobjects: {"2F10h:02": 2000000}\n', encoding="utf-8")
    bridge = [*bridge[:4], str(file), *bridge[5:], "--priority", "0"]
    return [*drives, "--profile", str(profile)], bridge, [*source, "--rate-hz", "50", "--timeout-s", str(PATIENCE_S)]


def test_the_walkthrough_of_the_document_moves_six_drives(link, tmp_path):
    drives, bridge, source = commands()
    if os.environ["WITH_VCAN"] == "uml":
        drives, bridge, source = slowed(drives, bridge, source, tmp_path)
    assert bridge[-2] != "--log" or not Path(bridge[-1]).is_absolute()
    paths = [tmp_path / name for name in ("drives.txt", "bridge.txt", "candump.txt")]
    with paths[0].open("w") as said_by_drives, paths[1].open("w") as said, paths[2].open("w") as dumped:
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
        started = [
            subprocess.Popen(["candump", link.name], stdout=dumped),
            subprocess.Popen(drives, stdout=said_by_drives, stderr=subprocess.STDOUT, cwd=ROOT, env=environment),
            subprocess.Popen(
                [str(tmp_path / w) if w == "frames.log" else w for w in bridge],
                stdout=said,
                stderr=subprocess.STDOUT,
                cwd=ROOT,
                env=environment,
            ),
        ]
        try:
            done = subprocess.run(source, cwd=ROOT, capture_output=True, text=True, check=False, env=environment)
            time.sleep(0.3)
        finally:
            for process in (started[2], started[1], started[0]):
                process.send_signal(signal.SIGTERM)
                process.wait(PATIENCE_S)
    words = paths[1].read_text()
    assert done.returncode == 0, done.stdout + done.stderr + words
    for line in ("answers", "configured, ", "operational", "armed: all drives follow their targets", "READY -> RUN"):
        assert line in words, words
    # One cycle as the document shows it: SYNC, six answers, six commands.
    seen = [line.split()[1] for line in paths[2].read_text().splitlines() if len(line.split()) > 2]
    cycle = ["080", *[f"18{n}" for n in range(1, 7)], *[f"20{n}" for n in range(1, 7)]]
    kept = [identifier for identifier in seen if identifier in cycle]
    assert any(kept[k : k + 13] == cycle for k in range(len(kept))), kept[-40:]
    if keep := os.environ.get("GLENOID_KEEP_CANDUMP"):
        Path(keep).write_text(paths[2].read_text() + words)
