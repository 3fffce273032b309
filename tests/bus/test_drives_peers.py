"""The simulated drives as programs see them that this project did not write: canopen as SDO client and master, tshark."""

import shutil
import subprocess
import time

import can
import canopen
import pytest
from canopen.profiles.p402 import BaseNode402
from glenoid.programs import program

PROFILES = [
    "nominal",
    "epos4",
    "ingenia_summit",
    "isel_imd20",
    "delta_servo",
    "technosoft_ipos",
    "nanotec_n5",
    "patient",
]
PATIENCE_S = 10.0


def until(condition):
    """Waits for something that has no answer of its own."""
    end = time.monotonic() + PATIENCE_S
    while not condition() and time.monotonic() < end:
        time.sleep(0.01)
    assert condition()


def write_eds(directory, profile="nominal"):
    path = directory / f"{profile}.eds"
    subprocess.run([program("glenoid-drives"), "--profile", profile, "--eds", path], check=True)
    return path


@pytest.fixture
def network(python_bus, monkeypatch):
    monkeypatch.setattr(canopen.sdo.SdoClient, "MAX_RETRIES", 20)  # the first may come while the drive boots
    network = canopen.Network(python_bus)
    network.connect()
    yield network
    network.notifier.stop(2)


def configure_position_pdos(node):
    """Controlword and target in RPDO 1, statusword and position in TPDO 1, both with SYNC; by canopen's own writer."""
    node.rpdo.read()
    node.tpdo.read()
    node.rpdo[1].clear()
    node.rpdo[1].add_variable(0x6040)
    node.rpdo[1].add_variable(0x607A)
    node.rpdo[1].trans_type = 1
    node.rpdo[1].enabled = True
    node.rpdo[1].save()
    node.tpdo[1].clear()
    node.tpdo[1].add_variable(0x6041)
    node.tpdo[1].add_variable(0x6064)
    node.tpdo[1].trans_type = 1
    node.tpdo[1].enabled = True
    node.tpdo[1].save()


@pytest.mark.parametrize("profile", PROFILES)
def test_eds_is_one_that_canopen_reads_and_says_what_the_drive_says(profile, tmp_path, drives, network):
    dictionary = canopen.import_od(str(write_eds(tmp_path, profile)), node_id=5)
    drives("--nodes", "5", "--profile", profile)
    node = network.add_node(5, dictionary)
    assert node.sdo[0x1000].raw & 0xFFFF == 0x0192
    objects = [one for one in dictionary.values() if one.index >= 0x1000]  # below are data types
    rows = [row for one in objects for row in (one.values() if hasattr(one, "subindices") else [one])]
    assert len(rows) > 150
    live = {0x1001, 0x6041, 0x6062, 0x6064, 0x6076, 0x6072, 0x608F, 0x6091, 0x606C, 0x6077, 0x60F4, 0x1008, 0x1009}
    different = {}
    history = [row for row in rows if row.index == 0x1003 and row.subindex > 0]
    for row in history:
        with pytest.raises(canopen.SdoAbortedError) as empty:
            node.sdo.upload(row.index, row.subindex)
        assert empty.value.code == 0x08000024
    for row in (row for row in rows if row not in history):
        raw = node.sdo.upload(row.index, row.subindex)
        if row.default is not None and row.index not in live and row.decode_raw(raw) != row.default:
            different[row.index, row.subindex] = (row.decode_raw(raw), row.default)
        if row.data_type != 9:
            assert len(raw) * 8 == len(row), row.name
    assert not different


def test_canopen_reads_and_writes_by_segments(tmp_path, drives, network):
    drives("--nodes", "1")
    node = network.add_node(1, str(write_eds(tmp_path)))
    assert node.sdo[0x1008].raw == "Glenoid nominal joint drive"
    node.sdo[0x2F20].raw = "third joint of the shoulder"
    assert node.sdo[0x2F20].raw == "third joint of the shoulder"
    for index, sub, code in ((0x5FFF, 0, 0x06020000), (0x1018, 9, 0x06090011)):
        with pytest.raises(canopen.SdoAbortedError) as refused:
            node.sdo.upload(index, sub)
        assert refused.value.code == code
    with pytest.raises(canopen.SdoAbortedError) as refused:
        node.sdo.download(0x6041, 0, b"\0\0")
    assert refused.value.code == 0x06010002


def test_canopen_stores_and_restores_the_parameters(tmp_path, drives, network):
    drives("--nodes", "1")
    node = network.add_node(1, str(write_eds(tmp_path)))
    node.sdo[0x6065].raw = 77
    node.store()
    node.nmt.state = "RESET"
    node.nmt.wait_for_bootup(PATIENCE_S)
    assert node.sdo[0x6065].raw == 77
    node.restore()
    node.nmt.state = "RESET"
    node.nmt.wait_for_bootup(PATIENCE_S)
    assert node.sdo[0x6065].raw == node.object_dictionary[0x6065].default


