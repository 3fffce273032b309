"""`glenoid demo`: the main job end to end."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from glenoid.cli import options as opt
from glenoid.demo import run_demo


def demo(
    picture: Annotated[Path, typer.Option(callback=opt.picture, help="Where the picture goes.")] = Path(
        "build/demo/reach.png"
    ),
) -> None:
    """Plan a measured reach, run it through both FMUs with FMPy, compare and draw.

    Example: glenoid demo --picture reach.png
    """
    if not run_demo(Console(highlight=False), picture):
        raise typer.Exit(1)
