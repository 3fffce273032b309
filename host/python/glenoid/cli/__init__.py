"""The command line: one file per command.

Exit status: 0 done, 1 negative verdict (refused target, failed verification), 2 usage or input error.
"""

from __future__ import annotations

import sys

import typer

from glenoid.cli.bridge import bridge
from glenoid.cli.demo import demo
from glenoid.cli.drives import PASS_THROUGH, drives
from glenoid.cli.info import info
from glenoid.cli.plan import plan
from glenoid.cli.rehearse import rehearse
from glenoid.cli.replay import replay
from glenoid.cli.simulate import simulate
from glenoid.cli.source import source
from glenoid.cli.sweep import sweep
from glenoid.cli.validate import validate
from glenoid.inputs import InputError

app = typer.Typer(
    help="Human-like reference motion for upper-limb exoskeletons that support the shoulder girdle. "
    "Research software, not a medical device.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
)
for command in (plan, simulate, sweep, validate, rehearse, replay, source, info, demo):
    app.command()(command)
app.command(context_settings=PASS_THROUGH)(drives)
app.command(context_settings=PASS_THROUGH)(bridge)


def main() -> int:
    """Runs the command line and returns its exit status."""
    try:
        app()
    except InputError as error:
        print(f"glenoid: {error}", file=sys.stderr)
        return 2
    except BrokenPipeError:
        return 0
    except OSError as error:  # a file of the caller: --csv, --plot, --out
        print(
            f"glenoid: {error.filename}: {error.strerror}" if error.filename else f"glenoid: {error}", file=sys.stderr
        )
        return 2
    return 0
