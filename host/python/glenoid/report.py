"""What the commands print for people."""

from __future__ import annotations

import numpy as np
from rich.console import Console
from rich.table import Table
from rich.text import Text

from glenoid.findings import describe_margin, describe_refusal, warnings_for
from glenoid.reach import Reach, Verification
from glenoid.tables import ANGLES


class Printer(Console):
    """Standard output for people: text as it is, whatever brackets are in it.

    A reader who leaves (`| head`) raises BrokenPipeError, as `print` does.
    """

    def __init__(self) -> None:
        super().__init__(markup=False)

    def on_broken_pipe(self) -> None:
        """See Console, which would end the process with status 1."""
        raise BrokenPipeError


def degrees(values: np.ndarray) -> str:
    """Angles in a row, deg."""
    return "  ".join(f"{name} {value:7.2f}" for name, value in zip(ANGLES, np.rad2deg(values), strict=True))


def metres(values: np.ndarray) -> str:
    """A point, m."""
    return "  ".join(f"{axis} {value:7.4f}" for axis, value in zip("xyz", values, strict=True))


def two_columns() -> Table:
    """A table of names and values."""
    table = Table(box=None, show_header=False, pad_edge=False)
    table.add_column(style="bold", no_wrap=True)
    table.add_column(overflow="fold")
    return table


def print_reach(console: Console, reach: Reach, verification: Verification | None) -> None:
    """Result, certificate and warnings of a reach."""
    console.print(Text(reach.given.name or "Reach", "bold"))
    if not reach.ok:
        console.print(Text.assemble((f"REFUSED  {reach.status}", "bold red"), f": {describe_refusal(reach)}"))
        return
    samples = reach.samples
    table = two_columns()
    table.add_row("start posture (deg)", degrees(samples["q_rad"][0]))
    table.add_row("end posture (deg)", degrees(samples["q_rad"][-1]))
    table.add_row("wrist at end (m)", metres(samples["wrist_m"][-1]))
    shoulder_mm = 1e3 * np.linalg.norm(samples["shoulder_m"][-1] - samples["shoulder_m"][0])
    table.add_row("shoulder moves", f"{shoulder_mm:.1f} mm")
    table.add_row("swivel angle", f"{np.rad2deg(samples['swivel_rad'][-1]):.2f} deg")
    table.add_row("energy 1/2 q'Mq'", f"{reach.generator.path.energy_kg_m2:.6f} kg m2 (path parameter 0..1)")
    speed = np.rad2deg(np.abs(samples["dq_rad_per_s"]).max(axis=0))
    table.add_row("peak speeds (deg/s)", "  ".join(f"{n} {v:.1f}" for n, v in zip(ANGLES, speed, strict=True)))
    console.print(table)
    console.print(Text("Certificate", "bold"))
    console.print(certificate_table(reach, verification))
    for line in warnings_for(reach):
        console.print(Text.assemble(("WARNING", "bold yellow"), f"  {line}"))


def certificate_table(reach: Reach, verification: Verification | None) -> Table:
    """Everything that was shown about the path."""
    certificate = reach.certificate
    table = two_columns()
    table.add_row("strict local minimum", "yes" if certificate.hessian_positive else "NOT SHOWN")
    table.add_row("energy constant to", f"{certificate.speed_variation:.1e}")
    table.add_row("last Newton step", f"{certificate.newton_step_rad:.1e} rad, {certificate.iterations} iterations")
    table.add_row("interpolation error", f"{certificate.spectral_tail:.1e} on {certificate.order + 1} nodes")
    table.add_row("wrist off target", f"{1e9 * certificate.hand_error_m:.1f} nm")
    where = " (at a joint limit)" if certificate.swivel_at_limit else ""
    table.add_row("transversality", f"{certificate.transversality:.1e}{where}")
    angle = np.rad2deg(certificate.rotation_angle_rad)
    table.add_row("homotopy class", f"{'LONG' if certificate.long_way else 'short'} way, rotation {angle:.1f} deg")
    table.add_row("nearest limit on way", describe_margin(certificate.limits.worst))
    if verification is not None:
        verdict = "agrees" if verification.passed else "DISAGREES"
        table.add_row("shot with CVODE", f"{verdict}: arrives within {verification.arrival_rad:.1e} rad")
        table.add_row("", f"path at most {verification.deviation_rad:.1e} rad off the shot")
        table.add_row("", f"energy drift of the shot {verification.energy_drift:.1e}")
    return table
