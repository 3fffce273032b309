"""A motion sent to the bridge in real time: bumpless from where the arm is, at a steady rate, never in a burst."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from glenoid.inputs import InputError
from glenoid.lcm_types import command_v1_t, status_v1_t
from glenoid.publisher import BridgeError, Publisher, now_ns
from glenoid.reach import Array
from glenoid.recording import Recording

#: share of the bridge's limits that closing the first distance may use
BLEND_SHARE = 0.5
#: a motion that does not begin or end at rest is started and stopped this slowly, s
RAMP_S = 0.5
#: shortest blend, and how long the last position is held, s
REST_S = 0.3
#: the stream runs so long before the bridge is asked to follow it, and it has so long to do it, s
SETTLE_S, RUN_WAIT_S = 0.1, 3.0
#: peaks of the minimum-jerk polynomial 10 s^3 - 15 s^4 + 6 s^5 over s: speed 15/8, acceleration 10/sqrt(3)
PEAK_SPEED, PEAK_ACCELERATION = 15.0 / 8.0, 10.0 / math.sqrt(3.0)
#: at rest: slower than this, rad/s
STILL_RAD_PER_S = 1e-3
#: at the end of a motion: every joint as near as this, rad; what a late source left to be done gets so long, s
ARRIVED_RAD, ARRIVAL_WAIT_S = 5e-3, 3.0


class Motion(Protocol):
    """What can be streamed: from rest to rest. `at` is called with growing times."""

    duration_s: float

    def at(self, time_s: float) -> tuple[Array, Array]:
        """Position, rad, and velocity, rad/s, of every joint."""


@dataclass(frozen=True)
class Blend:
    """Minimum-jerk motion from rest to rest."""

    start_rad: Array
    end_rad: Array
    duration_s: float

    def at(self, time_s: float) -> tuple[Array, Array]:
        """See Motion; before 0 the start, after the end the end."""
        s = min(max(time_s / self.duration_s, 0.0), 1.0)
        shape = s * s * s * (10.0 - 15.0 * s + 6.0 * s * s)
        rate = 30.0 * s * s * (1.0 - s) ** 2 / self.duration_s
        way = self.end_rad - self.start_rad
        return self.start_rad + shape * way, rate * way


def blend_within(start_rad: Array, end_rad: Array, speed_rad_per_s: Array, acceleration_rad_per_s2: Array) -> Blend:
    """The shortest blend that stays within a share of the limits of every joint; not shorter than REST_S."""
    way = np.abs(end_rad - start_rad)
    by_speed = PEAK_SPEED * way / (BLEND_SHARE * speed_rad_per_s)
    by_acceleration = np.sqrt(PEAK_ACCELERATION * way / (BLEND_SHARE * acceleration_rad_per_s2))
    return Blend(start_rad, end_rad, float(max(REST_S, by_speed.max(), by_acceleration.max())))


class Replayed:
    """A recording at another speed. Its clock starts and stops gently where the recording does not begin or end at rest.

    Args:
        recording: what to play.
        speed: 1 as recorded, 0.5 half as fast.

    """

    def __init__(self, recording: Recording, speed: float) -> None:
        self.recording, self.speed = recording, speed
        self._curve = recording.curve()
        self._slope = self._curve.derivative()
        self._length = recording.duration_s
        moving = np.abs(recording.velocity_rad_per_s).max(axis=1) > STILL_RAD_PER_S
        # The ramp's clock covers speed * ramp / 2; a short motion gets short ramps.
        longest = self._length / speed
        self._rise = min(RAMP_S, longest) if moving[0] else 0.0
        self._fall = min(RAMP_S, longest) if moving[-1] else 0.0
        self.duration_s = longest + 0.5 * (self._rise + self._fall)

    def clock(self, time_s: float) -> tuple[float, float]:
        """Instant of the recording, s, and how fast it passes; the rate grows and falls linearly over the ramps."""
        left = self.duration_s - time_s
        if time_s <= 0.0:
            return 0.0, 0.0 if self._rise else self.speed
        if left <= 0.0:
            return self._length, 0.0
        if time_s < self._rise:
            rate = self.speed * time_s / self._rise
            return 0.5 * rate * time_s, rate
        if left < self._fall:
            rate = self.speed * left / self._fall
            return self._length - 0.5 * rate * left, rate
        return self.speed * (time_s - 0.5 * self._rise), self.speed

    def at(self, time_s: float) -> tuple[Array, Array]:
        """See Motion."""
        instant, rate = self.clock(time_s)
        position = np.asarray(self._curve(instant), dtype=float)
        return position, rate * np.asarray(self._slope(instant), dtype=float)


@dataclass(frozen=True)
class Limits:
    """Of the bridge's configuration, one of each joint."""

    speed_rad_per_s: Array
    acceleration_rad_per_s2: Array


def limits_of(status: status_v1_t) -> Limits:
    """What the bridge's status says."""
    n = status.joint_count
    return Limits(np.array(status.velocity_limit_rad_per_s[:n]), np.array(status.acceleration_limit_rad_per_s2[:n]))


