"""The gate refuses every wrong pose, keeps the last good one, and says why."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from palpate.sensing.trackers import Gate, Limits, Sighting

START = np.eye(4)
START[:3, 3] = [0.1, -0.2, 1.5]


def at(dx: float = 0.0, turn_deg: float = 0.0) -> np.ndarray:
    X = START.copy()
    X[0, 3] += dx
    X[:3, :3] = Rotation.from_euler("z", turn_deg, degrees=True).as_matrix()
    return X


def gate() -> Gate:
    made = Gate("patient", START, Limits())
    assert made.take(Sighting("patient", at(), 10.0, 2e-4), 0.0)
    return made


MIRRORED, SCALED, METRES = at(), at(), at()
MIRRORED[:3, 0] *= -1
SCALED[:3, :3] *= 1.1
METRES[:3, 3] *= 1e-3
WRONG = {
    "invalid": (Sighting("patient", at(), 10.02, valid=False), "marks the pose as invalid"),
    "residual": (Sighting("patient", at(), 10.02, 3e-3), "fit within 3.00 mm only"),
    "mirrored": (Sighting("patient", MIRRORED, 10.02), "left-handed"),
    "scaled": (Sighting("patient", SCALED, 10.02), "scaled by 1.1"),
    "not a number": (Sighting("patient", np.full((4, 4), math.nan), 10.02), "not finite"),
    "shape": (Sighting("patient", np.eye(3), 10.02), "4 x 4"),
    "millimetres": (Sighting("patient", np.diag([1, 1, 1, 1.0]) + 1e3 * (at() - np.eye(4)), 10.02), "millimetres"),
    "backwards": (Sighting("patient", at(), 9.0), "backwards by 1.000 s"),
    "stamp": (Sighting("patient", at(), math.nan), "backwards"),
    "jump": (Sighting("patient", at(0.05), 10.02), "jumped by 50.0 mm"),
    "turn": (Sighting("patient", at(0.0, 60.0), 10.02), "turned by 60.0 deg"),
}


@pytest.mark.parametrize("wrong", WRONG)
def test_a_wrong_pose_is_refused_and_the_last_good_one_is_kept(wrong):
    seen, why = WRONG[wrong]
    one = gate()
    for k in range(50):
        now = 0.02 + 0.02 * k
        repeated = Sighting(seen.tool, seen.X, seen.t + (0.02 * k if seen.t > 10.0 else 0.0), seen.error, seen.valid)
        assert not one.take(repeated, now)
        assert pytest.approx(START) == one.X
        assert why in one.status(now)
    assert one.refused == 50
    assert one.is_lost(1.0)
    assert one.status(1.0).startswith("lost for 1.0 s: ")
    assert one.take(Sighting("patient", at(0.001), 11.5), 1.5)  # the tool returns
    assert one.status(1.5) == "tracked"


def test_a_repeated_pose_ages():
    one = gate()
    for k in range(30):
        assert not one.take(Sighting("patient", at(), 10.0), 0.02 * k)
    assert one.is_lost(0.6)
    assert one.refused == 0
    assert one.status(0.6) == "lost for 0.6 s: no pose arrives"


def test_motion_within_the_limits_is_followed():
    one = gate()
    for k in range(1, 200):
        assert one.take(Sighting("patient", at(0.2 / 60 * k, 150.0 / 60 * k), 10.0 + k / 60), k / 60), one.status(
            k / 60
        )
    assert one.X[0, 3] == pytest.approx(0.1 + 0.2 / 60 * 199)


def test_a_jump_is_followed_only_when_accepted():
    one = gate()
    for k in range(600):
        assert not one.take(Sighting("patient", at(0.12), 10.0 + 0.02 * (k + 1)), 0.02 * (k + 1))
    one.accept_jump()
    assert one.take(Sighting("patient", at(0.12), 30.0), 20.0)
    assert not one.take(Sighting("patient", at(0.0), 30.02), 20.02)


def test_a_tool_that_was_never_seen_says_so():
    one = Gate("patient", START)
    assert one.is_lost(0.0)
    assert one.status(0.0) == "not seen yet"
    assert not one.take(Sighting("patient", METRES, 1.0), 0.0)
    assert "sent in metres" in one.status(0.0)
    assert one.take(Sighting("patient", at(0.3), 1.0), 0.0)
