"""`glenoid rehearse`: a scenario through FMU, bridge and drives, with a verdict."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from glenoid.cli.options import AsJson

Folder = Annotated[
    Path | None, typer.Option("--out", help="Folder of report and logs; default build/rehearsals/NAME OF THE FILE.")
]


def rehearse(
    scenario: Annotated[Path, typer.Argument(help="Scenario as YAML (host/rehearsals).", metavar="FILE.yaml")],
    out: Folder = None,
    as_json: AsJson = False,
) -> None:
    """Rehearse a session: FMU, bridge and simulated drives run a scenario, and checks decide PASS or FAIL.

    Leaves one folder: report.html, logs (MCAP, LCM, candump), the resolved scenario, and rehearsal.json, which
    glenoid-bridge wants to see before it arms on a real bus. Exit status: 0 PASS, 1 FAIL, 2 input error.

    Example: glenoid rehearse host/rehearsals/reach_high.yaml
    """
    # matplotlib and python-can come with these; other commands start without them
    from glenoid.rehearse.console import print_outcome, rehearse_with_progress
    from glenoid.rehearse.run import rehearse as run_rehearsal
    from glenoid.rehearse.scenario import load_scenario

    checked = load_scenario(scenario)
    folder = out if out is not None else Path("build/rehearsals") / scenario.stem
    if as_json:
        outcome = run_rehearsal(checked, folder)
        print(json.dumps(outcome.facts, indent=2, allow_nan=False))
    else:
        console = Console()
        outcome = rehearse_with_progress(console, checked, folder)
        print_outcome(console, outcome)
    if outcome.verdict != "PASS":
        raise typer.Exit(1)
