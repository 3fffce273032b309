"""`glenoid drives`: simulated joint drives on a CAN bus."""

from __future__ import annotations

import typer

from glenoid.programs import become


def drives(context: typer.Context) -> None:
    """Run simulated CANopen CiA 402 joint drives in real time, until Ctrl-C; then print their report as JSON.

    All options are those of the program glenoid-drives; --help lists them.

    Example: glenoid drives --bus udp:239.74.163.2 --nodes 1-6 --fault node=3,at=2.5,kind=emcy
    """
    become("glenoid-drives", context.args)


#: options go through to the program as they are, --help included
PASS_THROUGH = {"allow_extra_args": True, "ignore_unknown_options": True, "help_option_names": []}
