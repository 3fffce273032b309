"""`glenoid replay`: a recorded or planned motion, sent to the bridge."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Literal

import typer

from glenoid.cli.options import quantity
from glenoid.device_link import heard, require_same, require_within
from glenoid.devices import Device
from glenoid.lcm_types import command_v1_t
from glenoid.publisher import DEFAULT_URL, BridgeError, Publisher
from glenoid.reach import Array
from glenoid.recording import read_recording
from glenoid.streaming import Motion, Replayed, prepare, refuse_too_fast, stream

Url = Annotated[str, typer.Option("--lcm-url", help="LCM; must stay on this machine.")]
AllowNetwork = Annotated[bool, typer.Option("--allow-network", help="Any LCM URL: setpoints may cross a network.")]
Force = Annotated[bool, typer.Option("--force-real-bus", help="Move drives on a bus that may reach hardware.")]
Rate = Annotated[float, quantity("--rate-hz", "Setpoints per second, 20..1000 Hz.", 20.0, 1000.0)]
Timeout = Annotated[float, quantity("--timeout-s", "For the bridge to answer and to arm, 0.1..3600 s.", 0.1, 3600.0)]


def send(
    publisher: Publisher,
    motion: Motion,
    position_rad: Array,
    rate_hz: float,
    force: bool,
    timeout_s: float,
    device: tuple[Device, str] | None = None,
) -> None:
    """Arms and streams; what the bridge refuses ends the command with status 1, an interruption stops the arm.

    Args:
        publisher: with no session yet.
        motion: what is streamed.
        position_rad: the same as rows of joint angles, for checks beforehand.
        rate_hz: setpoints per second.
        force: drives on a bus that may reach hardware, too.
        timeout_s: for the bridge to answer and to arm.
        device: that the motion was made for, and the arm it is on; None where the motion does not say.

    """
    try:
        limits = prepare(publisher, position_rad.shape[1], force, timeout_s)
        driven = heard(publisher.await_device(timeout_s))
        if device is not None:
            require_same(driven, *device)
        require_within(driven, position_rad)
        if isinstance(motion, Replayed):
            refuse_too_fast(motion, limits)
        publisher.arm(timeout_s)
        stream(publisher, motion, limits, rate_hz, lambda text: print(text, flush=True))
    except BridgeError as error:
        print(f"glenoid: REFUSED  {error}", file=sys.stderr)
        raise typer.Exit(1) from error
    except BaseException:
        if publisher.session != 0:
            publisher.request(command_v1_t.STOP)
            publisher.request(command_v1_t.DISARM)
        raise
    print("done: at rest, disarmed")


def replay(
    log: Annotated[Path, typer.Argument(help="LCM log, or CSV or JSON of `glenoid plan --exo`.")],
    speed: Annotated[float, quantity("--speed", "1: as recorded; 0.01..4.", 0.01, 4.0)] = 1.0,
    channel: Annotated[
        Literal["setpoint", "feedback"] | None, typer.Option(help="Of a log: what was asked for, or what was measured.")
    ] = None,
    rate_hz: Rate = 500.0,
    url: Url = DEFAULT_URL,
    allow_network: AllowNetwork = False,
    force: Force = False,
    timeout_s: Timeout = 10.0,
) -> None:
    """Send a recorded or planned motion to the bridge, with a token of its own, bumpless from where the arm is.

    Example: glenoid plan host/examples/reach_to_head.yaml --exo generic_75_75 --csv reach.csv && glenoid replay reach.csv
    """
    recording = read_recording(log, channel)
    print(f"{log}: {len(recording.time_s)} samples of {recording.joints} joints, {recording.duration_s:.2f} s")
    if recording.skipped:
        print(f"{log}: {recording.skipped} messages are of other sessions or unreadable, left out")
    publisher = Publisher(url, allow_network)
    send(publisher, Replayed(recording, speed), recording.position_rad, rate_hz, force, timeout_s)
