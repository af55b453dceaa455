"""Least, greatest, mean and standard deviation of columns, for an episode and for all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from palpate.base.arrays import Array
from palpate.export.formats.lerobot.columns import Column


@dataclass(frozen=True)
class Moments:
    """Of the n values of each of k numbers, NaN left out; 0 where there is no other value."""

    min: Array
    max: Array
    mean: Array
    std: Array
    n: Array
    """(k,) number of values that are not NaN."""
    count: int
    """Number of frames."""

    def lists(self) -> dict[str, list[float]]:
        """As LeRobot stores them."""
        found = {name: getattr(self, name).tolist() for name in ("min", "max", "mean", "std")}
        return {**found, "count": [self.count]}


def moments(values: Array) -> Moments:
    """Of (n, k) values."""
    data = np.asarray(values, dtype=np.float64)
    there = np.isfinite(data)
    n = there.sum(axis=0)
    some = np.maximum(n, 1)
    mean = np.where(there, data, 0.0).sum(axis=0) / some
    spread = np.where(there, data - mean, 0.0)
    low = np.where(n > 0, np.where(there, data, np.inf).min(axis=0), 0.0)
    high = np.where(n > 0, np.where(there, data, -np.inf).max(axis=0), 0.0)
    return Moments(low, high, mean, np.sqrt((spread**2).sum(axis=0) / some), n, len(data))


def joined(parts: Sequence[Moments]) -> Moments:
    """Of all values together."""
    n = np.stack([part.n for part in parts])
    some, total = n > 0, np.maximum(n.sum(axis=0), 1)
    mean = np.stack([part.mean for part in parts])
    whole = (n * mean).sum(axis=0) / total
    square = (n * (np.stack([part.std for part in parts]) ** 2 + (mean - whole) ** 2)).sum(axis=0) / total
    low = np.where(some, np.stack([part.min for part in parts]), np.inf).min(axis=0)
    high = np.where(some, np.stack([part.max for part in parts]), -np.inf).max(axis=0)
    any_ = some.any(axis=0)
    return Moments(
        np.where(any_, low, 0.0), np.where(any_, high, 0.0), whole, np.sqrt(square), n.sum(axis=0),
        sum(part.count for part in parts),
    )  # fmt: skip


def of_columns(columns: Mapping[str, Column]) -> dict[str, Moments]:
    """Of every column of numbers."""
    return {name: moments(np.asarray(c.values)) for name, c in columns.items() if not isinstance(c.values, list)}
