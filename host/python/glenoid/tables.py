"""Reaches as CSV and JSON; every column says its unit."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from glenoid import _core
from glenoid.devices import JOINTS
from glenoid.findings import ANGLE_NAMES, describe_refusal, warnings_for
from glenoid.inputs import InputError
from glenoid.reach import Array, Reach, Verification

ANGLES = ("theta", "eta", "zeta", "phi")
POINTS = ("shoulder", "elbow", "wrist")
SCALARS = ("swivel_rad", "progress", "misalignment_m")


def motion_columns(time_s: Array, samples: dict[str, Array]) -> dict[str, Array]:
    """Columns of a sampled motion by name, in the order of the CSV file."""
    columns = {"time_s": time_s}
    columns |= {f"{name}_rad": samples["q_rad"][:, k] for k, name in enumerate(ANGLES)}
    columns |= {f"d{name}_rad_per_s": samples["dq_rad_per_s"][:, k] for k, name in enumerate(ANGLES)}
    columns |= {f"dd{name}_rad_per_s2": samples["ddq_rad_per_s2"][:, k] for k, name in enumerate(ANGLES)}
    for point in POINTS:
        columns |= {f"{point}_{axis}_m": samples[f"{point}_m"][:, k] for k, axis in enumerate("xyz")}
    columns |= {name: samples[name] for name in SCALARS}
    return columns


def device_columns(samples: dict[str, Array]) -> dict[str, Array]:
    """Columns of the device by name, in the order of exo.q."""
    columns = {f"exo_{name}_rad": samples["exo_q_rad"][:, k] for k, name in enumerate(JOINTS)}
    columns |= {f"dexo_{name}_rad_per_s": samples["exo_dq_rad_per_s"][:, k] for k, name in enumerate(JOINTS)}
    if "exo_ddq_rad_per_s2" in samples:
        columns |= {f"ddexo_{name}_rad_per_s2": samples["exo_ddq_rad_per_s2"][:, k] for k, name in enumerate(JOINTS)}
    names = ("exo_residual_m", "exo_margin_rad", "exo_singularity_rad")
    return columns | {name: samples[name] for name in names if name in samples}


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Where to write a file that appears under its name when all is in it; a device or pipe is its own place.

    Raises:
        InputError: it cannot be written; what was there before is as it was.

    """
    ordinary = path.is_file() or not path.exists()
    place = path.with_name(f".part-{path.name}") if ordinary else path
    try:
        yield place
        if ordinary:
            place.replace(path)
    except BrokenPipeError:  # a reader of --csv /dev/stdout who has seen enough
        raise
    except OSError as error:
        raise InputError(f"{path}: {error.strerror or error}") from error
    finally:
        if ordinary:
            place.unlink(missing_ok=True)


def write_csv(columns: dict[str, Array], path: Path) -> None:
    """Columns of equal length, full precision. InputError if the file cannot be written."""
    with whole_file(path) as place, place.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        writer.writerows(np.column_stack(list(columns.values())).tolist())


def certificate_to_json(certificate: _core.Certificate) -> dict[str, Any]:
    """The certificate, all of it."""
    names = (
        "newton_step_rad",
        "gradient_kg_m2",
        "hessian_positive",
        "spectral_tail",
        "speed_variation",
        "hand_error_m",
        "transversality",
        "swivel_at_limit",
        "rotation_angle_rad",
        "long_way",
        "order",
        "iterations",
    )
    worst = certificate.limits.worst
    limits = {
        "violated": certificate.limits.any,
        "worst_margin_rad": worst.margin_rad,
        "worst_angle": ANGLE_NAMES[worst.angle],
        "at_upper": worst.at_upper,
        "lambda": certificate.limits.at_lambda,
    }
    return {name: getattr(certificate, name) for name in names} | {"limits": limits}


def reach_to_json(reach: Reach, verification: Verification | None = None) -> dict[str, Any]:
    """A reach as plain data; without motion if there is none."""
    out: dict[str, Any] = {"name": reach.given.name, "status": reach.status, "reach_margin_m": reach.reach_margin_m}
    if not reach.ok:
        return out | {"message": describe_refusal(reach), "best_margin_rad": reach.best_margin.margin_rad}
    out["energy_kg_m2"] = reach.generator.path.energy_kg_m2
    out["swivel_rad"] = float(reach.samples["swivel_rad"][-1])
    out["certificate"] = certificate_to_json(reach.certificate)
    out["warnings"] = warnings_for(reach)
    if verification is not None:
        out["verification"] = {
            "passed": verification.passed,
            "arrival_rad": verification.arrival_rad,
            "deviation_rad": verification.deviation_rad,
            "energy_drift": verification.energy_drift,
        }
    names = ("q_rad", "dq_rad_per_s", "ddq_rad_per_s2", "shoulder_m", "elbow_m", "wrist_m", *SCALARS)
    out["motion"] = {"time_s": reach.time_s.tolist()} | {name: reach.samples[name].tolist() for name in names}
    keys = ("swivel_rad", "margin_rad", "energy_kg_m2")
    out["family"] = {key: [number_or_none(value) for value in reach.family[key]] for key in keys}
    return out


def number_or_none(value: float) -> float | None:
    """JSON has no NaN: what was not computed is null."""
    return float(value) if math.isfinite(value) else None


def to_text(data: Any) -> str:
    """Strict JSON."""
    return json.dumps(data, allow_nan=False)
