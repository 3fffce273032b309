"""What glenoid-drives refuses on its command line, and whether the words name value, unit and rule."""

import subprocess

import pytest
from glenoid.inputs import InputError
from glenoid.programs import program

BAD = {
    "profile": (["--profile", "nope"], "--profile = nope: must be a file or one of delta_servo, epos4"),
    "profile form": (["--profile", "1=nominal=2"], "--profile = 1=nominal=2: must be NAME or NODE=NAME"),
    "profile node": (["--profile", "9=nominal"], "--profile 9=nominal: no such node"),
    "node 0": (["--nodes", "0"], "--nodes = 0: must be a whole number from 1 to 127"),
    "node 130": (["--nodes", "130"], "--nodes = 130: must be a whole number from 1 to 127"),
    "node order": (["--nodes", "3-1"], "--nodes = 3-1: must be one id, or FIRST-LAST with FIRST not above LAST"),
    "nodes": (["--nodes", "1-17"], "drives = 17: must be 1 to 16"),
    "twice": (["--nodes", "1,1"], "node 1: used twice"),
    "fault time": (["--fault", "node=3,at=-1,kind=emcy"], "at = -1 s: must be 0 to 1e9"),
    "fault node": (["--fault", "node=9,at=1,kind=emcy"], "node = 9: must be one of --nodes 1-6"),
    "fault kind": (["--fault", "node=3,at=1,kind=smoke"], "kind = smoke: no such fault"),
    "fault code": (["--fault", "at=1,kind=emcy,amount=70000"], "amount = 70000: must be at most 65535"),
    "fault share": (["--fault", "at=1,kind=drop,amount=1001"], "amount = 1001: must be at most 1000"),
    "duration": (["--duration-s", "-3"], "--duration-s = -3 s: must be 0 to 1e9"),
    "start": (["--start-rad", "1,2"], "--start-rad: 2 values for 6 nodes"),
    "start nan": (["--start-rad", "nan,0,0,0,0,0"], "--start-rad: must be -1000 to 1000 rad"),
    "start beyond the counts": (["--nodes", "1", "--start-rad", "1e300"], "--start-rad: must be -1000 to 1000 rad"),
    "fault beyond the clock": (["--fault", "at=1e20,kind=jam"], "at = 1e20 s: must be 0 to 1e9"),
    "seed": (["--seed", "-1"], "--seed = -1: must be a whole number from 0 to"),
    "load": (["--load", "nope.yaml"], "nope.yaml: no such file"),
    "report": (["--report", "/nowhere/report.json"], "/nowhere/report.json: cannot be written"),
}


@pytest.mark.parametrize("what", sorted(BAD))
def test_bad_command_line_is_refused(what):
    try:
        path = program("glenoid-drives")
    except InputError as error:
        pytest.skip(str(error))
    arguments, words = BAD[what]
    command = [path, "--bus", "udp:239.74.163.78:45112", *arguments]
    if what != "duration":
        command += ["--duration-s", "0.05"]  # one that is not refused ends all the same
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=20)
    assert done.returncode == 2, done.stdout + done.stderr
    assert words in done.stderr, done.stderr


@pytest.mark.parametrize(
    ("bus", "words"),
    [
        ("blah", "bus 'blah': must be socketcan:INTERFACE, udp:GROUP[:PORT] or memory:"),
        ("udp:300.1.2.3", "udp:300.1.2.3: must be an IPv4 group"),
        ("udp:239.1.1.1:99999", "udp:239.1.1.1:99999: the port must be 1..65535"),
    ],
)
def test_missing_bus_is_named(bus, words):
    try:
        path = program("glenoid-drives")
    except InputError as error:
        pytest.skip(str(error))
    done = subprocess.run([path, "--bus", bus, "--duration-s", "0.05"], capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert words in done.stderr
