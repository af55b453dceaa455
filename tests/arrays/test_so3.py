"""Rotations and quaternions; the second algorithm is scipy's."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from palpate.base.arrays import so3


@pytest.fixture
def rotations():
    """Random rotations, all half turns about the axes and their diagonals, and rotations close to these."""
    axes = np.array([a for a in np.ndindex(3, 3, 3) if any(a)], float) - np.array([0.0, 1.0, 1.0])
    turns = axes[np.linalg.norm(axes, axis=1) > 0]
    turns *= np.pi / np.linalg.norm(turns, axis=1, keepdims=True)
    rng = np.random.default_rng(1)
    near = turns + 1e-8 * rng.normal(size=turns.shape)
    return Rotation.concatenate(
        [Rotation.random(500, rng=rng), Rotation.from_rotvec(np.vstack([turns, near, 0 * turns]))]
    )


def test_quaternions_agree_with_scipy_up_to_their_sign(rotations):
    ours = so3.quaternions(rotations.as_matrix())
    theirs = np.roll(rotations.as_quat(), 1, axis=1)
    assert np.abs(np.linalg.norm(ours, axis=1) - 1).max() < 1e-15
    assert np.minimum(np.abs(ours - theirs).max(axis=1), np.abs(ours + theirs).max(axis=1)).max() < 1e-14
    assert (so3.quaternions(rotations.as_matrix(), canonical=True)[:, 0] >= 0).all()


def test_one_quaternion_in_plain_numbers_is_the_canonical_one(rotations):
    theirs = np.roll(rotations.as_quat(), 1, axis=1)
    ours = np.array([so3.quaternion(R) for R in rotations.as_matrix()])
    assert (ours[:, 0] >= 0).all()
    assert np.minimum(np.abs(ours - theirs).max(axis=1), np.abs(ours + theirs).max(axis=1)).max() < 1e-14


def test_matrices_invert_quaternions_of_any_norm(rotations):
    R = rotations.as_matrix()
    np.testing.assert_allclose(so3.matrices(-3.0 * so3.quaternions(R)), R, atol=1e-14)


def test_any_number_of_leading_axes_and_a_zero_quaternion():
    R = Rotation.from_rotvec([0.1, -0.2, 0.3]).as_matrix()
    assert so3.quaternions(R).shape == (4,)
    assert so3.quaternions(np.tile(R, (2, 5, 1, 1))).shape == (2, 5, 4)
    np.testing.assert_array_equal(so3.matrices([0.0, 0.0, 0.0, 0.0]), np.eye(3))
    assert so3.matrices(np.zeros((2, 5, 4))).shape == (2, 5, 3, 3)
