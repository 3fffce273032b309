"""What the machine does to programs with deadlines: time that its host took, idle timers that woke late, cycles left out.

Instants are ns of CLOCK_MONOTONIC.
"""

import math
import os
import time
from pathlib import Path
from typing import NamedTuple

import lcm
from glenoid.lcm_types import feedback_v1_t
from glenoid.publisher import now_ns

STEAL = 8  # field of a line of /proc/stat, proc(5)
LATE = 0.5  # of a period
GAP = 1.5  # periods between two cycles from which on one is missing


class Span(NamedTuple):
    """From an instant to another."""

    begin_ns: int
    end_ns: int

    def meets(self, other):
        """Whether they have an instant in common."""
        return self.begin_ns <= other.end_ns and other.begin_ns <= self.end_ns


def stolen_s(stat=None):
    """Time that the host gave to others while this machine wanted to run, s, all processors together."""
    text = stat if stat is not None else Path("/proc/stat").read_text()
    return int(text.splitlines()[0].split()[STEAL]) / os.sysconf("SC_CLK_TCK")


def be_punctual(priority):
    """SCHED_FIFO for this program, where permitted."""
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
    except PermissionError:
        print("no right to SCHED_FIFO: this program runs as an ordinary one", flush=True)


def idle_timer(processor, period_ns, over, result):
    """Wakes up on one processor by absolute deadlines and does nothing else, until `over`.

    Puts how often it woke, how many periods it slept through, and the spans from deadline to waking that were longer than
    LATE periods.
    """
    os.sched_setaffinity(0, {processor})
    be_punctual(99)
    begin_ns, number, woken, late = now_ns(), 0, 0, []
    while woken == 0 or not over.is_set():
        number = max(number + 1, math.ceil((now_ns() - begin_ns) / period_ns))
        due_ns = begin_ns + number * period_ns
        time.sleep(max(0.0, 1e-9 * (due_ns - now_ns())))
        woken += 1
        if (at_ns := now_ns()) - due_ns > LATE * period_ns:
            late.append(Span(due_ns, at_ns))
    result.put((woken, number - woken, late))


def cycle_listener(lcm_url, period_ns, over, result):
    """Hears the feedback of every cycle until `over`; puts the gaps between them."""
    be_punctual(10)
    times = []
    receiver = lcm.LCM(lcm_url)
    subscription = receiver.subscribe(
        "GLENOID_FEEDBACK", lambda _channel, data: times.append(feedback_v1_t.decode(data).time_mono_ns)
    )
    subscription.set_queue_capacity(8192)
    while not over.is_set():
        receiver.handle_timeout(100)
    result.put(gaps(times, period_ns))


def gaps(times_ns, period_ns):
    """Spans between two cycles that are GAP periods or more apart."""
    pairs = zip(times_ns, times_ns[1:], strict=False)
    return [Span(a, b) for a, b in pairs if b - a >= GAP * period_ns]


def missing(gap, period_ns):
    """How many cycles were left out in a gap."""
    return round((gap.end_ns - gap.begin_ns) / period_ns) - 1


def misses(found, late, period_ns):
    """Cycles left out, and how many of them while an idle timer was late: those the machine explains."""
    seen = sum(missing(gap, period_ns) for gap in found)
    explained = sum(missing(gap, period_ns) for gap in found if any(gap.meets(span) for span in late))
    return {
        "seen": seen,
        "while_an_idle_timer_was_late": explained,
        "share_explained": round(explained / seen, 4) if seen else None,
    }


def machine(timers, stolen, seconds):
    """Figures of the machine from what the idle timers put, and the time stolen meanwhile, s."""
    late = [span for _, _, spans in timers for span in spans]
    return {
        "processors": len(timers),
        "stolen_s": round(stolen, 2),
        "stolen_share": round(stolen / (seconds * len(timers)), 5),
        "wake_ups": sum(woken for woken, _, _ in timers),
        "half_a_period_late": len(late),
        "periods_slept_through": sum(slept for _, slept, _ in timers),
        "largest_lateness_ms": round(1e-6 * max((span.end_ns - span.begin_ns for span in late), default=0), 3),
    }
