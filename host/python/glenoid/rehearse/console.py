"""A rehearsal on the terminal: progress, then the verdict and what decided it."""

from __future__ import annotations

from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn
from rich.text import Text

from glenoid.inputs import InputError
from glenoid.rehearse.report import number
from glenoid.rehearse.run import REPORT, Outcome, rehearse
from glenoid.rehearse.scenario import Scenario, load_scenario

STYLES = {"pass": "green", "warn": "yellow", "FAIL": "bold red", "off": "dim", "PASS": "bold green"}
REHEARSALS = Path(__file__).absolute().parents[1] / "data" / "rehearsals"


def rehearse_with_progress(console: Console, scenario: Scenario, folder: Path | None) -> Outcome:
    """Runs a scenario under a bar that disappears."""
    columns = (TextColumn("{task.description}"), BarColumn())
    with Progress(*columns, console=console, transient=True) as progress:
        bar = progress.add_task("", total=1.0)
        return rehearse(scenario, folder, lambda stage, share: progress.update(bar, description=stage, completed=share))


def print_outcome(console: Console, outcome: Outcome) -> None:
    """One line a check, the verdict, and where the folder is."""
    for finding in outcome.findings:
        line = Text(f"  {finding.outcome:5s}", style=STYLES[finding.outcome])
        value = f"{number(finding.value):>10s} of {number(finding.limit):<6s} {finding.unit}"
        line.append(f" {finding.name.replace('_', ' '):20s}{value:34s} {finding.text}", style="default")
        console.print(line, highlight=False, soft_wrap=True)
    console.print()
    print_verdict(console, outcome)


def print_verdict(console: Console, outcome: Outcome) -> None:
    """The verdict and where the folder is."""
    line = Text(outcome.verdict, style=STYLES[outcome.verdict])  # not markup: the name is the file's
    console.print(line.append(f"  {outcome.facts['name']}", style="default"), highlight=False, soft_wrap=True)
    if outcome.folder is not None:
        console.print(Text(f"  {(outcome.folder / REPORT).absolute()}"), highlight=False, soft_wrap=True)


def run_demo_rehearsal(console: Console, folder: Path) -> bool:
    """The good rehearsal, as the last part of `glenoid demo`; whether it passed.

    In virtual time it decides. In real time, through LCM, glenoid-bridge, frames over UDP and glenoid-drives, it is told
    only: a busy machine may be late.
    """
    outcome = rehearse_with_progress(console, load_scenario(REHEARSALS / "reach_high.yaml"), folder)
    print_outcome(console, outcome)
    console.print()
    try:
        beside = folder.with_name(folder.name + "_real_time")
        told = rehearse_with_progress(console, load_scenario(REHEARSALS / "reach_high_real_time.yaml"), beside)
    except InputError as error:
        console.print(Text(f"  not run in real time: {error}"), highlight=False, soft_wrap=True)
    else:
        print_verdict(console, told)
        for finding in told.findings:
            if finding.outcome in ("FAIL", "warn"):
                line = Text(f"    {finding.outcome}  {finding.name}: {finding.text}")
                console.print(line, highlight=False, soft_wrap=True)
    return outcome.verdict == "PASS"
