"""Recordings of one's own: what is written as CSV, TRC or C3D in a lab frame comes back as the movement in T."""

import csv

import numpy as np
import pytest
from glenoid.inputs import InputError
from glenoid.validate.formats import read_markers
from glenoid.validate.movements import STERNUM_TO_JOINT_M
from glenoid.validate.readers import load_manifest, rotation_onto
from made_movements import synthetic

RATE = 100.0
NAMES = {"shoulder": "GH", "elbow": "EL", "wrist": "WR", "sternum": "STRN", "left": "LAC", "right": "RAC"}
UP = {"z": np.eye(3), "y": np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])}


def lab_markers(movement, up="z", arm="right", lean_rad=0.0):
    """Marker positions of a movement in a lab frame: turned about the vertical, shifted, with rests before and after."""
    mirror = np.array([1.0 if arm == "right" else -1.0, 1.0, 1.0])
    rows = {
        key: (getattr(movement, f"{key}_m") + STERNUM_TO_JOINT_M) * mirror for key in ("shoulder", "elbow", "wrist")
    }
    rows = {key: np.vstack([x[:1].repeat(30, axis=0), x, x[-1:].repeat(30, axis=0)]) for key, x in rows.items()}
    n = len(rows["wrist"])
    fixed = {"sternum": [0.0, 0.0, 0.0], "left": [-0.18, -0.05, 0.02], "right": [0.18, -0.05, 0.02]}
    rows |= {key: np.tile(x, (n, 1)) for key, x in fixed.items()}
    c, s = np.cos(0.7), np.sin(0.7)
    lean = np.linspace(0.0, lean_rad, n)
    out = {}
    for key, x in rows.items():
        bent = np.array([rotation_about_z(a) @ p for a, p in zip(lean, x, strict=True)])
        lab = bent @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]).T + [1.0, 2.0, 0.9]
        out[NAMES[key]] = lab @ UP[up]
    return out


def rotation_about_z(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def write_csv(path, markers):
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["time_s", *(f"{name}_{axis}" for name in markers for axis in "xyz")])
        for k, row in enumerate(np.hstack(list(markers.values()))):
            writer.writerow([k / RATE, *row])


def write_trc(path, markers):
    n = len(next(iter(markers.values())))
    head = "PathFileType\t4\t(X/Y/Z)\tx.trc\n"
    head += "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\n" + f"{RATE}\t{RATE}\t{n}\t{len(markers)}\tmm\n"
    head += "Frame#\tTime\t" + "\t\t\t".join(markers) + "\n"
    head += "\t\t" + "\t".join(f"{a}{k + 1}" for k in range(len(markers)) for a in "XYZ") + "\n"
    rows = np.hstack(list(markers.values())) * 1e3
    lines = ["\t".join([str(k + 1), str(k / RATE), *(f"{x:.6f}" for x in row)]) for k, row in enumerate(rows)]
    path.write_text(head + "\n".join(lines) + "\n")


def write_c3d(path, markers):
    c3d = pytest.importorskip("c3d")
    writer = c3d.Writer(point_rate=RATE, point_units="mm ")
    writer.set_point_labels(list(markers))
    for row in np.stack(list(markers.values()), axis=1):
        points = np.zeros((len(markers), 5))
        points[:, :3] = row * 1e3
        writer.add_frames([(points, np.zeros((0, 1)))])
    with path.open("wb") as file:
        writer.write(file)


WRITERS = {".csv": write_csv, ".trc": write_trc, ".c3d": write_c3d}


@pytest.fixture
def movement():
    return synthetic("a", "P1", np.deg2rad([20, -40, 45, 75]), np.deg2rad([60, -20, 25, 50]))


def manifest(tmp_path, file, **more):
    markers = "\n".join(f"      {key}: {name}" for key, name in NAMES.items())
    lines = "".join(f"    {key}: {value}\n" for key, value in more.items())
    path = tmp_path / "list.yaml"
    path.write_text(
        f"recordings:\n  - file: {file}\n    subject: P1\n    task: reach\n{lines}    markers:\n{markers}\n"
    )
    return path


