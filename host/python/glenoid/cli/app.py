"""The commands, and what becomes of their errors."""

from __future__ import annotations

import os
import re
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


#: what typer raises for words that are no command: the root of its exceptions, whichever click it carries
UsageError: type[Exception] = next(kind for kind in typer.BadParameter.__mro__ if kind.__name__ == "ClickException")


def words_of(error: Exception) -> str:
    """What is wrong with the command line, in a line; nothing where the help has been printed instead."""
    if type(error).__name__ == "NoArgsIsHelpError":
        return ""
    text = str(error.format_message())  # type: ignore[attr-defined]
    text = re.sub(r"'(-[^' ]+)'", r"\1", text.replace("Invalid value for ", "").replace("Value error, ", ""))
    return " ".join(text.replace(": = ", " = ").split())


def refuse(text: str) -> int:
    """Says what is wrong on standard error; exit status 2."""
    if text:
        print(f"glenoid: {text}", file=sys.stderr)
    return 2


def leave_quietly() -> int:
    """The reader of standard output has seen enough (`| head`): nothing is left to be flushed at exit; status 0."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.__stdout__.fileno() if sys.__stdout__ else 1)
    return 0


def run() -> int:
    """Runs the command line and returns its exit status."""
    try:
        status = app(standalone_mode=False)
        sys.stdout.flush()
        return status or 0
    except UsageError as error:
        return refuse(words_of(error))
    except InputError as error:
        return refuse(str(error))
    except BrokenPipeError:
        return leave_quietly()
    except SystemExit as end:  # typer's own answer to a broken pipe
        if isinstance(end.__context__, BrokenPipeError):
            return leave_quietly()
        raise
    except OSError as error:  # a file of the caller: --csv, --plot, --out; without a name, standard output
        return refuse(f"{error.filename or 'standard output'}: {error.strerror or error}")
