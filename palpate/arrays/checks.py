"""Checks of the numbers and arrays that users give: each error names the argument, its value and what it must be."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from palpate.arrays import Array


def positive(name: str, value: float, unit: str) -> float:
    """A positive, finite number, or a ValueError."""
    if not (np.isfinite(value) and value > 0):
        raise ValueError(f"{name} must be a positive number in {unit}, got {value!r}")
    return float(value)


def not_negative(name: str, value: float) -> float:
    """A finite number that is not negative, or a ValueError."""
    if not (np.isfinite(value) and value >= 0):
        raise ValueError(f"{name} must be finite and not negative, got {value!r}")
    return float(value)


def vector(name: str, value: npt.ArrayLike) -> Array:
    """Three finite numbers (3,), or a ValueError."""
    v = np.asarray(value, dtype=np.float64)
    if v.shape != (3,) or not np.isfinite(v).all():
        raise ValueError(f"{name} must be three finite numbers, got {np.asarray(value).tolist()}")
    return v


def finite_or_none(x: float) -> float | None:
    """A number as JSON has it: None for infinity and NaN."""
    return float(x) if np.isfinite(x) else None
