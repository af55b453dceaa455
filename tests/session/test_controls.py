"""Controls of a session take values of Python; a wrong value is refused in own words."""

import numpy as np
import pytest

from palpate import _core
from palpate.base.errors import PalpateError
from palpate.session.controls import NAMES, Controls


def test_a_list_is_a_position():
    controls = Controls()
    controls.p_hand_offset_W = [0, 0, 0.01]
    np.testing.assert_array_equal(controls.p_hand_offset_W, [0.0, 0.0, 0.01])


def test_a_copy_has_every_value():
    core = _core.Controls()
    core.clutch, core.stiffness_scale, core.p_hand_offset_W = True, 0.5, np.array([1.0, 2.0, 3.0])
    copy = Controls(core)
    for name in NAMES:
        np.testing.assert_equal(getattr(copy, name), getattr(core, name))  # NaN: none


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("p_hand_offset_W", [0, 0], r"p_hand_offset_W must be three numbers \[m\]"),
        ("p_hand_offset_W", "up", r"three numbers \[m\]\. Got: 'up'"),
        ("clutch", "yes", r"controls\.clutch must be bool\. Got: 'yes'\n  mend: assign e\.g\. False"),
        ("stiffness_scale", None, r"controls\.stiffness_scale must be float"),
        ("cluch", True, "there is no control 'cluch'\n  mend: did you mean 'clutch'"),
    ],
)
def test_wrong_value_is_refused_in_own_words(name, value, message):
    with pytest.raises(PalpateError, match=message):
        setattr(Controls(), name, value)
