"""The part of a movement that a recording shows: recorded movements are cut where the hand is slow, predicted ones must be too.

A recording begins and ends where the hand has CUT of its peak speed. Its duration is that of this part, and so is the
abscissa that scores are taken over; the law of time (T1, T5) rests at both ends of a longer movement.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from glenoid import _core
from glenoid.reach import Array
from glenoid.validate.movements import SAMPLES

#: share of the peak speed at which recordings are cut
CUT = 0.05
#: what the cut leaves of a minimum-jerk movement, to begin with; times at which speeds are compared; rounds to find the duration
KEPT, TIMES, ROUNDS = 0.88, 201, 3
#: a clock: share of the path that is behind, at shares u of a whole movement of a duration, s
Clock = Callable[[Array, float], Array]


def shown_part(way: Array) -> tuple[float, float]:
    """The first and the last share of the time with CUT of the peak speed, for ways (n,) or points (n, k) at equal steps of time."""
    steps = np.diff(way, axis=0)
    speed = np.abs(steps) if steps.ndim == 1 else np.linalg.norm(steps, axis=1)
    times = (np.arange(len(speed)) + 0.5) / len(speed)
    speed = np.concatenate([[0.0], speed, [0.0]])
    times = np.concatenate([[0.0], times, [1.0]])
    least = CUT * speed.max()
    inside = np.flatnonzero(speed >= least)
    first, last = int(inside[0]), int(inside[-1])
    if speed.max() <= 0.0:
        return 0.0, 1.0
    begin = np.interp(least, speed[first - 1 : first + 1], times[first - 1 : first + 1])
    end = times[last] + (times[last + 1] - times[last]) * (speed[last] - least) / (speed[last] - speed[last + 1])
    return float(begin), float(end)


def shown_shares(clock: Clock, points_at: Callable[[Array], Array], duration_s: float, count: int = SAMPLES) -> Array:
    """Shares of the path, 0..1, at `count` equal steps of the shown part, whose duration, start and end are those that are given.

    points_at: ways (n,) or wrist points (n, 3) at shares of the path.
    """
    u = np.linspace(0.0, 1.0, TIMES)
    whole_s, begin, end = duration_s / KEPT, 0.0, 1.0
    for _ in range(ROUNDS):
        begin, end = shown_part(points_at(clock(u, whole_s)))
        whole_s = duration_s / (end - begin)
    shares = clock(begin + (end - begin) * np.linspace(0.0, 1.0, count), whole_s)
    return np.asarray((shares - shares[0]) / (shares[-1] - shares[0]), dtype=float)


def minimum_jerk(u: Array, duration_s: float = 1.0) -> Array:
    """Minimum jerk; T1."""
    return _core.homing_progress(u * duration_s, duration_s, 0.0)


def homing(tail: float) -> Clock:
    """Minimum jerk with a homing tail; T5."""
    return lambda u, duration_s: _core.homing_progress(u * duration_s, duration_s, tail)


def cut_progress(duration_s: float, tail: float) -> Array:
    """Progress of a movement with a homing tail along its own shown part, 0..1, SAMPLES of it."""
    return shown_shares(homing(tail), lambda way: way, duration_s)
