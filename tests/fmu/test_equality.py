"""One motion, however it is computed: FMI 2, FMI 3, either compiler, the core itself; bit for bit."""

import random

import fmpy
import fmu_driver
import numpy as np
import pytest

OK = 0
H = 1 / 512
CORE_NAMES = {
    "q": "q_rad", "dq": "dq_rad_per_s", "ddq": "ddq_rad_per_s2", "shoulder": "shoulder_m", "elbow": "elbow_m",
    "wrist": "wrist_m", "girdle": "girdle", "swivel": "swivel_rad", "progress": "progress", "energy": "energy_kg_m2",
    "misalignment": "misalignment_m", "status": "status",
}  # fmt: skip


def random_target(rng):
    """Around the shoulder at 0.17 m, most of them in reach."""
    return (rng.uniform(-0.1, 0.5), rng.uniform(0.1, 0.55), rng.uniform(-0.4, 0.4))


def wander(unit, rng, steps=1500):
    """Many movements, re-planned and stopped at random moments; every output after every step."""
    rows = []
    for k in range(steps):
        if rng.random() < 0.01:
            assert unit.set("target", random_target(rng)) == OK
        if rng.random() < 0.003:
            assert unit.set("stop", rng.random() < 0.5) == OK
        assert unit.step(k * H, H) == OK
        rows.append(unit.outputs())
    return np.array(rows)


def same_bits(a, b):
    return np.array_equal(np.asarray(a, float).view(np.uint64), np.asarray(b, float).view(np.uint64))


def test_fmi2_and_fmi3_agree_through_fmpy(archives):
    results = {}
    for key, archive in archives.items():
        names = [v.name for v in archive.outputs]
        results[key] = fmpy.simulate_fmu(str(archive.path), output=names, output_interval=0.01, fmi_type="CoSimulation")
    two, three = results["fmi2"], results["fmi3"]
    assert two.dtype.names == three.dtype.names
    assert len(two) == 301
    for name in two.dtype.names:
        assert same_bits(two[name], three[name]), name


def test_fmi2_and_fmi3_agree_while_wandering(archives):
    traces = []
    for archive in archives.values():
        with fmu_driver.Instance(archive) as unit:
            traces.append(wander(unit.initialize(), random.Random(fmu_driver.SEED)))
    assert same_bits(*traces)


def test_both_compilers_give_the_same_bits(archives, build_folder, tmp_path):
    host = build_folder / "host/Glenoid.so"
    if not (build_folder / "binaries").exists():
        pytest.skip("built without ziglang: there is one compiler only")
    archive = archives["fmi3"]
    other = fmu_driver.Archive(archive.path, tmp_path, library=host)
    with fmu_driver.Instance(archive) as a, fmu_driver.Instance(other) as b:
        first = wander(a.initialize(), random.Random(fmu_driver.SEED))
        second = wander(b.initialize(), random.Random(fmu_driver.SEED))
    differing = np.argwhere(first != second)
    assert len(differing) == 0, (
        f"{len(differing)} of {first.size} numbers differ, first at step {differing[0][0]}, "
        f"output {archive.outputs[differing[0][1]].name}, largest difference {np.abs(first - second).max():.3g}"
    )


def test_the_fmu_equals_the_core(core, archive, rng):
    settings = core.MotionSettings()
    generator = core.MotionGenerator(settings, 0.0)
    target = [v.start for v in archive.variables.values() if v.name.startswith("target")]
    with fmu_driver.Instance(archive) as unit:
        unit.initialize()
        for k in range(1500):
            if rng.random() < 0.01:
                target = random_target(rng)
                assert unit.set("target", target) == OK
            assert unit.step(k * H, H) == OK
            generator.command(k * H, np.array(target))
            if k % 10 == 0:
                expected = generator.sample(np.array([k * H + H]))
                for name, column in CORE_NAMES.items():
                    assert same_bits(np.ravel(unit.get(name)), np.ravel(expected[column])), f"{name} at step {k}"


def test_the_reference_result_is_reproduced(archive):
    """extra/org.fmi-standard.fmi-ls-ref, to the rounding that another mathematical library may have."""
    path = archive.folder / "extra/org.fmi-standard.fmi-ls-ref/Glenoid_out.csv"
    reference = np.genfromtxt(path, delimiter=",", names=True, deletechars="", replace_space=" ")
    names = [v.name for v in archive.outputs]
    result = fmpy.simulate_fmu(str(archive.path), output=names, output_interval=0.01, fmi_type="CoSimulation")
    for name in names:
        np.testing.assert_allclose(result[name], reference[f"{name}"], rtol=1e-9, atol=1e-9, err_msg=name)
