"""can-utils and python-can beside the simulated drives on one vcan0."""

import shutil
import socket
import struct
import subprocess
import time

import pytest

ERROR_FRAME, BUS_OFF = 0x20000000, 0x40


@pytest.fixture(autouse=True)
def can_utils():
    if shutil.which("candump") is None:
        pytest.skip("no candump: apt-get install can-utils")


def test_cansend_asks_and_candump_reads_the_answer(link, drives, master):
    drives("--nodes", "1-6")
    for node in range(1, 7):
        assert master.read(node, 0x1000) & 0xFFFF == 0x0192
    dump = subprocess.Popen(
        ["candump", "-L", "-n", "2", f"{link.name},580:780,600:780"], stdout=subprocess.PIPE, text=True
    )
    time.sleep(0.5)
    subprocess.run(["cansend", link.name, "603#4000100000000000"], check=True)
    out, _ = dump.communicate(timeout=30)
    assert [line.split()[2] for line in out.splitlines()] == ["603#4000100000000000", "583#4300100092010200"]


def test_canplayer_replays_a_session_and_the_drives_answer_it(link, drives, master, tmp_path):
    drives("--nodes", "1,2")
    master.read(1, 0x1000)
    master.read(2, 0x1000)
    log = tmp_path / "session.log"
    frames = ["601#2F00180201000000", "602#2F00180201000000", "000#0100"] + ["080#"] * 5
    log.write_text("".join(f"({k * 0.05:.6f}) {link.name} {frame}\n" for k, frame in enumerate(frames)))
    master.drain()
    subprocess.run(["canplayer", "-I", log], check=True)
    heard = [message.arbitration_id for message in master.drain()]
    assert heard.count(0x080) == 5
    assert heard.count(0x181) == heard.count(0x182) == 5


def test_python_can_reads_what_the_drives_send_with_its_stamps(drives, master):
    drives("--nodes", "1")
    master.map_position(1)
    stamps = []
    for _ in range(20):
        master.send(0x080)
        answer = master.hear(0x181)
        assert answer is not None
        assert answer.dlc == 6
        stamps.append(answer.timestamp)
        time.sleep(0.01)
    assert stamps == sorted(stamps)
    assert abs(stamps[-1] - time.time()) < 60.0


def test_drives_outlive_error_frames_and_python_can_sees_them(link, drives, master):
    drives("--nodes", "1")
    master.read(1, 0x1000)
    with socket.socket(socket.PF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as raw:
        raw.bind((link.name,))
        raw.send(struct.pack("=IB3x8s", ERROR_FRAME | BUS_OFF, 8, bytes(8)))
    errors = [message for message in master.drain() if message.is_error_frame]
    assert [message.arbitration_id & 0x1FFFFFFF for message in errors] == [BUS_OFF]
    assert master.read(1, 0x1000) & 0xFFFF == 0x0192
