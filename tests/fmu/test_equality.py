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
    "misalignment": "misalignment_m", "exo.residual": "exo_residual_m", "exo.q": "exo_q_rad",
    "exo.dq": "exo_dq_rad_per_s", "status": "status",
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


# Parameters of the device as the FMU and as the core take them; each changes the joints or refuses the default reach.
DEVICES = {
    "fixed length": (
        {"exo.girdleDrives": 2, "exo.girdleLink": 0.15},
        {"girdle_drives": "NoLength", "girdle_link_m": 0.15},
    ),
    "vertical slide": ({"exo.girdleDrives": 3}, {"girdle_drives": "VerticalOnly"}),
    "no drives": ({"exo.girdleDrives": 4}, {"girdle_drives": "NoDrives"}),
    "carried base": (
        {"exo.baseFollowsGirdle": True, "exo.girdleOrder": 2},
        {"base_follows_girdle": True, "girdle_order": "ElevationFirst"},
    ),
    "other assembly": ({"exo.upper[4]": 0.0}, {"upper_rad": [1e9, 1e9, 1e9, 0.0, 1e9, 1e9]}),
    "upper range": ({"exo.upper[4]": 1.0}, {"upper_rad": [1e9, 1e9, 1e9, 1.0, 1e9, 1e9]}),
    "lower range": ({"exo.lower[6]": 0.9}, {"lower_rad": [-1e9, -1e9, -1e9, -1e9, -1e9, 0.9]}),
    "near singular": ({"exo.minSingularity": 1.0}, {"min_singularity_rad": 1.0}),
}


def whole_reach(unit):
    for k in range(90):
        assert unit.step(k * 16 * H, 16 * H) == OK
        yield unit.outputs()


@pytest.mark.parametrize("case", DEVICES)
def test_a_device_in_the_fmu_is_the_device_in_the_core(core, archive, case):
    values, members = DEVICES[case]
    settings = core.MotionSettings()
    exo = core.ExoSettings()
    for name, value in members.items():
        kind = {"girdle_drives": core.GirdleDrives, "girdle_order": core.GirdleOrder}.get(name)
        setattr(exo, name, getattr(kind, value) if kind else np.array(value) if isinstance(value, list) else value)
    settings.exo = exo
    generator = core.MotionGenerator(settings, 0.0)
    generator.command(0.0, np.array([0.20, 0.42, 0.25]))
    expected = generator.sample(np.arange(1, 91) * (16 * H))
    with fmu_driver.Instance(archive) as unit, fmu_driver.Instance(archive) as plain:
        rows = np.array(list(whole_reach(unit.initialize(**values))))
        assert not same_bits(rows, np.array(list(whole_reach(plain.initialize()))))
    names = [v.name for v in archive.outputs]
    for name, column in CORE_NAMES.items():
        chosen = [k for k, output in enumerate(names) if output == name or output.startswith(name + "[")]
        assert same_bits(rows[:, chosen].squeeze(), expected[column]), name


def test_the_reference_result_is_reproduced(archive):
    """extra/org.fmi-standard.fmi-ls-ref, to the rounding that another mathematical library may have."""
    path = archive.folder / "extra/org.fmi-standard.fmi-ls-ref/Glenoid_out.csv"
    reference = np.genfromtxt(path, delimiter=",", names=True, deletechars="", replace_space=" ")
    names = [v.name for v in archive.outputs]
    result = fmpy.simulate_fmu(str(archive.path), output=names, output_interval=0.01, fmi_type="CoSimulation")
    for name in names:
        np.testing.assert_allclose(result[name], reference[f"{name}"], rtol=1e-9, atol=1e-9, err_msg=name)
