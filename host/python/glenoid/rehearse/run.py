"""From a scenario to a verdict and its folder."""

from __future__ import annotations

import datetime
import hashlib
import json
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from glenoid.inputs import InputError
from glenoid.rehearse.checks import Evidence, Finding, gather, judge_all, verdict
from glenoid.rehearse.load import load_yaml
from glenoid.rehearse.logs import write_candump, write_lcm_log
from glenoid.rehearse.mcap_log import write_mcap
from glenoid.rehearse.motion import run_source
from glenoid.rehearse.real_time import run_real_time
from glenoid.rehearse.report import write_report
from glenoid.rehearse.scenario import BRIDGE_COPY, Scenario
from glenoid.rehearse.virtual import run_virtual

#: what is told: stage, share of it done
Tell = Callable[[str, float], None]
VERDICT_FILE, REPORT, SCENARIO, LOAD = "rehearsal.json", "report.html", "scenario.yaml", "load.yaml"
MCAP, LCM_LOG, CANDUMP = "rehearsal.mcap", "lcm.log", "candump.log"


@dataclass(frozen=True)
class Outcome:
    """How a rehearsal ended.

    Attributes:
        verdict: PASS or FAIL.
        findings: of every check.
        folder: where everything lies; None where nothing was written.
        facts: as in rehearsal.json.

    """

    verdict: str
    findings: list[Finding]
    folder: Path | None
    facts: dict[str, Any]


def perform(scenario: Scenario, tell: Tell) -> Evidence:
    """Runs source, bridge and drives. InputError where they do not fit together."""
    data, config = scenario.data, scenario.config
    factor = data.real_time.factor if data.mode == "real_time" else 1.0
    motion = run_source(scenario, 1e-9 * config.setpoint_period_ns, factor, lambda share: tell("FMU", share))
    run = run_real_time if data.mode == "real_time" else run_virtual
    return gather(scenario, motion, run(scenario, motion, tell))


def facts_of(e: Evidence, findings: list[Finding], begun: float) -> dict[str, Any]:
    """What rehearsal.json holds. Only `created_utc` and `wall_s` differ between two runs in virtual time."""
    times = e.record.feedback["time_ns"]
    run_s = float(1e-9 * (times[-1] - times[0])) if len(times) else 0.0
    return {
        "format": 1,
        "name": e.scenario.data.name,
        "verdict": verdict(findings),
        "config_hash": e.scenario.config.hash,
        "fmu": e.motion.fmu.name,
        "fmu_sha256": e.motion.fmu_sha256,
        "scenario_sha256": hashlib.sha256(e.scenario.resolved().encode()).hexdigest(),
        "mode": e.scenario.data.mode,
        "faults": len(e.scenario.data.faults),
        "not_decided_by": [finding.name for finding in findings if finding.level != "error"],
        "state": e.record.state,
        "fault": e.record.fault,
        "run_s": round(run_s, 6),
        "checks": [asdict(finding) | {"outcome": finding.outcome} for finding in findings],
        "drives": e.record.drives,
        "created_utc": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "wall_s": round(time.monotonic() - begun, 3),
    }


def write_folder(folder: Path, e: Evidence, findings: list[Finding], facts: dict[str, Any], tell: Tell) -> None:
    """All files; the verdict comes last, so that a folder that is not complete has none."""
    record, scenario = e.record, e.scenario
    tell("logs", 0.0)
    (folder / SCENARIO).write_text(scenario.resolved(), encoding="utf-8")
    (folder / BRIDGE_COPY).write_text(scenario.bridge_yaml, encoding="utf-8")
    (folder / LOAD).unlink(missing_ok=True)
    if (load := load_yaml(scenario, e.motion)) is not None:
        (folder / LOAD).write_text(load, encoding="utf-8")
    write_candump(folder / CANDUMP, record, scenario)
    tell("logs", 0.3)
    write_lcm_log(folder / LCM_LOG, record, scenario)
    tell("logs", 0.6)
    write_mcap(folder / MCAP, record, scenario, e.motion)
    tell("report", 0.0)
    (folder / REPORT).write_text(write_report(e, findings, facts), encoding="utf-8")
    text = json.dumps(facts, indent=2, allow_nan=False)
    (folder / VERDICT_FILE).write_text(text + "\n", encoding="utf-8")


def rehearse(scenario: Scenario, folder: Path | None, tell: Tell = lambda _stage, _share: None) -> Outcome:
    """Runs a scenario and judges it.

    Args:
        scenario: what to do.
        folder: where the report and the logs go, made if missing; None: nothing is written.
        tell: is told stage and share done.

    Raises:
        InputError: scenario, configuration, profile and FMU do not fit together, or the folder cannot be written.

    """
    begun = time.monotonic()
    try:
        if folder is not None:
            folder.mkdir(parents=True, exist_ok=True)
            (folder / VERDICT_FILE).unlink(missing_ok=True)  # a run that breaks off leaves no older verdict behind
        e = perform(scenario, tell)
        tell("checks", 0.0)
        findings = judge_all(e)
        facts = facts_of(e, findings, begun)
        if folder is not None:
            write_folder(folder, e, findings, finite(facts), tell)
    except OSError as error:
        raise InputError(f"{error.filename or folder}: {error.strerror}") from error
    return Outcome(facts["verdict"], findings, folder, finite(facts))


def finite(value: Any) -> Any:
    """Plain data with None for what JSON cannot hold."""
    if isinstance(value, dict):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, list):
        return [finite(item) for item in value]
    return None if isinstance(value, float) and value - value != 0.0 else value
