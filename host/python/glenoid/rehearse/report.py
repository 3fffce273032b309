"""One page about a rehearsal that needs nothing but itself."""

from __future__ import annotations

import html
import math
from collections.abc import Iterable
from itertools import chain, repeat
from typing import Any

from glenoid.rehearse.checks import LEAST, Evidence, Finding

CSS = """
:root {
  color-scheme: light dark;
  --ink: #222; --paper: #fff; --line: #ddd; --faint: #767676; --box: #f6f6f6; --bad: #fdecea; --odd: #fff6e0;
}
@media (prefers-color-scheme: dark) {
  :root { --ink: #ddd; --paper: #1b1b1b; --line: #444; --faint: #999; --box: #262626; --bad: #4a2320; --odd: #443818; }
}
body { font: 15px/1.45 system-ui, sans-serif; margin: 2em auto; max-width: 62em; padding: 0 1em; }
body { color: var(--ink); background: var(--paper); }
h1 { margin-bottom: .2em; } h2 { margin-top: 1.8em; border-bottom: 1px solid var(--line); }
.verdict { display: inline-block; padding: .2em .8em; margin-right: .6em; border-radius: .3em; color: #fff; font-weight: 700; }
.PASS { background: #2e8b57; } .verdict.FAIL { background: #c0392b; }
.wide { overflow-x: auto; } table { border-collapse: collapse; min-width: 60%; }
th, td { text-align: left; padding: .25em .6em; border-bottom: 1px solid var(--line); }
.n { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
tr.FAIL td, tr.error td { background: var(--bad); } tr.warn td, tr.warning td { background: var(--odd); }
tr.off td { color: var(--faint); } img { max-width: 100%; background: #fff; border-radius: .3em; }
pre { background: var(--box); padding: 1em; overflow-x: auto; }
.small { color: var(--faint); font-size: 90%; } code { overflow-wrap: anywhere; }
"""
SEVERITY = ("", "warning", "error")
EVENTS_SHOWN = 400
#: what people read beside SI: unit and factor
PLAIN = {
    "rad": ("deg", 180.0 / math.pi),
    "rad/s": ("deg/s", 180.0 / math.pi),
    "rad/s2": ("deg/s2", 180.0 / math.pi),
    "m": ("mm", 1e3),
}


def number(value: float | None) -> str:
    """Four digits, a dash for nothing."""
    return "-" if value is None else f"{value:.4g}"


def table(head: Iterable[str], rows: Iterable[tuple[str, Iterable[str]]]) -> str:
    """A table; each row has a class and its cells as HTML. Heads stand like the cells of the first row."""
    filled = [(kind, list(cells)) for kind, cells in rows]
    first = filled[0][1] if filled else []
    numeric = [text.startswith("<td class=n") for text in first]
    header = "".join(
        f"<th{' class=n' if right else ''}>{html.escape(text)}</th>"
        for text, right in zip(head, chain(numeric, repeat(False)), strict=False)
    )
    body = "".join(f'<tr class="{kind}">{"".join(cells)}</tr>' for kind, cells in filled)
    return f'<div class="wide"><table><thead><tr>{header}</tr></thead><tbody>{body}</tbody></table></div>'


def cell(text: Any, numeric: bool = False) -> str:
    """One cell."""
    return f"<td{' class=n' if numeric else ''}>{html.escape(str(text))}</td>"


def left(finding: Finding) -> float | None:
    """Share of the limit that is left; None where a share says nothing."""
    if finding.value is None or finding.limit <= 0.0 or finding.name in LEAST:
        return None
    return 1.0 - finding.value / finding.limit


def plainly(finding: Finding) -> str:
    """The value in the unit that people read, empty where that is the same."""
    if finding.value is None or finding.unit not in PLAIN:
        return ""
    unit, factor = PLAIN[finding.unit]
    value = factor * finding.value
    return f"{value:.0f} {unit}" if abs(value) >= 1000.0 else f"{value:.3g} {unit}"


def margins(findings: list[Finding]) -> str:
    """What was judged, with the part of the limit that is left."""
    rows = []
    for finding in findings:
        share = left(finding)
        cells = [
            cell(finding.name.replace("_", " ")),
            cell(finding.outcome),
            cell(number(finding.value), True),
            cell(number(finding.limit), True),
            cell(finding.unit),
            cell(plainly(finding), True),
            cell("-" if share is None else f"{100.0 * share:.0f} %", True),
            cell(finding.text),
        ]
        rows.append((finding.outcome, cells))
    return table(("check", "outcome", "value", "limit", "unit", "that is", "left", "where"), rows)


