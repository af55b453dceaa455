"""Gravity identification on an arm with known parameters: torques, friction and confidence."""

from functools import cache

import numpy as np
import pytest
import synthetic_arm as synthetic
from threadpoolctl import threadpool_info, threadpool_limits

from palpate import Arm
from palpate.arm.coupling import drives
from palpate.arm.gravity_model import GravityModel
from palpate.arm.identify import fit, forms
from palpate.arm.identify.approach import expected_directions
from palpate.arm.identify.fit_gravity import fit_poses, predicted
from palpate.arm.identify.gravity import gravity
from palpate.arm.identify.identifiability import identifiability, next_poses
from palpate.arm.identify.recordings import read_static

MEASURED = np.arange(7) < 6


@pytest.fixture(scope="module")
def known():
    return Arm.mtm("right"), synthetic.recording(120, 1)


@pytest.fixture(scope="module")
def ours(known):
    arm, poses = known
    return fit_poses(poses, arm, "potential", MEASURED)


@pytest.fixture(scope="module")
def model_of(known, ours):
    """A function that returns the model of the recording in a form."""
    arm, poses = known
    return cache(lambda form: ours.model if form == "potential" else fit_poses(poses, arm, form, MEASURED).model)


def truth(q):
    arm = synthetic.true_arm()
    return np.array([arm.holding(x) for x in q])


def test_holding_torques_are_identified_despite_friction_and_noise(known, ours):
    """A fit of the measured torques as holding torques would leave half of the friction."""
    q = synthetic.poses(300, 7)
    error = np.sqrt(((ours.model.holding(q, known[0]) - truth(q))[:, :6] ** 2).mean(axis=0))
    assert (error < 0.6 * synthetic.NOISE[:6] + 0.0005).all(), error


def test_friction_of_each_motor_is_identified(ours):
    np.testing.assert_allclose(ours.model.friction[:6, 0], synthetic.COULOMB[:6], rtol=0.15, atol=5e-4)


def test_stated_confidence_covers_the_errors(known, ours):
    q = synthetic.poses(400, 8)
    z = (ours.model.holding(q, known[0]) - truth(q))[:, :6] / ours.std(q, known[0])[:, :6]
    assert 0.85 < (np.abs(z) < 1.96).mean() <= 1.0
    np.testing.assert_allclose(ours.noise[:6], synthetic.NOISE[:6], rtol=0.4)


def test_residual_without_noise_and_friction_is_small(known):
    arm, poses = known[0], synthetic.recording(80, 3, noise=0.0, friction=0.0)
    fitted = fit_poses(poses, arm, "potential", MEASURED)
    q = synthetic.poses(200, 9)
    assert np.abs((fitted.model.holding(q, arm) - truth(q))[:, :6]).max() < 0.006
    assert np.abs(fitted.model.friction[:6]).max() < 1e-3


def test_more_poses_raise_the_confidence(known, ours):
    few = fit_poses(synthetic.recording(30, 1), known[0], "potential", MEASURED)
    q = synthetic.poses(50, 10)
    assert (few.std(q, known[0])[:, :6].mean(axis=0) > ours.std(q, known[0])[:, :6].mean(axis=0)).all()


def test_paper_form_is_least_squares_of_pinocchios_columns(known, model_of):
    """Pi = Y^+ T: the predictions equal those of numpy's pseudo-inverse of the regressor."""
    arm, poses = known
    model = model_of("paper")
    Y = np.concatenate([arm.gravity_regressor(q)[:6] for q in poses.q])
    Pi = np.linalg.pinv(Y, rcond=1e-9) @ poses.tau[:, :6].ravel()
    q = synthetic.poses(20, 2)
    np.testing.assert_allclose(model.holding(q, arm)[:, :6], [arm.gravity_regressor(x)[:6] @ Pi for x in q], atol=1e-9)
    assert not model.friction.any()


def test_arm_without_cables_is_identified_exactly_by_every_form():
    """The first moments of the URDF explain all torques of an arm without cables."""
    arm = Arm.mtm("left")
    q = np.random.default_rng(4).uniform(arm.q_min, arm.q_max, (80, 7))
    q[:, 6] = 0.0
    bare = synthetic.Static(q, np.array([arm.gravity(x) for x in q]), np.arange(80) == 0, ("bare",), 80)
    for form in ("paper", "gravity+springs", "dvrk"):
        model = fit_poses(bare, arm, form, MEASURED).model
        np.testing.assert_allclose(model.holding(q, arm)[:, :6], bare.tau[:, :6], atol=1e-7, err_msg=form)


