"""`glenoid source`: the FMU as a source of setpoints."""

from __future__ import annotations

import sys

import typer

from glenoid.cli import options as opt
from glenoid.cli.plan import plan_with_device
from glenoid.cli.replay import AllowNetwork, Force, Rate, Timeout, Url, send
from glenoid.devices import load_device
from glenoid.findings import describe_refusal
from glenoid.fmus import fmu_path
from glenoid.publisher import DEFAULT_URL, Publisher
from glenoid.source import FmuMotion


@opt.of_a_reach
def source(
    asked: opt.Asked,
    exo: opt.ExoName = "generic_75_75",
    rate_hz: Rate = 500.0,
    url: Url = DEFAULT_URL,
    allow_network: AllowNetwork = False,
    force: Force = False,
    timeout_s: Timeout = 10.0,
) -> None:
    """Run the FMU in real time and send its joint motion to the bridge.

    Example: glenoid source host/examples/reach_to_head.yaml --exo generic_75_75
    """
    given = asked.reach
    planned, _ = plan_with_device(given, 100.0, exo)
    if not planned.ok:
        print(f"glenoid: REFUSED  {describe_refusal(planned)}", file=sys.stderr)
        raise typer.Exit(1)
    publisher = Publisher(url, allow_network)
    device = load_device(exo or "generic_75_75")
    motion = FmuMotion(given, device, fmu_path("3"), 1.0 / rate_hz)
    planned_rad = planned.samples["exo_q_rad"]
    try:
        send(publisher, motion, planned_rad, rate_hz, force, timeout_s, (device, given.subject.arm))
    finally:
        motion.close()
