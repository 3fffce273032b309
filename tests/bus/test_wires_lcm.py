"""Messages between two versions of LCM, and their fingerprints."""

import json
import subprocess
import time

import lcm
import pytest
from glenoid import lcm_types
from glenoid.inputs import InputError
from glenoid.lcm_types import command_v1_t, setpoint_v1_t
from glenoid.programs import program
from glenoid.publisher import COMMAND, SETPOINT, STATUS, decoded

PATIENCE_S = 20.0


@pytest.fixture
def peer(url):
    try:
        path = program("wires_lcm_peer")
    except InputError:
        pytest.skip("Debian's liblcm-dev was not there when this was built")
    with subprocess.Popen([path, url], stdout=subprocess.PIPE, text=True) as process:
        yield process
        process.kill()


def test_two_versions_of_lcm_understand_each_other(url, peer):
    fingerprints = json.loads(peer.stdout.readline())
    for name, number in fingerprints.items():
        kind = getattr(lcm_types, f"{name}_v1_t")
        assert kind._get_packed_fingerprint() == (number % 2**64).to_bytes(8, "big"), name

    heard = []
    ours = lcm.LCM(url)
    ours.subscribe(STATUS, lambda _, data: heard.append(data))
    setpoint = setpoint_v1_t()
    setpoint.sequence, setpoint.session, setpoint.count = -(2**62), 2**63 - 1, 7
    setpoint.position_rad = [(-1) ** k / (k + 1) for k in range(16)]
    setpoint.velocity_rad_per_s = [0.25 * k for k in range(16)]
    end = time.monotonic() + PATIENCE_S
    while not heard and time.monotonic() < end:
        ours.publish(SETPOINT, setpoint.encode())
        ours.handle_timeout(100)
    status = decoded(lcm_types.status_v1_t, heard[0])
    assert status is not None
    assert (status.sequence, status.session, status.joint_count) == (-(2**62), 2**63 - 1, 7)
    assert list(status.following_error_rad) == setpoint.position_rad
    assert list(status.velocity_limit_rad_per_s) == setpoint.velocity_rad_per_s
    assert list(status.exoskeleton) == [-k for k in range(32)]
    assert status.encode() == heard[0]

    ours.publish(COMMAND, command_v1_t().encode())
    assert peer.wait(PATIENCE_S) == 0