def test_expected_direction_is_that_of_random_visits():
    """Against a simulation: x is approached from below as often as other poses are below x."""
    x = np.random.default_rng(0).uniform(-1, 1, (20000, 1))
    came = np.sign(np.diff(x[:, 0]))
    expected = expected_directions(x[1:], x)[:, 0]
    for low in np.linspace(-1, 0.8, 10):
        inside = (x[1:, 0] > low) & (x[1:, 0] < low + 0.2)
        assert abs(came[inside].mean() - expected[inside].mean()) < 0.06


def test_error_floor_is_the_friction_scatter(known, ours):
    """Without noise the error of a prediction is the friction minus its expectation."""
    from palpate.arm.identify import scores

    arm, poses = known[0], synthetic.recording(400, 5, noise=0.0)
    judged = scores.score(ours, poses, tuple(range(6)), arm)
    np.testing.assert_allclose(judged.rms, judged.floor, rtol=0.2, atol=1e-3)
    assert (judged.rms_directed < 0.6 * judged.rms).all()


def test_outliers_are_found_and_excluded(known):
    arm, poses = known[0], synthetic.recording(120, 1)
    poses.tau[17, 1] += 0.4
    poses.tau[60, 4] = 30.0
    fitted = fit_poses(poses, arm, "potential", MEASURED)
    assert {(o.pose, o.joint) for o in fitted.outliers} == {(17, 1), (60, 4)}
    assert "more than three times what the drive can" in fitted.outliers[0].why
    q = synthetic.poses(100, 7)
    assert np.abs(fitted.model.holding(q, arm) - truth(q))[:, 1].max() < 0.04


def test_joint_stop_is_explained_but_not_compensated(known):
    arm, poses = known[0], synthetic.recording(200, 1)
    deep = np.maximum(-1.2 - poses.q[:, 3], 0.0)
    into = 30.0 * np.minimum(deep, 0.02)
    near = deep > 0
    poses.q[near, 3] = -1.2 - np.minimum(deep[near], 0.02)
    poses.tau[:, 3] -= into
    poses.tau[:, 2] -= 0.6697 * into
    fitted = fit_poses(poses, arm, "potential", MEASURED)
    assert [(s.joint, s.side) for s in fitted.model.stops] == [(3, -1)]
    at_stop = poses.q[near]
    assert np.abs(fitted.model.holding(at_stop, arm) - truth(at_stop))[:, 2:4].max() < 0.08
    explained = predicted(fitted.model, poses, arm)[near]
    assert np.abs(explained - poses.tau[near])[:, 3].mean() < 0.5 * into[near].mean()


def test_poses_reached_both_ways_are_averaged(tmp_path):
    up, down = synthetic.recording(100, 1), synthetic.recording(100, 1)
    drift = 2 * synthetic.COULOMB * np.array([1.0] * 6 + [0.0])
    back = synthetic.Static(down.q[::-1].copy(), (down.tau - drift)[::-1].copy(), down.start, down.files, 100)
    synthetic.write(tmp_path / "up.csv", up)
    synthetic.write(tmp_path / "down.csv", back)
    found = gravity([tmp_path / "up.csv", tmp_path / "down.csv"], "mtmr", model="gravity+springs")
    assert found.pairs is not None
    assert len(found.poses) == 100
    np.testing.assert_allclose(found.pairs.figures(found.joints).half_difference_Nm, synthetic.COULOMB[:6], rtol=1e-6)


@pytest.mark.parametrize("form", ["potential", "dvrk"])
def test_advised_poses_beat_random_ones(form, known):
    """Six more poses, advised or random within the same limits: the advised ones give smaller standard deviations."""
    arm = known[0]
    fitted = fit_poses(synthetic.recording(30, 1), arm, form, MEASURED)
    advised = next_poses(fitted, MEASURED, arm)
    gains = [gain for _, gain in advised]
    assert gains == sorted(gains, reverse=True)
    q = np.array([pose for pose, _ in advised])
    assert ((q >= arm.q_min) & (q <= arm.q_max)).all()
    informed = [information(fitted, some, arm) for some in (q, *(synthetic.poses(6, seed) for seed in range(50)))]
    assert informed[0] == pytest.approx(sum(gains), rel=1e-4)
    assert informed[0] > max(informed[1:])
    unseen = synthetic.poses(100, 3)
    sure = [
        mean_deviation(fitted, some, unseen, arm) for some in (q, *(synthetic.poses(6, seed) for seed in range(50)))
    ]
    assert sure[0] < np.median(sure[1:])


