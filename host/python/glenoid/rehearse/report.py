"""One page about a rehearsal that needs nothing but itself."""

from __future__ import annotations

import html
from collections.abc import Iterable
from typing import Any

from glenoid.rehearse.checks import Evidence, Finding
from glenoid.rehearse.plots import pictures

CSS = """
body { font: 15px/1.45 system-ui, sans-serif; margin: 2em auto; max-width: 62em; padding: 0 1em; color: #222; }
h1 { margin-bottom: .2em; } h2 { margin-top: 1.8em; border-bottom: 1px solid #ddd; }
.verdict { display: inline-block; padding: .2em .8em; border-radius: .3em; color: #fff; font-weight: 700; }
.PASS { background: #2e8b57; } .FAIL { background: #c0392b; }
table { border-collapse: collapse; width: 100%; } th, td { text-align: left; padding: .25em .6em; border-bottom: 1px solid #eee; }
td.n { text-align: right; font-variant-numeric: tabular-nums; } tr.FAIL td { background: #fdecea; } tr.warn td { background: #fff6e0; }
tr.off td { color: #888; } img { max-width: 100%; } pre { background: #f6f6f6; padding: 1em; overflow-x: auto; }
.small { color: #666; font-size: 90%; } code { overflow-wrap: anywhere; }
"""
SEVERITY = ("", "warning", "error")
EVENTS_SHOWN = 400


def number(value: float | None) -> str:
    """Four digits, a dash for nothing."""
    return "-" if value is None else f"{value:.4g}"


def table(head: Iterable[str], rows: Iterable[tuple[str, Iterable[str]]]) -> str:
    """A table; each row has a class and its cells as HTML."""
    header = "".join(f"<th>{html.escape(text)}</th>" for text in head)
    body = "".join(f'<tr class="{kind}">{"".join(cells)}</tr>' for kind, cells in rows)
    return f"<table><thead><tr>{header}</tr></thead><tbody>{body}</tbody></table>"


def cell(text: Any, numeric: bool = False) -> str:
    """One cell."""
    return f"<td{' class=n' if numeric else ''}>{html.escape(str(text))}</td>"


def margins(findings: list[Finding]) -> str:
    """What was judged, with the part of the limit that is left."""
    rows = []
    for finding in findings:
        left = "-"
        if finding.value is not None and finding.limit > 0.0:
            left = f"{100.0 * (1.0 - finding.value / finding.limit):.0f} %"
        cells = [
            cell(finding.name.replace("_", " ")),
            cell(finding.outcome),
            cell(number(finding.value), True),
            cell(number(finding.limit), True),
            cell(finding.unit),
            cell(left if not finding.name.endswith("margin") else "-", True),
            cell(finding.text),
        ]
        rows.append((finding.outcome, cells))
    return table(("check", "outcome", "value", "limit", "unit", "left", "where"), rows)


def events(e: Evidence) -> str:
    """What the bridge told, from the start of the motion on; the start-up's many objects are in the logs."""
    told = [event for event in e.record.events if event["code"] != 105]
    rows = [
        (
            SEVERITY[event["severity"]],
            [
                cell(f"{float(e.record.seconds(event['time_ns'])):.4f}", True),
                cell(SEVERITY[event["severity"]]),
                cell(event["text"]),
            ],
        )
        for event in told[-EVENTS_SHOWN:]
    ]
    return table(("time (s)", "", "event"), rows)


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
        f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{name}: {facts["verdict"]}</title>'
        f"<style>{CSS}</style></head><body><h1>{name}</h1><p>{note}</p>"
        f'<p><span class="verdict {facts["verdict"]}">{facts["verdict"]}</span></p>'
        f"<h2>Margins</h2>{margins(findings)}{injected(e)}{images}"
        f"<h2>Events</h2>{events(e)}<h2>What was rehearsed</h2>{table(('', ''), rows)}"
        f"<h2>Scenario, resolved</h2><pre>{html.escape(e.scenario.resolved())}</pre>{made}"
        '<p class="small">Research software, not a medical device.</p></body></html>\n'
    )
