"""The files that describe the process data, read by tools this project did not write, against frames of its codec."""

import json
import subprocess

import canopen
import cantools
import pytest
from glenoid.programs import program

NODES = range(1, 7)


@pytest.fixture(scope="module")
def folder():
    return program("glenoid-pdo-files").parents[1] / "share"


@pytest.fixture(scope="module")
def golden():
    out = subprocess.run(
        [program("wires_probe"), "golden", "1", "100"], check=True, capture_output=True, text=True
    ).stdout
    return [json.loads(line) for line in out.splitlines()]


@pytest.fixture(scope="module")
def database(folder):
    return cantools.database.load_file(folder / "glenoid_mapping.dbc")


def canopen_node(folder, node_id):
    node = canopen.LocalNode(node_id, str(folder / "glenoid_mapping.eds"))
    node.associate_network(canopen.Network())
    node.rpdo.read(from_od=True)
    node.tpdo.read(from_od=True)
    return node


def test_cantools_decodes_what_the_codec_encodes(database, golden):
    for frame in golden:
        decoded = database.decode_message(frame["id"], bytes.fromhex(frame["data"]))
        assert decoded == frame["values"]


def test_cantools_encodes_what_the_codec_encodes(database, golden):
    for frame in golden:
        assert database.encode_message(frame["id"], frame["values"]).hex() == frame["data"]


def test_canopen_finds_the_mapping_in_the_data_sheet(folder, golden):
    nodes = {number: canopen_node(folder, number) for number in NODES}
    for frame in golden:
        node = nodes[frame["node"]]
        received = "controlword" in frame["values"]
        pdo = (node.rpdo if received else node.tpdo)[1]
        assert pdo.cob_id == frame["id"]
        assert len(pdo.data) == frame["size"]
        pdo.data = bytearray.fromhex(frame["data"])
        assert {variable.name: variable.raw for variable in pdo.map} == frame["values"]


def test_mapped_objects_are_those_of_cia_402(folder):
    node = canopen_node(folder, 1)
    assert [variable.index for variable in node.rpdo[1].map] == [0x6040, 0x607A]
    assert [variable.index for variable in node.tpdo[1].map] == [0x6041, 0x6064, 0x6077]
    assert node.rpdo[1].trans_type == node.tpdo[1].trans_type == 1


def test_every_frame_of_a_cycle_is_in_the_database(database):
    ids = {message.frame_id for message in database.messages}
    assert {0x080, 0x77F} <= ids
    assert {base + node for base in (0x180, 0x200, 0x700) for node in NODES} <= ids


@pytest.mark.parametrize(
    ("frame_id", "data", "values"),
    [
        # RPDO1 of node 3: enable operation, target 0x00012345 counts
        (0x203, "0f 00 45 23 01 00", {"controlword": 0x000F, "target_position": 0x12345}),
        # the same, target -2 counts
        (0x203, "0f 00 fe ff ff ff", {"controlword": 0x000F, "target_position": -2}),
        # TPDO1 of node 6: operation enabled and following (bit 12), 1000 counts, -50 per mille
        (0x186, "37 12 e8 03 00 00 ce ff", {"statusword": 0x1237, "position_actual": 1000, "torque_actual": -50}),
    ],
)
def test_golden_frames(database, frame_id, data, values):
    assert database.decode_message(frame_id, bytes.fromhex(data)) == values
