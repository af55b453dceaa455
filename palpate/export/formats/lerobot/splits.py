"""The splits of a data set: train, val and test of the good episodes, and failure for the others."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

_T = TypeVar("_T")
VAL, TEST = 0.1, 0.1
"""Shares of the good episodes, rounded; train has the rest."""


def ordered(items: Sequence[_T], failed: Callable[[_T], bool]) -> list[_T]:
    """The items in their order, those that failed last: a split is a range of episodes."""
    return sorted(items, key=failed)


def splits_of(failed: Sequence[bool]) -> dict[str, str]:
    """The ranges of episodes by split, for episodes of which those that failed come last."""
    good = list(failed).index(True) if True in failed else len(failed)
    if not all(failed[good:]):
        raise ValueError("episodes that failed must come last")
    test = round(TEST * good)
    val = round(VAL * good)
    train = good - val - test
    found = {"train": f"0:{train}", "val": f"{train}:{train + val}", "test": f"{train + val}:{good}"}
    return found | ({"failure": f"{good}:{len(failed)}"} if good < len(failed) else {})