def refuse_too_fast(motion: Replayed, limits: Limits) -> None:
    """InputError where a joint would be faster than the bridge allows; the text says how slowly it would go."""
    speed, peak = motion.speed, motion.speed * np.abs(motion.recording.velocity_rad_per_s).max(axis=0)
    share = peak / limits.speed_rad_per_s
    worst = int(share.argmax())
    if share[worst] > 1.0:
        raise InputError(
            f"joint {worst + 1} would move at {peak[worst]:.3g} rad/s, the bridge allows "
            f"{limits.speed_rad_per_s[worst]:.3g}; --speed {0.99 * speed / share[worst]:.2g} would do"
        )


def prepare(publisher: Publisher, joints: int, force: bool, timeout_s: float) -> Limits:
    """Checks that the bridge is one we may drive; its limits.

    Raises:
        InputError: other joints, or a bus that may reach hardware and no `force`.
        BridgeError: it does not answer.

    """
    status = publisher.await_status(timeout_s)
    if status.joint_count != joints:
        raise InputError(f"the motion has {joints} joints, the bridge {status.joint_count}")
    if status.real_bus_mask != 0 and not force:
        raise InputError(
            f"the bridge's buses may reach hardware (mask {status.real_bus_mask:#x}); only a virtual bus is moved "
            "without --force-real-bus"
        )
    return limits_of(status)


def measured(publisher: Publisher, joints: int, timeout_s: float) -> Array:
    """Where the joints are, rad. BridgeError where a drive does not answer."""
    end, wanted = time.monotonic() + timeout_s, (1 << joints) - 1
    publisher.feedback = None
    while publisher.feedback is None or publisher.feedback.valid_mask & wanted != wanted:
        if time.monotonic() > end:
            raise BridgeError(publisher.complaint("tells no position of every joint"))
        publisher.poll(0.02)
    return np.array(publisher.feedback.position_rad[:joints], dtype=float)


def stream(publisher: Publisher, motion: Motion, limits: Limits, rate_hz: float, tell: Callable[[str], None]) -> None:
    """From the measured position to the motion's first, through the motion, and to rest; then disarms.

    The end is held until the joints are measured there; where they do not come, `tell` says how far away they stayed.

    Setpoints are stamped on a fixed grid, so that the jitter of this program does not show. Instants that passed while it
    got no processor are left out, not sent late.

    Raises:
        BridgeError: the bridge stopped following; it has come to rest by itself.

    """
    first, _ = motion.at(0.0)
    here = measured(publisher, len(first), 2.0)
    blend = blend_within(here, first, limits.speed_rad_per_s, limits.acceleration_rad_per_s2)
    tell(f"blend: {np.abs(first - here).max():.3f} rad in {blend.duration_s:.2f} s; motion: {motion.duration_s:.2f} s")
    grid = Grid(now_ns(), round(1e9 / rate_hz))
    k = wait_for_run(publisher, here, grid)
    begin_s = grid.time_s(k)
    play_s = begin_s + blend.duration_s
    rest_s = play_s + motion.duration_s + REST_S
    away_rad = math.inf
    while (time_s := grid.time_s(k)) < rest_s or (away_rad > ARRIVED_RAD and time_s < rest_s + ARRIVAL_WAIT_S):
        position, velocity = blend.at(time_s - begin_s) if time_s < play_s else motion.at(time_s - play_s)
        publisher.publish(grid.stamp_ns(k), position.tolist(), velocity.tolist())
        k = wait_for_next(publisher, grid, k)
        if publisher.session == 0 or publisher.state not in ("RUN", "HOLD"):
            raise BridgeError(publisher.complaint("stopped following"))
        if publisher.feedback is not None:
            away_rad = float(np.abs(np.array(publisher.feedback.position_rad[: len(first)]) - position).max())
    if away_rad > ARRIVED_RAD:
        tell(f"a joint stayed {away_rad:.3f} rad from the end of the motion")
    publisher.request(command_v1_t.DISARM)
    publisher.await_state("IDLE", 2.0)


@dataclass(frozen=True)
class Grid:
    """Instants of the setpoints, ns of CLOCK_MONOTONIC."""

    start_ns: int
    step_ns: int

    def stamp_ns(self, k: int) -> int:
        """Instant number k."""
        return self.start_ns + k * self.step_ns

    def time_s(self, k: int) -> float:
        """The same from the start, s."""
        return 1e-9 * (k * self.step_ns)


def wait_for_run(publisher: Publisher, here_rad: Array, grid: Grid) -> int:
    """Streams the place where the arm is until the bridge follows; number of the next instant."""
    rest = np.zeros_like(here_rad).tolist()
    k, asked = 0, False
    while publisher.state != "RUN":
        publisher.publish(grid.stamp_ns(k), here_rad.tolist(), rest)
        if not asked and grid.time_s(k) > SETTLE_S:
            publisher.request(command_v1_t.START)
            asked = True
        if grid.time_s(k) > RUN_WAIT_S or publisher.state in ("STOP", "FAULT"):
            raise BridgeError(publisher.complaint("did not start"))
        k = wait_for_next(publisher, grid, k)
    return k


def wait_for_next(publisher: Publisher, grid: Grid, k: int) -> int:
    """Sleeps until the next instant that is not over; takes in messages meanwhile. Number of that instant."""
    following = max(k + 1, (now_ns() - grid.start_ns) // grid.step_ns)
    publisher.poll()
    if (left_ns := grid.stamp_ns(following) - now_ns()) > 0:
        time.sleep(1e-9 * left_ns)
    return following
