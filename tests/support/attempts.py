"""Runs against the clock, repeated where the machine was late."""

from glenoid.rehearse.programs import may_be_realtime

#: a machine may be late: seldom with SCHED_FIFO (a virtual one whose processor is taken away for 10 ms), more often without; then
#: the run ends by a fault of the stream or a watchdog, not by a wrong motion
ATTEMPTS = 2 if may_be_realtime() else 3


def first_that(run, wanted, describe):
    """The first of some runs that is as wanted, else the last; every other one is printed as `describe` puts it."""
    for attempt in range(1, ATTEMPTS + 1):
        done = run()
        if wanted(done):
            break
        print(f"attempt {attempt} of {ATTEMPTS}: {describe(done)}")
    return done
