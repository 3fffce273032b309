"""What is refused, and that the message names where, key, value and rule."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from glenoid.recording import read_recording
from glenoid.tables import write_csv

GOOD = "start_q_deg: [15, -30, 30, 60]\ntarget_m: [0.2, 0.42, 0.25]\n"
FILES = {
    "unknown key": (GOOD + "traget_m: [1, 2, 3]\n", ["traget_m", "[1, 2, 3]", "unknown key"]),
    "unknown key of a section": (GOOD + "subject: {statur_m: 1.8}\n", ["subject.statur_m", "1.8", "unknown key"]),
    "nan": ("target_m: [.nan, 0.4, 0.2]\n", ["target_m.0", "nan", "finite"]),
    "infinite": (GOOD + "duration_s: .inf\n", ["duration_s", "inf"]),
    "too short": ("target_m: [0.4, 0.2]\n", ["target_m"]),
    "text for a number": (GOOD + "duration_s: soon\n", ["duration_s", "soon", "number"]),
    "duration zero": (GOOD + "duration_s: 0\n", ["duration_s", "0", "0.05"]),
    "two starts": (GOOD + "start_q_rad: [0, 0, 0, 1]\n", ["start_q_deg or start_q_rad"]),
    "no such rhythm": (GOOD + "rhythm: {model: Waltz}\n", ["rhythm.model", "Waltz", "SoltaniZarrin2017"]),
    "gain out of range": (GOOD + "rhythm: {gain: 7}\n", ["gain", "7", "1.5"]),
    "smoothing out of range": (GOOD + "rhythm: {smoothing_rad: 2}\n", ["smoothing", "2", "rad", "0.3"]),
    "stature zero": (GOOD + "subject: {stature_m: 0}\n", ["stature", "0", "m", "0.5"]),
    "mass negative": (GOOD + "subject: {mass_kg: -70}\n", ["mass", "-70", "kg"]),
    "length zero": (GOOD + "subject: {upper_arm_length_m: 0}\n", ["upper_arm", "0", "m"]),
    "length negative": (GOOD + "subject: {forearm_length_m: -0.2}\n", ["forearm", "-0.2", "m"]),
    "limits crossed": (GOOD + "subject: {limits_deg: {plane: [20, -20]}}\n", ["eta"]),
    "not a mapping": ("- 1\n- 2\n", ["mapping"]),
    "not YAML": ("a: [1, 2\n", ["YAML"]),
    "empty": ("", ["mapping"]),
    "key twice": (GOOD + "duration_s: 1\nduration_s: 2\n", ["yaml:4:", "duration_s", "twice"]),
    "truth for a number": (GOOD + "duration_s: true\n", ["duration_s", "True", "must be a number"]),
    "truth in a point": ("target_m: [true, 0.4, 0.2]\n", ["target_m.0", "True", "must be a number"]),
    "quoted number": (GOOD + 'duration_s: "1"\n', ["duration_s", "'1'", "must be a number"]),
    "truth for a limit": (
        GOOD + "subject: {limits_deg: {elevation: [false, 90]}}\n",
        ["limits_deg.elevation.0", "must be a number"],
    ),
    "millimetres": ("target_m: [200, 420, 250]\n", ["target_m", "200", "-5 to 5 m", "millimetres"]),
    "word for a section": (GOOD + "subject: me.yaml\n", ["subject", "me.yaml", "section of keys"]),
    "list for a key": (GOOD + "? [1, 2]\n: 3\n", ["yaml:3:", "a key must be plain text"]),
    "mapping for a key": (GOOD + "? {a: 1}\n: 3\n", ["yaml:3:", "a key must be plain text"]),
    "deep": ("a: " + "[" * 3000 + "]" * 3000 + "\n", ["without end"]),
    "itself": (GOOD + "subject: &me\n  limits_deg: *me\n", ["limits_deg"]),
    "no such day": (GOOD + "name: 2020-13-45\n", ["month"]),
    "two documents": (GOOD + "---\n" + GOOD, ["yaml:3:", "document"]),
    "section's key twice": (GOOD + "rhythm: {gain: 1, gain: 0.5}\n", ["yaml:3:", "gain", "twice"]),
}


@pytest.mark.parametrize("case", FILES)
@pytest.mark.parametrize("command", ["plan", "simulate"])
def test_bad_reach_is_refused_in_words(run, tmp_path, case, command):
    text, words = FILES[case]
    file = tmp_path / "reach.yaml"
    file.write_text(text, encoding="utf-8")
    done = run(command, file)
    assert done.code == 2
    assert done.out == ""
    assert "Traceback" not in done.err
    for word in words:
        assert word in done.err


OPTIONS = {
    "missing file": (["no_such.yaml"], ["no_such.yaml", "No such file"]),
    "missing subject": (["--subject", "no_such.yaml"], ["no_such.yaml"]),
    "short target": (["--target-m", "1,2"], ["--target-m", "1,2", "3 numbers"]),
    "words for numbers": (["--target-m", "a,b,c"], ["--target-m", "a,b,c"]),
    "target not finite": (["--target-m", "nan,0,0"], ["target_m", "nan", "finite"]),
    "start out of range": (["--start-q-deg", "190,0,0,60"], ["theta", "rad"]),
    "unknown swivel": (["--swivel", "Best"], ["swivel.mode", "Best", "MinimumEnergy"]),
    "unknown metric": (["--metric", "taxicab"], ["metric", "taxicab"]),
    "unknown limit": (["--limits-deg", "knee=0,90"], ["knee", "unknown key"]),
    "unknown option": (["--quickly"], ["--quickly"]),
    "semicolons": (["--target-m", "0.2;0.4;0.2"], ["--target-m", "0.2;0.4;0.2", "commas"]),
    "degrees as rad": (["--start-q-rad", "15,-30,30,60"], ["start.q[1]", "15 rad", "3.14"]),
    "two starts": (["--start-q-rad", "0,0,0,1", "--start-q-deg", "0,0,0,60"], ["start_q_deg or start_q_rad"]),
    "rate not finite": (["--rate-hz", "nan"], ["--rate-hz", "nan", "hz", "100000"]),
    "picture of no format": (["--plot", "reach.doc"], ["reach.doc", ".png", ".svg", ".pdf"]),
    "number with a comma": (["--duration-s", "1,5"], ["--duration-s = '1,5'", "must be a number"]),
    "number with its unit": (["--gain", "50 %"], ["--gain = '50 %'", "must be a number"]),
    "limit twice": (["--limits-deg", "plane=0,9", "--limits-deg", "plane=0,8"], ["--limits-deg plane", "twice"]),
    "word too many": (["a.yaml", "b.yaml"], ["b.yaml"]),
    "missing device": (["--exo", "no_such.yaml"], ["no_such.yaml: No such file"]),
}


@pytest.mark.parametrize("case", OPTIONS)
def test_bad_option_is_refused_in_words(run, case):
    arguments, words = OPTIONS[case]
    done = run("plan", *arguments)
    assert done.code == 2
    assert done.err.startswith("glenoid: ")
    for word in words:
        assert word in done.err


SIMULATE = {
    "endless": (["--stop-s", "inf"], ["--stop-s", "inf s", "3600"]),
    "no end": (["--stop-s", "nan"], ["--stop-s", "nan s"]),
    "before the start": (["--stop-s=-1"], ["--stop-s", "-1 s"]),
    "step not finite": (["--step-s", "nan"], ["--step-s", "nan s", "10 s"]),
    "no step": (["--step-s", "0"], ["--step-s", "0 s", "1e-05"]),
    "too many steps": (["--step-s", "1e-5", "--stop-s", "3600"], ["--step-s = 1e-05 s", "360000000 steps", "1000000"]),
    "no such FMI": (["--fmi", "1"], ["--fmi", "'1'", "'2', '3'"]),
}


@pytest.mark.parametrize("case", SIMULATE)
def test_times_without_end_are_refused(run, case):
    arguments, words = SIMULATE[case]
    done = run("simulate", *arguments)
    assert done.code == 2
    for word in words:
        assert word in done.err


@pytest.mark.parametrize(
    "arguments",
    [
        ("plan", "--csv", "taken"),
        ("plan", "--plot", "taken.png"),
        ("simulate", "--csv", "taken"),
        ("simulate", "--plot", "taken.png"),
        ("info", "--exo", "generic_75_75", "--plot", "taken.png"),
        ("plan", "--csv", "no/where.csv"),
        ("plan", "--csv", "/dev/full"),
        ("plan", "--batch", "taken"),
        ("rehearse", "taken"),
        ("sweep", "taken"),
    ],
    ids=" ".join,
)
def test_files_that_cannot_be_used_are_named(run, tmp_path, monkeypatch, arguments):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "taken").mkdir()
    (tmp_path / "taken.png").mkdir()
    done = run(*arguments)
    assert done.code == 2
    assert done.err.startswith(f"glenoid: {arguments[-1]}: ")
    assert len(done.err.splitlines()) == 1


def test_picture_of_the_axes_wants_a_device(run):
    done = run("info", "--plot", "axes.png")
    assert done.code == 2
    assert "--exo" in done.err


def test_limits_that_no_person_has_are_refused_by_info_too(run, tmp_path):
    file = tmp_path / "me.yaml"
    file.write_text("limits_deg: {elevation: [0, 1000]}\n", encoding="utf-8")
    done = run("info", "--subject", file)
    assert done.code == 2
    for word in ("limits.upper[theta]", "17.45", "rad"):
        assert word in done.err


ROWS = "time_s,q1_rad\n0,0\n0.1,0.1\n"
TABLES = {
    "empty": (b"", ["no column time_s"]),
    "header alone": (b"time_s,q1_rad\n", ["two samples"]),
    "semicolons": (b"time_s;q1_rad\n0;0\n0,1;0,1\n", ["semicolons", "commas"]),
    "word": (b"time_s,q1_rad\n0,0\n1,soon\n", [":3:", "q1_rad", "'soon'", "number"]),
    "ragged": (b"time_s,q1_rad\n0,0\n1\n", [":3:", "1 cells", "2"]),
    "not finite": (b"time_s,q1_rad\n0,nan\n1,1\n", ["finite"]),
    "degrees": (b"time_s,q1_deg\n0,10\n1,20\n", ["q1_rad"]),
    "backwards": (b"time_s,q1_rad\n1,1\n0,1\n", ["time 0.0 s", "grow"]),
    "Latin-1": (b"time_s,q1_rad\n0,\xe9\n", ["UTF-8"]),
}


@pytest.mark.parametrize("case", TABLES)
def test_bad_table_is_refused_in_words(run, tmp_path, case):
    content, words = TABLES[case]
    file = tmp_path / "motion.csv"
    file.write_bytes(content)
    done = run("replay", file)
    assert done.code == 2
    assert str(file) in done.err
    for word in words:
        assert word in done.err


@pytest.mark.parametrize(
    "content",
    [
        ROWS.encode(),
        b"\xef\xbb\xbf" + ROWS.encode(),
        ROWS.replace("\n", "\r\n").encode(),
        ROWS.replace("\n", "\n\n").encode(),
    ],
    ids=["plain", "byte order mark", "CRLF", "blank lines"],
)
def test_table_is_read_as_spreadsheets_write_it(tmp_path, content):
    file = tmp_path / "motion.csv"
    file.write_bytes(content)
    recording = read_recording(file)
    assert recording.time_s.tolist() == [0.0, 0.1]
    assert recording.position_rad.tolist() == [[0.0], [0.1]]


def test_every_problem_of_a_file_is_named_at_once(run, tmp_path):
    file = tmp_path / "reach.yaml"
    file.write_text("duration_s: soon\ntarget_m: 3\n", encoding="utf-8")
    done = run("plan", file)
    assert len(done.err.strip().splitlines()) == 2


def test_yaml_cannot_run_code(run, tmp_path):
    file, made = tmp_path / "reach.yaml", tmp_path / "made"
    file.write_text(f"name: !!python/object/apply:os.mkdir [{made}]\n", encoding="utf-8")
    assert run("plan", file).code == 2
    assert not made.exists()


def test_a_number_may_be_written_as_programs_write_it(run, tmp_path):
    file = tmp_path / "reach.yaml"
    file.write_text(GOOD + "rhythm: {smoothing_rad: 1e-1}\nduration_s: 15E-1\n", encoding="utf-8")
    plain = tmp_path / "plain.yaml"
    plain.write_text(GOOD + "rhythm: {smoothing_rad: 0.1}\nduration_s: 1.5\n", encoding="utf-8")
    assert run("plan", file, "--json").json == run("plan", plain, "--json").json


def test_names_are_printed_and_drawn_as_they_are(run, tmp_path):
    name = r"cost $5 [bold]x[/nope] $\frac"
    file = tmp_path / "reach.yaml"
    file.write_text(GOOD + f"name: '{name}'\nsubject: {{name: '{name}'}}\n", encoding="utf-8")
    done = run("plan", file, "--exo", "generic_75_75", "--plot", tmp_path / "reach.png")
    assert done.code == 0
    assert name in done.out
    assert (tmp_path / "reach_exo.png").is_file()


def test_a_file_is_there_whole_or_as_it_was(tmp_path):
    file = tmp_path / "motion.csv"
    file.write_text("before", encoding="utf-8")
    unequal = {"a_m": np.zeros(2), "b_m": np.zeros(3)}
    with pytest.raises(ValueError, match="dimension"):
        write_csv(unequal, file)
    assert file.read_text(encoding="utf-8") == "before"
    assert [path.name for path in tmp_path.iterdir()] == ["motion.csv"]


@pytest.mark.parametrize("arguments", [("plan", "--json"), ("plan",), ("info",), ("--help",)], ids=" ".join)
def test_a_reader_who_leaves_is_no_failure(arguments):
    command = [sys.executable, "-m", "glenoid", *arguments]
    reader, writer = os.pipe()
    os.close(reader)
    done = subprocess.run(command, stdout=writer, stderr=subprocess.PIPE, check=False)
    os.close(writer)
    assert (done.returncode, done.stderr) == (0, b"")


def test_a_full_disk_behind_standard_output_is_named():
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "glenoid", "plan"], stdout=full, stderr=subprocess.PIPE, check=False
        )
    assert done.returncode == 2
    assert done.stderr.startswith(b"glenoid: standard output: ")
    assert len(done.stderr.splitlines()) == 1
