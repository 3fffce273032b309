"""Angles from joint centres, for whole movements at once; docs/equations.md, K3 and K4."""

from __future__ import annotations

import numpy as np

from glenoid.reach import Array


def angles_of_points(shoulder_m: Array, elbow_m: Array, wrist_m: Array) -> Array:
    """(theta, eta, zeta, phi), rad, (n, 4) from points (n, 3); eta and zeta unwrapped along the rows."""
    r, f = elbow_m - shoulder_m, wrist_m - elbow_m
    c = np.cross(r, f)
    q = np.column_stack(
        [
            np.arctan2(np.hypot(r[:, 0], r[:, 1]), -r[:, 2]),
            np.arctan2(-r[:, 0], r[:, 1]),
            np.arctan2(np.linalg.norm(r, axis=1) * c[:, 2], r[:, 1] * c[:, 0] - r[:, 0] * c[:, 1]),
            np.arctan2(np.linalg.norm(c, axis=1), np.sum(r * f, axis=1)),
        ]
    )
    q[:, 1:3] = np.unwrap(q[:, 1:3], axis=0)
    return q


def swivel_of_points(shoulder_m: Array, elbow_m: Array, wrist_m: Array) -> float:
    """Swivel angle, rad: 0 with the elbow lowest, positive with the elbow lateral."""
    n = wrist_m - shoulder_m
    n = n / np.linalg.norm(n)
    s = np.array([0.0, 0.0, -1.0])
    s = s - (s @ n) * n
    t = np.cross(s, n)
    return float(np.arctan2((elbow_m - shoulder_m) @ t, (elbow_m - shoulder_m) @ s))


def elbow_on_circle(shoulder_m: Array, wrist_m: Array, upper_m: float, fore_m: float, swivel_rad: float) -> Array:
    """Elbow with a given swivel angle about a known shoulder, m (K4); the wrist must be within reach."""
    line = wrist_m - shoulder_m
    length = float(np.linalg.norm(line))
    n = line / length
    s = np.array([0.0, 0.0, -1.0])
    s = s - (s @ n) * n
    s = s / np.linalg.norm(s)
    along = (length**2 + upper_m**2 - fore_m**2) / (2.0 * length)
    radius = np.sqrt(max(0.0, upper_m**2 - along**2))
    return np.asarray(
        shoulder_m + along * n + radius * (np.cos(swivel_rad) * s + np.sin(swivel_rad) * np.cross(s, n)), dtype=float
    )


def wrapped(angle_rad: float) -> float:
    """The same angle in [-pi, pi)."""
    return float((angle_rad + np.pi) % (2.0 * np.pi) - np.pi)