def information(fitted, q, arm):
    """Information gain of torques at q from the determinant of their predicted covariance [nat]."""
    C = (fitted.columns(q, np.zeros_like(q), arm)[:, MEASURED] / fitted.noise[MEASURED][:, None]).reshape(
        6 * len(q), -1
    )
    return 0.5 * np.linalg.slogdet(np.eye(len(C)) + C @ fitted.solution.covariance @ C.T)[1]


def mean_deviation(fitted, q, unseen, arm):
    """Mean standard deviation of the holding torques at `unseen` over that of the noise, with measurements at q."""
    scale = fitted.noise[MEASURED][:, None]
    C = (fitted.columns(q, np.zeros_like(q), arm)[:, MEASURED] / scale).reshape(6 * len(q), -1)
    S = fitted.solution.covariance
    S = S - S @ C.T @ np.linalg.solve(np.eye(len(C)) + C @ S @ C.T, C @ S)
    U = fitted.columns(unseen, np.zeros_like(unseen), arm)[:, MEASURED] / scale
    return np.sqrt(np.einsum("kip,pr,kir->ki", U, S, U, optimize=True)).mean()


def test_fit_uses_one_core():
    """Competing BLAS threads took twenty times longer."""

    @fit.on_one_core
    def threads():
        return {pool["num_threads"] for pool in threadpool_info()}

    np.linalg.inv(np.eye(3))
    with threadpool_limits(2):
        assert {pool["num_threads"] for pool in threadpool_info()} == {2}, "control"
        assert threads() == {1}


@pytest.mark.parametrize("moving", [[1], [1, 2], [3, 4, 5]])
def test_unidentifiable_parameters_are_named(moving):
    arm, poses = Arm.mtm("right"), synthetic.recording(60, 1)
    still = [j for j in range(6) if j not in moving]
    q = poses.q.copy()
    q[:, still] = q[0, still]
    result = identifiability(q, MEASURED, arm)
    assert result.structural_rank == 10
    assert result.rank < 10
    assert result.weak
    rich = identifiability(poses.q, MEASURED, arm)
    assert (rich.rank, rich.weak) == (10, ())
    assert rich.condition < 50
    assert "outer_yaw.m" in rich.never


def test_base_parameters_predict_what_all_parameters_do():
    """Reference: the numerical rank of the regressor of many poses."""
    arm = Arm.mtm("right")
    q = np.random.default_rng(3).uniform(arm.q_min, arm.q_max, (300, 7))
    Y = np.concatenate([arm.gravity_regressor(x) for x in q])
    result = identifiability(q, np.ones(7, dtype=bool), arm)
    assert result.structural_rank == np.linalg.matrix_rank(Y, tol=1e-8) == len(result.base)


@pytest.mark.parametrize("form", forms.FORMS)
def test_model_file_round_trip(form, known, model_of, tmp_path):
    arm, model = known[0], model_of(form)
    model.save(tmp_path / "m.yaml")
    again = GravityModel.load(tmp_path / "m.yaml")
    q = synthetic.poses(30, 4)
    direction = np.sign(np.random.default_rng(0).standard_normal(q.shape))
    np.testing.assert_array_equal(again.holding(q, arm), model.holding(q, arm))
    np.testing.assert_array_equal(again.measured(q, arm, direction), model.measured(q, arm, direction))
    held = again.apply(Arm.mtm("right"))
    np.testing.assert_allclose([held.holding(x) for x in q], model.holding(q, arm), atol=1e-12)


def test_same_file_gives_the_same_model(tmp_path):
    synthetic.write(tmp_path / "a.csv", synthetic.recording(20, 2))
    one, two = (gravity(tmp_path / "a.csv", "mtmr").model for _ in range(2))
    np.testing.assert_array_equal(one.theta, two.theta)
    assert len(read_static(tmp_path / "a.csv", Arm.mtm("right"))) == 20
    assert drives(one.visited, Arm.mtm("right")).shape == (20, 7)


@pytest.mark.parametrize("form", forms.FORMS)
def test_joint_without_measurements_gets_no_compensation(form, known, model_of):
    """The torque of the last joint is unknown, so moments shared with the previous link are assigned to that one."""
    arm, model = known[0], model_of(form)
    q = synthetic.poses(50, 4)
    q[:, 6] = np.linspace(-3, 3, 50)
    assert np.abs(model.holding(q, arm)[:, 6]).max() < 1e-9
