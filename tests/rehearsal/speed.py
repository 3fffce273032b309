"""How much faster than time a hundred rehearsed reaches run. By hand: python tests/rehearsal/speed.py; prints JSON.

`run`: FMU, bridge and drives. `whole`: the checks too. `rig`: bridge and drives alone.
"""

import json
import time
from pathlib import Path

import numpy as np
import yaml
from glenoid.rehearse.checks import gather, judge_all, verdict
from glenoid.rehearse.motion import run_source
from glenoid.rehearse.scenario import parse_scenario
from glenoid.rehearse.virtual import run_virtual

PATH = Path(__file__).resolve().parents[2] / "host/rehearsals/reach_high.yaml"
REACHES = 100


def main() -> None:
    data = yaml.safe_load(PATH.read_text(encoding="utf-8"))
    kinds = ({"activity": "drink"}, {"activity": "reach_across"})
    data["movements"] = [kinds[k % 2] | {"duration_s": 2.0, "pause_s": 0.2} for k in range(REACHES)]
    scenario = parse_scenario(data, PATH)
    begin = time.perf_counter()
    motion = run_source(scenario, 1e-9 * scenario.config.setpoint_period_ns)
    planned = time.perf_counter()
    record = run_virtual(scenario, motion)
    ran = time.perf_counter()
    findings = judge_all(gather(scenario, motion, record))
    judged = time.perf_counter()
    virtual_s = float(1e-9 * np.ptp(record.feedback["time_ns"]))
    ratios = {"rig": ran - planned, "run": ran - begin, "whole": judged - begin}
    print(
        json.dumps(
            {
                "reaches": REACHES,
                "verdict": verdict(findings),
                "virtual_s": round(virtual_s, 1),
                "times_faster": {name: round(virtual_s / wall, 1) for name, wall in ratios.items()},
            }
        )
    )


if __name__ == "__main__":
    main()
