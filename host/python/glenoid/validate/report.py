"""The table of a validation, for people: text, Markdown, CSV."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from glenoid.inputs import InputError
from glenoid.validate.evaluate import Scored

#: heading, key, digits; every cell is mean / median
COLUMNS = (
    ("joint r2 pooled", "joint_pooled", 3),
    ("joint r2 plain", "joint_plain", 3),
    ("elbow r2", "elbow_r2", 3),
    ("wrist r2", "wrist_r2", 3),
    ("Pearson^2", "joint_pearson", 3),
    ("joint rms deg", "joint_rms_deg", 1),
    ("elbow rms cm", "elbow_rms_cm", 1),
    ("wrist rms cm", "wrist_rms_cm", 1),
    ("GH mm", "gh_mm", 1),
)
PATH_COLUMNS = (
    ("joint r2 pooled", "path_joint_pooled", 3),
    ("joint r2 plain", "path_joint_plain", 3),
    ("elbow r2", "path_elbow_r2", 3),
    ("wrist r2", "path_wrist_r2", 3),
    ("Pearson^2", "path_joint_pearson", 3),
)
END_COLUMNS = (
    ("end posture deg", "end_posture_deg", 1),
    ("end elbow cm", "end_elbow_cm", 1),
    ("end GH mm", "end_gh_mm", 1),
)
Column = tuple[str, str, int]


def cell(scores: Mapping[str, Any], key: str, digits: int) -> str:
    """Mean / median of a score."""
    if key not in scores:
        return "-"
    return f"{scores[key]['mean']:.{digits}f} / {scores[key]['median']:.{digits}f}"


def swivel_cell(scores: Mapping[str, Any]) -> str:
    """Root mean square and bias of the swivel error, deg."""
    return f"{scores['swivel_deg']['rms']:.1f} ({scores['swivel_deg']['mean']:+.1f})" if "swivel_deg" in scores else "-"


def interval_cell(scores: Mapping[str, Any]) -> str:
    """95 % interval of the mean pooled joint r2."""
    if "joint_pooled" not in scores:
        return "-"
    low, high = scores["joint_pooled"]["interval"]
    return f"{low:.3f} .. {high:.3f}"


def rows_of(entries: Mapping[str, Mapping[str, Any]], columns: Sequence[Column]) -> list[list[str]]:
    """A row per entry: its name, then a cell per column."""
    return [[name, *(cell(scores, key, digits) for _, key, digits in columns)] for name, scores in entries.items()]


def heads(columns: Sequence[Column]) -> list[str]:
    """Headings of columns."""
    return [name for name, _, _ in columns]


def markdown(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A Markdown table."""
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows]) + "\n"


def tables(result: Mapping[str, Any]) -> str:
    """All tables of a validation as Markdown."""
    models = result["models"]
    overall = {name: model["all"] for name, model in models.items()}
    time = [
        [*row, interval_cell(scores), swivel_cell(scores), f"{scores['pulled']} / {scores['failed']}"]
        for row, scores in zip(rows_of(overall, COLUMNS), overall.values(), strict=True)
    ]
    parts = [
        f"{result['movements']} movements of {result['persons']} persons, subset `{result['subset']}`; "
        f"coefficients: {result['coefficients']}. Cells: mean / median.\n",
        "## Over normalised time\n",
        markdown(
            ["model", *heads(COLUMNS), "joint r2, 95 % of the mean", "swivel rms (bias) deg", "pulled / failed"], time
        ),
        "## Over the path, the time law removed\n",
        markdown(["model", *heads(PATH_COLUMNS)], rows_of(overall, PATH_COLUMNS)),
        "## Final posture\n",
        markdown(["model", *heads(END_COLUMNS)], rows_of(overall, END_COLUMNS)),
        "## By task: joint r2 pooled, elbow r2, wrist r2\n",
    ]
    short = [COLUMNS[0], COLUMNS[2], COLUMNS[3], COLUMNS[8]]
    for name, model in models.items():
        by_task = {f"{name}: {task} ({scores['movements']})": scores for task, scores in model["tasks"].items()}
        parts.append(markdown(["model: task (n)", *heads(short)], rows_of(by_task, short)))
    parts += ["## Models\n", markdown(["name", "what"], [[name, model["about"]] for name, model in models.items()])]
    return "\n".join(parts)


def write_csv(results: Mapping[str, Sequence[Scored]], path: Path) -> None:
    """A row per model and movement with every score."""
    keys = next((row.scores.keys() for rows in results.values() for row in rows if row.scores), {}.keys())
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["model", "movement", "subject", "arm", "task", "pulled_m", "failed", *keys])
        for name, rows in results.items():
            for row in rows:
                m = row.movement
                values = [f"{row.scores[key]:.6g}" if key in row.scores else "" for key in keys]
                writer.writerow([name, m.name, m.subject, m.arm, m.task, f"{row.pulled_m:.3f}", row.failed, *values])


def prepared_folder(folder: Path) -> Path:
    """The folder, made if it does not exist. InputError if it cannot be."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"--report {folder}: {error.strerror}") from error
    return folder
