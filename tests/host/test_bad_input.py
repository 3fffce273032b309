"""What is refused, and that the message names where, key, value and rule."""

import pytest

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
}


@pytest.mark.parametrize("case", OPTIONS)
def test_bad_option_is_refused_in_words(run, case):
    arguments, words = OPTIONS[case]
    done = run("plan", *arguments)
    assert done.code == 2
    for word in words:
        assert word in done.err.replace("\n", " ")


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
