"""The main job end to end: a measured reach, planned by the core, run as FMUs, compared, drawn; a reach rehearsed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from rich.console import Console

from glenoid.fmus import FILES, fmu_path
from glenoid.inputs import ReachInput, load_reach
from glenoid.plot import draw_reach
from glenoid.reach import Reach, plan_reach, verify
from glenoid.rehearse.console import run_demo_rehearsal
from glenoid.report import print_reach
from glenoid.simulate import difference_from_core, simulate

EXAMPLE = Path(__file__).parent / "data" / "examples" / "reach_to_head.yaml"
#: FMU and core run the same code on the same inputs; only rounding of the time may differ
FMU_TOLERANCE_RAD = 1e-9


def print_measured(console: Console, reach: Reach) -> None:
    """How far the prediction is from what the person did; the wrist's end was imposed."""
    measured = reach.given.measured
    if measured.elbow_m is not None:
        off = np.linalg.norm(reach.samples["elbow_m"][-1] - np.array(measured.elbow_m))
        console.print(f"  final elbow   {1e3 * off:6.1f} mm from the measured one", highlight=False)
    if measured.wrist_path_m:
        path = np.array(measured.wrist_path_m)
        times = np.linspace(0.0, reach.given.duration_s, len(path))
        wrist = np.column_stack([np.interp(times, reach.time_s, reach.samples["wrist_m"][:, k]) for k in range(3)])
        rms = float(np.sqrt(np.mean(np.sum((wrist - path) ** 2, axis=1))))
        console.print(f"  hand in time  {1e3 * rms:6.1f} mm rms from the measured one", highlight=False)


def run_fmus(console: Console, reach: ReachInput) -> bool:
    """Both FMUs through FMPy; whether they agree with the core."""
    agree = True
    for version in FILES:
        path = fmu_path(version)
        done = simulate(reach, path, 0.01, reach.duration_s + 0.2)
        difference = difference_from_core(reach, done)
        agree = agree and difference <= FMU_TOLERANCE_RAD and done.status == "Arrived"
        console.print(
            f"  {path.name:18s} {len(done.time_s) - 1} steps, {done.status}, "
            f"largest difference from the core {difference:.1e} rad",
            highlight=False,
            soft_wrap=True,
        )
    return agree


def run_demo(console: Console, picture: Path, example: Path = EXAMPLE) -> bool:
    """Runs the demonstration and says what happened; whether everything held."""
    given = load_reach(example)
    console.rule("1. A person's reach, answered by the core")
    console.print(f"{given.source}\n", highlight=False, soft_wrap=True)
    reach = plan_reach(given)
    verification = verify(reach) if reach.ok else None
    print_reach(console, reach, verification)
    if not reach.ok or verification is None:
        return False
    console.rule("2. Beside what the person did")
    print_measured(console, reach)
    console.rule("3. The same reach as FMUs, run by FMPy")
    agree = run_fmus(console, given)
    console.rule("4. The picture")
    picture.parent.mkdir(parents=True, exist_ok=True)
    draw_reach(reach, picture)
    console.print(f"  {picture.absolute()}", highlight=False, soft_wrap=True)
    console.rule("5. A reach through FMU, bridge, bus and six drives")
    rehearsed = run_demo_rehearsal(console, picture.parent / "rehearsal")
    return agree and verification.passed and rehearsed
