"""What the soak says of the machine: the arithmetic of `tests/bench/punctuality.py`."""

import importlib.util
import os
import queue
import threading
from pathlib import Path

import pytest

FILE = Path(__file__).resolve().parents[1] / "bench/punctuality.py"
PERIOD_NS = 2_000_000


@pytest.fixture(scope="module")
def punctuality():
    spec = importlib.util.spec_from_file_location("punctuality", FILE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_cycles_left_out_are_counted_and_matched_with_late_timers(punctuality):
    left_out = {3, 10, 11, 12}
    times = [k * PERIOD_NS for k in range(20) if k not in left_out]
    found = punctuality.gaps(times, PERIOD_NS)
    late = [punctuality.Span(10 * PERIOD_NS, 12 * PERIOD_NS + 1)]
    told = punctuality.misses(found, late, PERIOD_NS)
    assert told == {"seen": 4, "while_an_idle_timer_was_late": 3, "share_explained": 0.75}
    assert punctuality.misses(found, [], PERIOD_NS)["while_an_idle_timer_was_late"] == 0
    assert punctuality.misses([], late, PERIOD_NS)["share_explained"] is None


def test_jitter_of_less_than_half_a_period_leaves_nothing_out(punctuality):
    assert punctuality.gaps([k * PERIOD_NS + (-1) ** k * 400_000 for k in range(50)], PERIOD_NS) == []


def test_stolen_time_is_the_eighth_figure_of_all_processors(punctuality):
    assert punctuality.stolen_s("cpu  1 2 3 4 5 6 7 250 9 10\ncpu0 0 0 0 0 0 0 0 125 0 0\n") * 100 == pytest.approx(250)
    assert punctuality.stolen_s() >= 0.0


def test_the_worst_of_all_processors_counts(punctuality):
    early, later = punctuality.Span(0, 3_000_000), punctuality.Span(0, 44_000_000)
    told = punctuality.machine([(100, 1, [early]), (80, 21, [early, later])], stolen=0.5, seconds=10.0)
    assert told["largest_lateness_ms"] == 44.0
    assert (told["wake_ups"], told["periods_slept_through"], told["half_a_period_late"]) == (180, 22, 3)
    assert told["stolen_share"] == 0.025


def test_an_idle_timer_wakes_once_a_period_or_says_that_it_slept(punctuality):
    over, result = threading.Event(), queue.Queue()
    processor = min(os.sched_getaffinity(0))
    timer = threading.Thread(target=punctuality.idle_timer, args=(processor, PERIOD_NS, over, result))
    begin_ns = punctuality.now_ns()
    timer.start()
    timer.join(0.3)
    over.set()
    timer.join()
    woken, slept, late = result.get()
    periods = (punctuality.now_ns() - begin_ns) / PERIOD_NS
    assert 0 < woken <= woken + slept <= periods
    assert all(span.end_ns - span.begin_ns > 0.5 * PERIOD_NS for span in late)
