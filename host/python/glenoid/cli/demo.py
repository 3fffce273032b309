"""`glenoid demo`: the main job end to end."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from glenoid.cli import options as opt


def demo(
    picture: Annotated[Path, typer.Option(callback=opt.picture, help="Where the picture goes.")] = Path(
        "build/demo/reach.png"
    ),
) -> None:
    """Plan a measured reach, run it through both FMUs, compare, draw; then rehearse a reach on simulated drives.

    Example: glenoid demo --picture reach.png
    """
    from glenoid.demo import run_demo  # loads matplotlib, which no other command needs at once

    if not run_demo(Console(highlight=False), picture):
        raise typer.Exit(1)