@pytest.mark.parametrize("suffix", WRITERS)
@pytest.mark.parametrize("arm", ["right", "left"])
def test_movement_comes_back(tmp_path, movement, suffix, arm):
    WRITERS[suffix](tmp_path / f"reach{suffix}", lab_markers(movement, arm=arm))
    more = {"arm": arm} | ({"unit": "m"} if suffix == ".csv" else {})
    (again,) = load_manifest(manifest(tmp_path, f"reach{suffix}", **more))
    # the slow ends below 5 % of the peak speed are cut off: 0.2 % of the way of a minimum-jerk movement
    way = np.linalg.norm(movement.wrist_m[-1] - movement.wrist_m[0])
    for name in ("shoulder_m", "elbow_m", "wrist_m"):
        for k in (0, -1):
            assert np.linalg.norm(getattr(again, name)[k] - getattr(movement, name)[k]) < 0.01 * way + 1e-4
    assert again.upper_arm_length_m == pytest.approx(movement.upper_arm_length_m, abs=1e-4)
    assert (again.subject, again.phase, again.clean) == ("P1", "up", True)


def test_lab_axes_and_trunk_rotation_are_taken_out(tmp_path, movement):
    write_csv(tmp_path / "reach.csv", lab_markers(movement, up="y", lean_rad=0.2))
    (again,) = load_manifest(manifest(tmp_path, "reach.csv", unit="m", up="y"))
    # The turn about the line to the resting shoulder is not seen. It is 0.02/0.19 of the lean here, at the arm's distance; without
    # any correction the wrist would be off by the lean times its distance, ten times as much.
    unseen = 0.2 * 0.02 / 0.19
    for name in ("wrist_m", "shoulder_m"):
        off = np.linalg.norm(getattr(again, name)[-1] - getattr(movement, name)[-1])
        assert off < unseen * np.linalg.norm(getattr(movement, name)[-1])


def test_gaps_are_filled(tmp_path, movement):
    markers = lab_markers(movement)
    markers["WR"][60:64] = np.nan
    write_csv(tmp_path / "reach.csv", markers)
    (again,) = load_manifest(manifest(tmp_path, "reach.csv", unit="m"))
    assert np.isfinite(again.wrist_m).all()


def blanked(path):
    """The file with its NaNs as the empty cells that exporters write."""
    path.write_text(path.read_text().replace("nan", ""))


@pytest.mark.parametrize("suffix", WRITERS)
def test_a_marker_at_the_origin_is_hidden(tmp_path, movement, suffix):
    markers = lab_markers(movement)
    markers["EL"][60:64] = 0.0
    WRITERS[suffix](tmp_path / f"reach{suffix}", markers)
    rows = read_markers(tmp_path / f"reach{suffix}", "m")[1]["EL"]
    assert np.isnan(rows[60:64]).all()
    assert np.isfinite(np.delete(rows, range(60, 64), axis=0)).all()


@pytest.mark.parametrize("suffix", [".csv", ".trc"])
def test_empty_cells_are_gaps(tmp_path, movement, suffix):
    markers = lab_markers(movement)
    markers["EL"][60:64] = np.nan
    WRITERS[suffix](tmp_path / f"reach{suffix}", markers)
    blanked(tmp_path / f"reach{suffix}")
    (again,) = load_manifest(manifest(tmp_path, f"reach{suffix}", **({"unit": "m"} if suffix == ".csv" else {})))
    assert np.isfinite(again.elbow_m).all()
    assert np.abs(np.diff(again.elbow_m, axis=0)).max() < 0.02


