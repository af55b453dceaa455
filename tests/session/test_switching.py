"""How soon threads have the interpreter: sessions that overlap ask and withdraw in any order."""

import itertools
import sys

import pytest

from palpate.base import switching


@pytest.mark.parametrize("order", list(itertools.permutations(range(3))))
def test_the_shortest_wish_holds_and_the_interval_comes_back_in_any_order(order):
    before = sys.getswitchinterval()
    wishes = (before / 10, before / 50, 2 * before)
    withdraw = [switching.ask(one) for one in wishes]
    left = dict(enumerate(wishes))
    for k in order:
        assert sys.getswitchinterval() == pytest.approx(min([before, *left.values()]), rel=1e-3)
        withdraw[k]()
        withdraw[k]()  # once more does nothing
        del left[k]
    assert sys.getswitchinterval() == before
