"""`glenoid validate`: how human the motion is, on measured reaches."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.table import Table

from glenoid.cli import options as opt
from glenoid.inputs import InputError
from glenoid.tables import to_text
from glenoid.validate.coefficients import (
    FITTED_SUBJECTS,
    Coefficients,
    built_in,
    fit,
    from_yaml,
    leave_one_out,
    subjects_of,
    to_yaml,
)
from glenoid.validate.evaluate import evaluate, evaluate_halves, summaries
from glenoid.validate.models import MODELS
from glenoid.validate.movements import SUBSETS, Movement, is_clean_outward, load_npz, subset_of
from glenoid.validate.readers import load_manifest
from glenoid.validate.report import COLUMNS, cell, prepared_folder, swivel_cell, tables, write_csv

SUMMARY = [
    column for column in COLUMNS if column[1] in ("joint_pooled", "elbow_r2", "wrist_r2", "joint_pearson", "gh_mm")
]


def validate(
    data: Annotated[Path, typer.Option(help="Reaches: an .npz archive, or a YAML list of CSV, TRC, C3D recordings.")],
    subset: Annotated[str, typer.Option(help=f"Which movements: {', '.join(SUBSETS)}.")] = "clean-outward",
    models: Annotated[str, typer.Option(help=f"all, or names with commas: {', '.join(MODELS)}.")] = "all",
    coefficients: Annotated[
        str,
        typer.Option(
            help="built-in, cross-validated (leave one person out), halves (fitted to half of the persons, judged on the "
            "others, up to 70 times), a FILE of --fit, or auto: built-in for new persons, cross-validated for those that the "
            "built-in ones were fitted to."
        ),
    ] = "auto",
    fit_to: Annotated[
        Path | None, typer.Option("--fit", help="Fit to these movements, write a reach file, end.")
    ] = None,
    report: Annotated[Path | None, typer.Option(help="Folder for tables, scores.csv and pictures.")] = None,
    as_json: opt.AsJson = False,
) -> None:
    """Predict measured reaches from start, target, lengths and duration alone, and score the predictions.

    Example: glenoid validate --data reaches.npz --models paper,glenoid,oracle-end --report build/likeness
    """
    everything = load_movements(data)
    movements = subset_of(everything, subset)
    if fit_to is not None:
        write_fit(movements, fit_to)
        return
    names = chosen_models(models)
    if coefficients == "halves" and report is not None:
        raise InputError("--coefficients halves: judges every movement many times: no --report")
    source, fitted = chosen_coefficients(coefficients, movements, everything)
    if coefficients == "halves":
        results = evaluate_halves(names, movements, outward(everything, movements))
    else:
        results = evaluate(names, movements, fitted)
    result: dict[str, Any] = {
        "data": str(data),
        "subset": subset,
        "coefficients": source,
        "movements": len(movements),
        "persons": len(subjects_of(movements)),
        "parameters": {"fitted": built_in().count, "chosen": 4},
        "models": summaries(results),
    }
    if report is not None:
        folder = prepared_folder(report)
        (folder / "report.md").write_text("# Human-likeness\n\n" + tables(result), encoding="utf-8")
        write_csv(results, folder / "scores.csv")
        from glenoid.validate.figures import draw_distributions, draw_overlays, draw_rhythms

        draw_distributions(results, folder / "distributions.png")
        shown = [name for name in ("paper", "glenoid") if name in names] or names[:2]
        draw_overlays(shown, results[shown[-1]], fitted, folder / "reaches.png")
        draw_rhythms(movements, fitted, folder / "rhythm.png")
    if as_json:
        print(to_text(result))
    else:
        print_result(result)


def load_movements(data: Path) -> list[Movement]:
    """An archive, or the recordings of a list."""
    return load_manifest(data) if data.suffix in (".yaml", ".yml") else load_npz(data)


def chosen_models(text: str) -> list[str]:
    """Names of models in the order of the table. InputError for an unknown one."""
    wanted = list(MODELS) if text == "all" else [name.strip() for name in text.split(",")]
    for name in wanted:
        if name not in MODELS:
            raise InputError(f"--models = {name!r}: must be all or some of {', '.join(MODELS)}")
    return [name for name in MODELS if name in wanted]


def chosen_coefficients(
    text: str, movements: list[Movement], everything: list[Movement]
) -> tuple[str, dict[str, Coefficients]]:
    """Where the coefficients come from, and those to use for each person; folds are fitted to clean outward reaches."""
    people = subjects_of(movements)
    if text == "halves":
        return "fitted to half of the persons, the others judged", {}
    if text == "auto":
        text = "cross-validated" if set(people) & set(FITTED_SUBJECTS) else "built-in"
    if text == "cross-validated":
        return "leave one person out", leave_one_out(outward(everything, movements))
    one = built_in() if text == "built-in" else from_yaml(Path(text))
    return text, dict.fromkeys(people, one)


def outward(everything: list[Movement], movements: list[Movement]) -> list[Movement]:
    """What folds are fitted to: the clean outward reaches, or the chosen movements where there are none."""
    return [m for m in everything if is_clean_outward(m)] or movements


def write_fit(movements: list[Movement], path: Path) -> None:
    """Coefficients fitted to all the movements, as a reach file."""
    try:
        path.write_text(to_yaml(fit(movements)), encoding="utf-8")
    except OSError as error:
        raise InputError(f"--fit {path}: {error.strerror}") from error
    print(f"{path}: fitted to {len(movements)} movements of {len(subjects_of(movements))} persons")


def print_result(result: dict[str, Any]) -> None:
    """The table for a terminal."""
    table = Table(
        title=f"{result['movements']} movements of {result['persons']} persons, {result['subset']}; mean / median"
    )
    for head in ("model", *(name for name, _, _ in SUMMARY), "swivel rms (bias)", "pulled"):
        table.add_column(head)
    for name, model in result["models"].items():
        scores = model["all"]
        cells = (cell(scores, key, digits) for _, key, digits in SUMMARY)
        table.add_row(name, *cells, swivel_cell(scores), str(scores["pulled"]))
    console = Console(width=150)
    console.print(table, highlight=False)
    console.print(f"coefficients: {result['coefficients']}", highlight=False)
