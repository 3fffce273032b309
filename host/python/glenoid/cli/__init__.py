"""The command line: one file per command.

Exit status: 0 done, 1 negative verdict (refused target, failed verification), 2 usage or input error, 130 interrupted.
"""


def main() -> int:
    """Runs the command line and returns its exit status."""
    try:
        from glenoid.cli.app import run  # takes a second, in which an interruption is no error either

        return run()
    except KeyboardInterrupt:
        return 130
