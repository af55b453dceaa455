"""The endoscope arm against its own Denavit-Hartenberg table: remote centre, inverse kinematics, tilt."""

import numpy as np
import pytest

from palpate.arm.ecm import TILTS, Ecm
from palpate.base.errors import ArmError

TABLE = [(90, 0.0, 90), (-90, 0.0, -90), (90, -0.3822, 0), (0, 0.3829, 0)]  # alpha [deg], d [m], offset [deg]


def by_table(q):
    """Pose of the tip by the modified convention, Rx(alpha) Tz(d) Rz(theta), with plain matrices."""
    X = np.eye(4)
    for k, (alpha, d, offset) in enumerate(TABLE):
        theta = np.radians(offset) + (0.0 if k == 2 else q[k])
        z = d + (q[k] if k == 2 else 0.0)
        ca, sa, ct, st = np.cos(np.radians(alpha)), np.sin(np.radians(alpha)), np.cos(theta), np.sin(theta)
        X = X @ np.array(
            [[ct, -st, 0, 0], [st * ca, ct * ca, -sa, -z * sa], [st * sa, ct * sa, ca, z * ca], [0, 0, 0, 1]]
        )
    return X @ np.array([[0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]])


@pytest.fixture(scope="module")
def joints():
    arm = Ecm().arm
    return np.random.default_rng(2).uniform(arm.q_min, arm.q_max, (300, 4))


def test_poses_are_those_of_the_table(joints):
    arm = Ecm().arm
    assert max(np.abs(arm.fk(q) - by_table(q)).max() for q in joints) < 1e-12


def test_the_endoscope_goes_through_the_remote_centre(joints):
    """Distance of the base's origin from the endoscope's axis."""
    far = []
    for q in joints:
        X = Ecm().arm.fk(q)
        far.append(np.linalg.norm(np.cross(X[:3, 3], X[:3, 2])))
    assert max(far) < 1e-6
    X[:3, 3] += 2e-6 * X[:3, 0]
    assert np.linalg.norm(np.cross(X[:3, 3], X[:3, 2])) > 1e-6, "a bent endoscope is noticed"


@pytest.mark.parametrize("tilt", TILTS)
def test_inverse_kinematics_round_trip(joints, tilt):
    ecm = Ecm(tilt)
    for q in joints:
        X = ecm.camera(q)
        again = ecm.inverse(X)
        assert np.linalg.norm(ecm.camera(again)[:3, 3] - X[:3, 3]) < 1e-6
        assert np.abs(again - q).max() < 1e-6


def test_a_tilted_endoscope_looks_up_in_its_picture():
    straight, up = Ecm().camera([0, 0, 0.1, 0]), Ecm(30.0).camera([0, 0, 0.1, 0])
    view = straight[:3, :3].T @ up[:3, 2]  # in the axes of the straight camera: x right, y down
    np.testing.assert_allclose(view, [0, -0.5, np.sqrt(0.75)], atol=1e-12)


def test_poses_out_of_reach_are_refused_in_words():
    ecm = Ecm()
    too_far, aside = ecm.camera([0, 0, 0.2, 0]), ecm.camera([0.2, 0.1, 0.1, 0])
    too_far[:3, 3] *= 2.0
    aside[:3, :3] = ecm.camera([0, 0, 0.1, 0])[:3, :3]
    for X, number in ((too_far, r"14\d\.\d\d mm"), (aside, r"12\.\d\d degrees")):
        with pytest.raises(ArmError, match=number):
            ecm.inverse(X)


def test_turning_agrees_with_differences(joints):
    ecm, h = Ecm(30.0), 1e-6
    for q in joints[:40]:
        columns = []
        for k in (0, 1, 3):
            step = np.zeros(4)
            step[k] = h
            S = ecm.camera(q)[:3, :3].T @ (ecm.camera(q + step)[:3, :3] - ecm.camera(q - step)[:3, :3]) / (2 * h)
            columns.append([S[2, 1], S[0, 2], S[1, 0]])
        np.testing.assert_allclose(ecm.turning(q), np.transpose(columns), atol=1e-8)
