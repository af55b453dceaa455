"""Poses and pose covariances: group axioms, finite differences, and Monte Carlo."""

import numpy as np
import pytest

from palpate.base.arrays import rigid, so3


def random_pose(rng: np.random.Generator) -> np.ndarray:
    return rigid.rigid(rigid.exp(rng.normal(size=3)), rng.normal(size=3))


@pytest.mark.parametrize("angle", [0.0, 1e-9, 0.3, 3.1])
def test_exp_is_rodrigues_formula_and_log_undoes_it(angle):
    axis = so3.unit(np.array([1.0, -2.0, 0.5]))
    assert rigid.exp(angle * axis) == pytest.approx(so3.about(axis, angle), abs=1e-14)
    assert rigid.log(so3.about(axis, angle)) == pytest.approx(angle * axis, abs=1e-12)


def test_inverse_and_transform_agree_with_matrices():
    rng = np.random.default_rng(0)
    X, points = random_pose(rng), rng.normal(size=(5, 3))
    assert rigid.inverse(X) == pytest.approx(np.linalg.inv(X), abs=1e-14)
    assert rigid.inverse(np.stack([X, X]))[1] == pytest.approx(np.linalg.inv(X), abs=1e-14)
    homogeneous = np.column_stack([points, np.ones(5)]) @ X.T
    assert rigid.transform(X, points) == pytest.approx(homogeneous[:, :3], abs=1e-14)


def test_displacement_undoes_displaced():
    rng = np.random.default_rng(1)
    X, xi = random_pose(rng), rng.normal(scale=0.3, size=6)
    assert rigid.displacement(X, rigid.displaced(X, xi)) == pytest.approx(xi, abs=1e-12)


def test_displacement_is_translation_first_in_the_parent_frame():
    X = rigid.rigid(so3.about([0, 0, 1], np.pi / 2), [1.0, 2.0, 3.0])
    moved = rigid.displaced(X, [0.1, 0.0, 0.0, 0.0, 0.0, np.pi / 2])
    assert moved[:3, 3] == pytest.approx([1.1, 2.0, 3.0])
    assert moved[:3, :3] == pytest.approx(so3.about([0, 0, 1], np.pi), abs=1e-14)


def test_adjoint_maps_the_twist_of_a_rigid_body():
    """The matrix of a twist, [w]x and v, transforms by conjugation with the pose."""
    rng = np.random.default_rng(2)
    X, V = random_pose(rng), rng.normal(size=6)
    twist = np.zeros((4, 4))
    twist[:3, :3], twist[:3, 3] = so3.cross_matrix(V[3:]), V[:3]
    moved = X @ twist @ np.linalg.inv(X)
    W = rigid.adjoint(X) @ V
    assert moved[:3, 3] == pytest.approx(W[:3])
    assert moved[:3, :3] == pytest.approx(so3.cross_matrix(W[3:]))


def derivative(fn, size=6, step=1e-6):
    """Central differences of a function of xi (6,)."""
    return np.column_stack([(fn(step * e) - fn(-step * e)) / (2 * step) for e in np.eye(size)])


def test_covariances_follow_the_derivatives_of_the_poses():
    rng = np.random.default_rng(3)
    X_AB, X_BC, p_BQ = random_pose(rng), random_pose(rng), rng.normal(size=3)
    A, B = rng.normal(size=(2, 6, 6))
    S, T = A @ A.T, B @ B.T

    J = derivative(lambda xi: rigid.transform(rigid.displaced(X_AB, xi), p_BQ[None])[0])
    assert rigid.point_covariance(X_AB, S, p_BQ) == pytest.approx(J @ S @ J.T, rel=1e-6)

    X_BA = rigid.inverse(X_AB)
    J = derivative(lambda xi: rigid.displacement(X_BA, rigid.inverse(rigid.displaced(X_AB, xi))))
    assert rigid.inverse_covariance(X_AB, S) == pytest.approx(J @ S @ J.T, rel=1e-6, abs=1e-7)

    X_AC = X_AB @ X_BC
    J = derivative(lambda xi: rigid.displacement(X_AC, rigid.displaced(X_AB, xi) @ X_BC))
    K = derivative(lambda xi: rigid.displacement(X_AC, X_AB @ rigid.displaced(X_BC, xi)))
    expected = J @ S @ J.T + K @ T @ K.T
    assert rigid.composed_covariance(X_AB, S, X_BC, T) == pytest.approx(expected, rel=1e-6, abs=1e-7)


@pytest.mark.parametrize(
    ("spoil", "text"),
    [
        (lambda X: X * np.array([1.0, 1.0, -1.0, 1.0]), "left-handed"),
        (lambda X: X @ np.diag([1.1, 1.1, 1.1, 1.0]), "scaled by 1.1"),
        (lambda X: X @ np.diag([1.0, 1.0, 1.002, 1.0]), "R^T R differs from the identity by 0.004"),
        (lambda X: X.T, "last row"),
        (lambda X: X + np.diag([np.nan, 0.0, 0.0, 0.0]), "not finite"),
    ],
)
def test_each_fault_of_a_pose_is_named(spoil, text):
    X = random_pose(np.random.default_rng(2))
    assert rigid.fault(X) is None
    assert text in rigid.fault(spoil(X)).what


def test_rounded_digits_are_within_the_tolerance_that_is_stated():
    X = np.round(random_pose(np.random.default_rng(4)), 3)
    assert rigid.fault(X, 2e-3) is None
    assert "R^T R" in rigid.fault(X, 1e-5).what
