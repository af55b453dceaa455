"""The soak of palpate.Haptics: a short one finds nothing, and its judge finds each kind of wrong wrench."""

import numpy as np
import pytest

from palpate_lab.verify.soak import device


def test_short_soak_presses_and_finds_nothing():
    done = device.run(3.0, seed=1)
    assert done.steps > 15_000
    assert done.wrong > 5
    assert done.pressed > 0.05 * done.steps
    assert done.bad == 0, done


@pytest.mark.parametrize(
    ("wrench", "before", "valid", "found"),
    [
        ([0, 0, 1, 0, 0, 0], 1.0, True, (False, False, False, False)),
        ([0, 0, np.nan, 0, 0, 0], 0.0, True, (True, False, False, False)),
        ([0, 0, 3.01, 0, 0, 0], 3.0, True, (False, True, False, False)),
        ([0, 0, 1.06, 0, 0, 0], 1.0, True, (False, False, True, False)),
        ([0, 0, 0, 0, 0.01, 0], 0.0, False, (False, False, False, True)),
    ],
)
def test_the_judge_finds_each_kind_of_wrong_wrench(wrench, before, valid, found):
    assert device.judge(np.array(wrench, float), before, valid, 1e-3, 3.0, 50.0)[:4] == found