def test_canopens_402_node_walks_through_the_states(tmp_path, drives, network):
    drives("--nodes", "1")
    node = BaseNode402(1, canopen.import_od(str(write_eds(tmp_path)), node_id=1))
    network.add_node(node)
    node.nmt.state = "PRE-OPERATIONAL"
    node.sdo[0x1017].raw = 20
    node.nmt.wait_for_heartbeat()
    configure_position_pdos(node)
    node.setup_402_state_machine()
    node.nmt.state = "OPERATIONAL"
    until(lambda: node.nmt.state == "OPERATIONAL")
    node.sdo[0x6060].raw = 8
    # Its state setter waits for PDOs that only a SYNC brings.
    network.sync.start(0.01)
    node.rpdo[1].start(0.01)
    for state in ("SWITCH ON DISABLED", "READY TO SWITCH ON", "SWITCHED ON", "OPERATION ENABLED"):
        node.state = state
        until(lambda state=state: node.state == state)
    assert node.op_mode == "CYCLIC SYNCHRONOUS POSITION"
    assert node.is_op_mode_supported("CYCLIC SYNCHRONOUS POSITION")
    assert not node.is_op_mode_supported("PROFILED POSITION")
    network.sync.stop()
    node.rpdo[1].stop()


def test_second_master_moves_a_joint_and_sees_its_fault(tmp_path, drives, network):
    running = drives("--nodes", "1,2", "--fault", "node=2,at=0,kind=none")
    node = network.add_node(2, str(write_eds(tmp_path)))
    configure_position_pdos(node)
    node.sdo[0x60C2][1].raw = 10
    node.sdo[0x6060].raw = 8
    node.nmt.state = "OPERATIONAL"
    feedback = []
    node.tpdo[1].add_callback(lambda pdo: feedback.append((pdo[0].raw, pdo[1].raw)))

    def cycle(controlword, target):
        seen = len(feedback)
        node.rpdo[1][0].raw = controlword
        node.rpdo[1][1].raw = target
        node.rpdo[1].transmit()
        network.sync.transmit()
        until(lambda: len(feedback) > seen)

    cycle(0x06, 0)
    cycle(0x06, 0)
    start = feedback[-1][1]
    cycle(0x07, start)
    until(lambda: cycle(0x0F, start) or feedback[-1][0] & 0x6F == 0x27)
    for step in range(1, 51):
        cycle(0x0F, start + 200 * step)
        time.sleep(0.01)
    assert feedback[-1][0] & 1 << 12
    until(lambda: cycle(0x0F, start + 10000) or abs(feedback[-1][1] - start - 10000) < 50)
    node.sdo[0x2F00][2].raw = 0x4210
    node.sdo[0x2F00][1].raw = 4
    until(lambda: node.emcy.active)
    assert node.emcy.active[-1].code == 0x4210
    assert node.sdo[0x603F].raw == 0x4210
    until(lambda: cycle(0x0F, start + 10000) or feedback[-1][0] & 0x4F == 0x08)
    report = running.stop()
    assert [one["state"] for one in report["drives"]] == ["switch-on-disabled", "fault"]
    assert report["drives"][1]["last_emergency"] == 0x4210
    assert report["unanswered_syncs"] == 0


def test_tshark_decodes_a_session(tmp_path, drives, python_bus):
    if shutil.which("tshark") is None:
        pytest.skip("no tshark: apt-get install tshark")
    running = drives("--nodes", "3")
    log = tmp_path / "session.log"
    lines = []

    def note(message):
        stamp = message.timestamp or time.time()
        lines.append(f"({stamp:.6f}) can0 {message.arbitration_id:03X}#{message.data.hex().upper()}\n")

    notifier = can.Notifier(python_bus, [note])

    def send(identifier, data):
        python_bus.send(can.Message(arbitration_id=identifier, data=data, is_extended_id=False))
        time.sleep(0.05)

    send(0x603, bytes.fromhex("4000100000000000"))  # device type
    send(0x603, bytes.fromhex("40FF5F0000000000"))  # no such object
    send(0x603, bytes.fromhex("2B17100032000000"))  # heartbeat every 50 ms
    send(0x000, bytes.fromhex("0103"))
    send(0x080, b"")
    send(0x603, bytes.fromhex("2F002F0104000000"))  # fault
    time.sleep(0.2)
    notifier.stop()
    running.stop()
    log.write_text("".join(lines))  # as candump -L writes it
    fields = ["canopen.function_code", "canopen.node_id", "canopen.sdo.abort_code", "canopen.em.err_code"]
    fields += ["canopen.nmt_ctrl.cd", "canopen.nmt_guard.state"]
    command = ["tshark", "-r", log, "-d", "can.subdissector,canopen", "-T", "fields", "-E", "separator=;"]
    for field in fields:
        command += ["-e", field]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    rows = [line.split(";") for line in done.stdout.splitlines()]
    answers = [row for row in rows if int(row[0] or "0", 0) == 0x580 >> 7]
    number = lambda text: int(text, 0)  # noqa: E731
    assert {number(row[2]) for row in answers if row[2]} == {0x06020000}
    assert 0x2310 in {number(row[3]) for row in rows if row[3]}
    assert 0x05 in {number(row[5]) for row in rows if row[5]}
    assert all(number(row[1]) == 3 for row in answers)
