"""Saving, restoring, serializing, resetting; instances beside and after one another."""

import ctypes
import threading
from pathlib import Path

import fmu_driver
import pytest

OK, WARNING, DISCARD, ERROR = range(4)
H = 1 / 512


def drive(unit, start, stop):
    """Steps with a target that changes twice, a stop and a new duration on the way."""
    rows = []
    for k in range(round(start / H), round(stop / H)):
        time = k * H
        if time == 0.25:
            assert unit.set("target", (0.1, 0.45, 0.1)) == OK
        if time == 0.75:
            assert unit.set("motion.duration", 0.8) == OK
            assert unit.set("target", (0.25, 0.35, 0.2)) == OK
        if time == 1.0:
            assert unit.set("stop", True) == OK
        assert unit.step(time, H) == OK
        rows.append(unit.outputs())
    return rows


@pytest.mark.parametrize("moment", [0.0, 0.125, 0.5, 0.875, 1.0625, 1.5])
def test_save_run_restore_run_is_the_same(new, moment):
    straight, unit = new().initialize(), new().initialize()
    expected = drive(straight, 0, 2)
    drive(unit, 0, moment)
    state = unit.save()
    first = drive(unit, moment, 2)
    assert unit.restore(state) == OK
    assert drive(unit, moment, 2) == first == expected[round(moment / H) :]
    unit.release(state)


@pytest.mark.parametrize("moment", [0.0, 0.5, 1.0625])
def test_serialized_state_continues_in_another_instance(new, moment):
    unit, other = new().initialize(), new()  # the other one is not even initialized
    drive(unit, 0, moment)
    state = unit.save()
    data = unit.serialize(state)
    assert data == unit.serialize(state)
    expected = drive(unit, moment, 2)
    status, copy = other.deserialize(data)
    assert status == OK
    assert other.restore(copy) == OK
    assert other.serialize(copy) == data
    assert drive(other, moment, 2) == expected
    unit.release(state)
    other.release(copy)


def test_a_state_carries_its_parameters(new):
    tall, plain = new(), new().initialize()
    tall.initialize(**{"subject.stature": 1.9, "subject.leftArm": True})
    drive(tall, 0, 0.5)
    state = tall.save()
    expected = drive(tall, 0.5, 1.0)
    assert plain.restore(state) == OK
    assert plain.get("subject.stature") == 1.9
    assert drive(plain, 0.5, 1.0) == expected
    tall.release(state)


def test_a_state_of_the_other_version_is_the_same_state(archives):
    """The bytes are a property of the motion, not of the interface."""
    with fmu_driver.Instance(archives["fmi2"]) as two, fmu_driver.Instance(archives["fmi3"]) as three:
        saved = []
        for unit in (two.initialize(), three.initialize()):
            drive(unit, 0, 0.5)
            state = unit.save()
            saved.append(unit.serialize(state))
            unit.release(state)
        assert saved[0] == saved[1]


def damaged(data, case):
    flip = {"magic": 0, "version": 8, "length": 16, "checksum": 24, "payload": len(data) // 2, "last": len(data) - 1}
    if case in flip:
        return data[: flip[case]] + bytes([data[flip[case]] ^ 0x10]) + data[flip[case] + 1 :]
    return {"empty": b"", "half": data[: len(data) // 2], "one short": data[:-1], "zeros": bytes(len(data))}[case]


@pytest.mark.parametrize(
    "case", ["empty", "half", "one short", "zeros", "magic", "version", "length", "checksum", "payload", "last"]
)
def test_a_damaged_state_is_refused_with_a_message(new, case):
    unit = new().initialize()
    drive(unit, 0, 0.5)
    state = unit.save()
    data = unit.serialize(state)
    assert unit.deserialize(damaged(data, case))[0] == ERROR
    assert unit.messages[-1].category == "logStatusError"
    assert "serialized state of" in unit.messages[-1].text
    assert unit.restore(state) == OK  # a sound state brings the instance back
    drive(unit, 0.5, 0.75)
    unit.release(state)


def test_reset_forgets_everything(new):
    fresh = new().initialize()
    expected = drive(fresh, 0, 1.25)
    unit = new().initialize(**{"subject.stature": 1.9})
    drive(unit, 0, 0.5)
    for _ in range(2):
        assert unit.call("Reset") == OK
        unit.initialize()
        assert drive(unit, 0, 1.25) == expected
        assert unit.call("Terminate") == OK


def test_reset_recovers_from_an_error(new):
    unit = new().initialize(stop=0.25)
    assert unit.step(0.0, 0.5) == ERROR
    assert unit.call("Reset") == OK
    assert drive(unit.initialize(), 0, 0.5) == drive(new().initialize(), 0, 0.5)


def test_instances_are_independent(new):
    alone = drive(new().initialize(), 0, 1)
    a, b = new().initialize(), new().initialize(**{"subject.leftArm": True, "motion.duration": 0.7})
    rows = []
    for k in range(16):
        rows += drive(a, k / 16, (k + 1) / 16)
        drive(b, k / 16, (k + 1) / 16)
    assert rows == alone


def test_threads_do_not_disturb_one_another(new):
    expected = drive(new().initialize(), 0, 1)
    units, results = [new() for _ in range(4)], {}

    def work(k):
        results[k] = drive(units[k].initialize(), 0, 1)

    threads = [threading.Thread(target=work, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert [results[k] for k in range(4)] == [expected] * 4


def resident_kib():
    lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("VmRSS"))


@pytest.mark.parametrize("initialize", [False, True])
def test_memory_is_flat_over_many_lives(archive, initialize):
    """A leak of the smallest heap block, 32 bytes, would add 312 KiB in 10,000 lives."""

    def live(count):
        for _ in range(count):
            with fmu_driver.Instance(archive, logging=False, logger=False) as unit:
                if initialize:
                    assert unit.enter() == OK
                    assert unit.exit() == OK
                    assert unit.step(0.0, H) == OK

    count = 500 if initialize else 10_000
    smallest_block = 32
    live(count // 5)  # allocator and interpreter reach their working size
    before = resident_kib()
    live(count)
    libc = ctypes.CDLL(None)
    libc.malloc_trim(0)
    allowed = max(count * smallest_block / 1024, 256)
    assert resident_kib() - before < allowed
