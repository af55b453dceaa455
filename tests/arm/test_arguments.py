"""Accepted and rejected types of an arm's joint arguments."""

import numpy as np
import pytest

import palpate


def test_lists_tuples_and_integers_are_accepted_as_joint_vectors():
    arm = palpate.Arm.psm("lnd")
    q = [0.3, -0.2, 0.15, 0.5, 0.4, -0.3]
    for same in (q, tuple(q), np.array(q), np.array(q)[::-1][::-1]):
        np.testing.assert_array_equal(arm.fk(same), arm.fk(np.array(q)))
    np.testing.assert_array_equal(arm.gravity([0] * 6), arm.gravity(np.zeros(6)))


def test_wrong_shapes_and_types_are_rejected():
    arm = palpate.Arm.psm("lnd")
    with pytest.raises(ValueError, match=r"q must have shape \(6,\), one per joint; got shape \(5,\)"):
        arm.fk([0.0] * 5)
    for wrong in ("six", None, [[0.0] * 6]):
        with pytest.raises(TypeError, match="fk"):
            arm.fk(wrong)
