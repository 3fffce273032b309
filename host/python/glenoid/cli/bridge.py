"""`glenoid bridge`: setpoints on LCM to CiA 402 drives on CAN."""

from __future__ import annotations

import typer

from glenoid.programs import become


def bridge(context: typer.Context) -> None:
    """Run the real-time bridge between setpoints on LCM and drives on CAN, until Ctrl-C.

    All options are those of the program glenoid-bridge; --help lists them.

    Example: glenoid bridge host/bridge/examples/six_drives.yaml --log frames.log
    """
    become("glenoid-bridge", context.args)