def told(finding: Finding) -> str:
    """A finding in a line."""
    value = f"{number(finding.value)} of {number(finding.limit)} {finding.unit}".strip()
    return f"{finding.name.replace('_', ' ')}: {value}, {finding.text}"


def reason(findings: list[Finding]) -> str:
    """Why it failed, or what came nearest to failing."""
    failed = [told(finding) for finding in findings if finding.outcome == "FAIL"]
    if failed:
        return "; ".join(failed)
    shares = [
        (share, finding) for finding in findings if (share := left(finding)) is not None and finding.level == "error"
    ]
    if not shares:
        return ""
    share, nearest = min(shares, key=lambda pair: pair[0])
    return f"nearest to its limit is {nearest.name.replace('_', ' ')}, with {100.0 * share:.0f} % left"


def summary(e: Evidence) -> str:
    """Who did what with which device, in a line."""
    data, person = e.scenario.data, e.scenario.subject
    movements = [movement.name for movement in data.movements]
    shown = ", ".join(movements[:6]) + (f" and {len(movements) - 6} more" if len(movements) > 6 else "")
    who = f"{'woman' if person.sex == 'female' else 'man'} of {person.stature_m:.2f} m and {person.mass_kg:.0f} kg, {person.arm} arm"
    mode = data.mode.replace("_", " ")
    return f"{shown.replace('_', ' ')} · {who} · {data.exoskeleton} · drives {data.drives.profile} · {mode}"


def events(e: Evidence) -> str:
    """What the bridge told, from the start of the motion on; the start-up's many objects are in the logs."""
    shown = [event for event in e.record.events if event["code"] != 105]
    rows = [
        (
            SEVERITY[event["severity"]],
            [
                cell(f"{float(e.record.seconds(event['time_ns'])):.4f}", True),
                cell(SEVERITY[event["severity"]]),
                cell(event["text"]),
            ],
        )
        for event in shown[-EVENTS_SHOWN:]
    ]
    return table(("time (s)", "kind", "event"), rows)


def injected(e: Evidence) -> str:
    """What was made to go wrong."""
    faults = e.scenario.data.faults
    if not faults:
        return ""
    rows = [
        ("", [cell(fault.at_s, True), cell(fault.kind.replace("_", " ")), cell(fault.joint or "")]) for fault in faults
    ]
    return "<h2>What was made to go wrong</h2>" + table(("time (s)", "fault", "joint"), rows)


def write_report(e: Evidence, findings: list[Finding], facts: dict[str, Any]) -> str:
    """The page. `facts` is what rehearsal.json holds."""
    from glenoid.rehearse.plots import pictures  # matplotlib takes most of the time of a command that draws nothing

    images = "".join(
        f'<h2>{html.escape(title)}</h2><img alt="{html.escape(title)}" src="{url}">' for title, url in pictures(e)
    )
    rows = [
        ("", [cell(name.replace("_", " ")), f"<td><code>{html.escape(str(facts[name]))}</code></td>"])
        for name in ("config_hash", "fmu_sha256", "scenario_sha256", "mode", "run_s")
    ]
    name, note = html.escape(e.scenario.data.name), html.escape(e.scenario.data.note)
    made = f'<p class="small" id="stamp">made {facts["created_utc"]} in {facts["wall_s"]} s</p>'
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">'
        f"<title>{name}: {facts['verdict']}</title>"
        f"<style>{CSS}</style></head><body><h1>{name}</h1><p>{note}</p>"
        f"<p>{html.escape(summary(e))}</p>"
        f'<p><span class="verdict {facts["verdict"]}">{facts["verdict"]}</span>{html.escape(reason(findings))}</p>'
        f"<h2>Margins</h2>{margins(findings)}{injected(e)}{images}"
        f"<h2>Events</h2>{events(e)}<h2>What was rehearsed</h2>{table(('', ''), rows)}"
        f"<h2>Scenario, resolved</h2><pre>{html.escape(e.scenario.resolved())}</pre>{made}"
        '<p class="small">Research software, not a medical device.</p></body></html>\n'
    )
