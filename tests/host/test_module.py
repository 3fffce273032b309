"""Laws of the Python module over the core: nothing is lost on the way through NumPy."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from glenoid import _core
from glenoid.inputs import ReachInput
from glenoid.settings import make_generator
from hypothesis import assume, given
from hypothesis import strategies as st

EPS = np.finfo(float).eps
POSTURES = st.tuples(st.floats(0.05, 2.6), st.floats(-2.2, 0.7), st.floats(-1.5, 1.5), st.floats(0.1, 2.4)).map(
    np.array
)


def make_arm(moving=True, gain=1.0):
    scaled = _core.scale_subject(_core.Subject())
    settings = _core.RhythmSettings()
    settings.gain = gain
    rhythm = _core.Rhythm(settings, scaled.shoulder_distance_m)
    return _core.make_arm_model(scaled, rhythm, _core.JointLimits(), moving)


ARM = make_arm()
START = _core.posture_from_angles(np.array([0.3, -0.5, 0.5, 1.0]))
END = _core.posture_from_angles(np.array([1.5, 0.1, 0.1, 0.6]))


def plan_between(start=START, end=END):
    status, plan = _core.ReachPlanner().plan_between(ARM, start, end)
    assert status == _core.Status.Ok
    return plan


@given(POSTURES)
def test_angles_survive_the_rotation(q):
    posture = _core.posture_from_angles(q)
    # eta and zeta are recovered with an error of eps / sin(theta).
    assert np.allclose(_core.angles_from_posture(posture, q), q, rtol=0, atol=8 * EPS / np.sin(q[0]))
    assert np.allclose(posture.R_TU @ posture.R_TU.T, np.eye(3), rtol=0, atol=8 * EPS)


@given(POSTURES)
def test_inverse_kinematics_finds_the_posture_again(q):
    posture = _core.posture_from_angles(q)
    points = _core.forward_kinematics(ARM, posture)
    n = (points.wrist_m - points.shoulder_m) / np.linalg.norm(points.wrist_m - points.shoulder_m)
    assume(np.hypot(n[0], n[1]) > 0.05)
    found = _core.inverse_kinematics(ARM, points.wrist_m, _core.swivel_angle(points))
    nearest = min(np.abs(p.R_TU - posture.R_TU).max() + abs(p.phi_rad - posture.phi_rad) for p in found)
    assert nearest <= 1e-8


@given(POSTURES)
def test_mass_matrix_is_symmetric_positive_definite(q):
    M = _core.mass_matrix(ARM, q)
    assert np.array_equal(M, M.T)
    assert np.linalg.eigvalsh(M).min() > 0


def test_no_inverse_is_an_empty_list():
    assert _core.inverse_kinematics(ARM, np.array([3.0, 0.0, 0.0]), 0.2) == []


def test_energy_is_constant_along_a_path():
    path = plan_between().path
    q, dq, _ = path.angles(np.linspace(0, 1, 51), np.array([0.3, -0.5, 0.5, 1.0]))
    energies = np.array([0.5 * v @ _core.mass_matrix(ARM, x) @ v for x, v in zip(q, dq, strict=True)])
    assert np.ptp(energies) <= 1e-6 * energies.mean()
    assert energies.mean() == pytest.approx(path.energy_kg_m2, rel=1e-7)


def test_rates_are_the_derivative_of_the_angles():
    path = plan_between().path
    h = EPS ** (1 / 3)
    near = np.array([0.3, -0.5, 0.5, 1.0])
    (below, _, _), (q, dq, ddq), (above, _, _) = (path.angles(np.array([0.5 + k * h]), near) for k in (-1, 0, 1))
    # Central differences: h^2 |q'''| / 6 + eps |q| / h with |q'''| below 100 here.
    assert np.allclose((above - below) / (2 * h), dq, rtol=0, atol=20 * h * h + 4 * EPS / h)
    assert np.allclose((above - 2 * q + below) / h**2, ddq, rtol=0, atol=100 * h + 16 * EPS / h**2)


def test_many_lambdas_are_one_lambda_many_times():
    path = plan_between().path
    lambdas = np.linspace(0, 1, 7)
    together = path.points(ARM, lambdas)
    for k, value in enumerate(lambdas):
        for rows, row in zip(together, path.points(ARM, np.array([value])), strict=True):
            assert np.array_equal(rows[k], row[0])
    R, phi = path.rotations(lambdas)
    assert R.shape == (7, 3, 3)
    assert np.array_equal(R[3], path.posture(lambdas[3]).R_TU)
    assert phi[3] == path.posture(lambdas[3]).phi_rad


def test_reversal_gives_the_reversed_path():
    lambdas = np.linspace(0, 1, 11)
    forth, back = plan_between().path.points(ARM, lambdas), plan_between(END, START).path.points(ARM, 1 - lambdas)
    for rows, reverse in zip(forth, back, strict=True):
        assert np.allclose(rows, reverse, rtol=0, atol=1e-8)


def test_following_the_start_rates_arrives():
    status, path = _core.refine_path(ARM, plan_between().path, 1e-12)
    assert status == _core.Status.Ok
    status, shot = _core.follow_geodesic(ARM, path.posture(0.0), path.start_rates())
    assert status == _core.Status.Ok
    assert np.allclose(shot.postures[-1].R_TU, path.posture(1.0).R_TU, rtol=0, atol=1e-7)
    assert shot.energy_drift <= 1e-8


def test_threads_plan_the_same_as_one():
    target = np.array([0.2, 0.42, 0.25])

    def energy(_):
        status, plan = _core.ReachPlanner().plan_minimum_energy(ARM, START, target)
        return status, plan.path.energy_kg_m2

    with ThreadPoolExecutor(4) as pool:
        results = set(pool.map(energy, range(32)))
    assert len(results) == 1


def test_statuses_tell_why_there_is_no_plan():
    planner = _core.ReachPlanner()
    assert planner.plan_minimum_energy(ARM, START, np.array([2.0, 2.0, 2.0]))[0] == _core.Status.TargetUnreachable
    assert planner.plan_minimum_energy(ARM, START, np.full(3, np.nan))[0] == _core.Status.NotFinite


def test_family_reaches_the_target():
    target = np.array([0.2, 0.42, 0.25])
    status, family = _core.ReachPlanner().sample_family(ARM, START, target, 60)
    assert status == _core.Status.Ok
    assert np.all(np.diff(family["swivel_rad"]) >= 0)
    for R, phi in zip(family["R_TU"], family["phi_rad"], strict=True):
        posture = _core.Posture()
        posture.R_TU, posture.phi_rad = R, phi
        assert np.allclose(_core.forward_kinematics(ARM, posture).wrist_m, target, rtol=0, atol=1e-9)


@pytest.mark.parametrize("count", [1, 513])
def test_family_of_an_impossible_size_is_refused(count):
    with pytest.raises(ValueError, match=f"count = {count}"):
        _core.ReachPlanner().sample_family(ARM, START, np.array([0.2, 0.42, 0.25]), count)


@pytest.mark.parametrize("wrong", [np.zeros(3), np.zeros((2, 4)), "abc"])
def test_arrays_of_the_wrong_shape_are_refused(wrong):
    with pytest.raises(TypeError):
        _core.posture_from_angles(wrong)


@pytest.mark.parametrize(
    ("field", "value", "words"),
    [("stature_m", 0.0, "stature.*0 m"), ("mass_kg", -1.0, "mass.*-1 kg"), ("forearm_length_m", 0.0, "forearm.*0 m")],
)
def test_errors_name_variable_value_and_unit(field, value, words):
    subject = _core.Subject()
    setattr(subject, field, value)
    with pytest.raises(ValueError, match=words):
        _core.scale_subject(subject)


def test_replanning_does_not_jump():
    generator = make_generator(ReachInput())
    generator.command(0.0, np.array([0.2, 0.42, 0.25]))
    before = generator.sample(np.array([0.6]))
    generator.command(0.6, np.array([0.1, 0.45, 0.1]))
    after = generator.sample(np.array([0.6]))
    for name in ("q_rad", "dq_rad_per_s", "ddq_rad_per_s2"):
        scale = 1.0 + np.abs(before[name]).max()
        assert np.allclose(before[name], after[name], rtol=0, atol=1e-9 * scale), name


def test_generator_refuses_what_is_not_finite():
    generator = make_generator(ReachInput())
    with pytest.raises(ValueError, match="finite"):
        generator.command(0.0, np.array([np.nan, 0, 0]))
    with pytest.raises(ValueError, match=r"time_s\[1\]"):
        generator.sample(np.array([0.0, np.inf]))
    with pytest.raises(ValueError, match="duration_s = 0"):
        generator.set_duration(0.0)