def test_long_gaps_are_left_out_and_named(tmp_path, movement, capsys):
    markers = lab_markers(movement)
    write_csv(tmp_path / "good.csv", markers)
    markers["EL"][60:75] = np.nan
    write_csv(tmp_path / "gap.csv", markers)
    with pytest.raises(InputError, match=r"no recording is usable.*EL is not seen for 0\.15 s"):
        load_manifest(manifest(tmp_path, "gap.csv", unit="m"))
    both = manifest(tmp_path, "gap.csv", unit="m").read_text()
    (tmp_path / "both.yaml").write_text(both + both.replace("recordings:\n", "").replace("gap.csv", "good.csv"))
    assert len(load_manifest(tmp_path / "both.yaml")) == 1
    assert "left out" in capsys.readouterr().err


def test_a_gap_before_the_movement_does_not_matter(tmp_path, movement):
    markers = lab_markers(movement)
    markers["EL"][:25] = np.nan
    write_csv(tmp_path / "reach.csv", markers)
    assert len(load_manifest(manifest(tmp_path, "reach.csv", unit="m"))) == 1


def test_millimetres_told_as_metres_are_recognised(tmp_path, movement):
    write_csv(tmp_path / "reach.csv", {name: 1e3 * x for name, x in lab_markers(movement).items()})
    with pytest.raises(InputError, match="another unit"):
        load_manifest(manifest(tmp_path, "reach.csv", unit="m"))
    assert len(load_manifest(manifest(tmp_path, "reach.csv", unit="mm"))) == 1


def test_rotation_onto_turns_one_direction_into_the_other():
    a, b = np.array([0.3, -0.2, 0.9]), np.array([-0.5, 0.1, 0.4])
    R = rotation_onto(a, b)
    assert np.allclose(R @ R.T, np.eye(3))
    assert np.allclose(R @ a / np.linalg.norm(a), b / np.linalg.norm(b))


BAD = {
    "no unit": ({}, "reach.csv", "unit"),
    "no file": ({"unit": "m"}, "none.csv", "No such file"),
    "format": ({}, "reach.xlsx", ".csv, .trc or .c3d"),
    "unknown key": ({"unit": "m", "speed": 3}, "reach.csv", "unknown key"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_recordings_are_named(tmp_path, movement, case):
    more, file, word = BAD[case]
    write_csv(tmp_path / "reach.csv", lab_markers(movement))
    with pytest.raises(InputError, match=word):
        load_manifest(manifest(tmp_path, file, **more))


BROKEN = {
    "empty.csv": ("", "first line"),
    "semicolons.csv": ("time_s;A_x;A_y;A_z\n0;1;2;3\n", "commas"),
    "axis.csv": ("time_s,A_x,A_y\n0,1,2\n", "A_z"),
    "words.csv": ("time_s,A_x,A_y,A_z\n0,1,2,3\n1,x,2,3\n2,1,2,3\n", "'x'"),
    "one.csv": ("time_s,A_x,A_y,A_z\n0,1,2,3\n", "1 samples"),
    "short.trc": ("PathFileType\t4\n", "head"),
    "unit.trc": ("P\nDataRate\tUnits\n100\tinches\nF\tT\tA\n\n1\t0\t1\t2\t3\n", "inches"),
    "text.c3d": ("hello", "C3D"),
}


@pytest.mark.parametrize("file", BROKEN)
def test_files_that_are_none_are_named_with_the_reason(tmp_path, file):
    text, reason = BROKEN[file]
    (tmp_path / file).write_text(text)
    with pytest.raises(InputError, match=reason) as caught:
        read_markers(tmp_path / file, "m")
    assert file in str(caught.value)


def test_missing_marker_is_named(tmp_path, movement):
    markers = lab_markers(movement)
    del markers["EL"]
    write_csv(tmp_path / "reach.csv", markers)
    with pytest.raises(InputError, match="no marker EL"):
        load_manifest(manifest(tmp_path, "reach.csv", unit="m"))


def test_uneven_times_are_refused(tmp_path):
    (tmp_path / "a.csv").write_text("time_s,A_x,A_y,A_z\n0,1,2,3\n0.01,1,2,3\n0.5,1,2,3\n")
    with pytest.raises(InputError, match="evenly"):
        read_markers(tmp_path / "a.csv", "m")
