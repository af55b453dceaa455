"""Checks of numbers and arrays given by users. Each error names the argument, its value and the requirement."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array


def positive(name: str, value: float, unit: str) -> float:
    """Return `value` if it is positive and finite; raise ValueError otherwise."""
    if not (np.isfinite(value) and value > 0):
        raise ValueError(f"{name} must be a positive number in {unit}, got {value!r}")
    return float(value)


def not_negative(name: str, value: float) -> float:
    """Return `value` if it is finite and not negative; raise ValueError otherwise."""
    if not (np.isfinite(value) and value >= 0):
        raise ValueError(f"{name} must be finite and not negative, got {value!r}")
    return float(value)


def vector(name: str, value: npt.ArrayLike) -> Array:
    """Return `value` as an array (3,) of finite numbers; raise ValueError otherwise."""
    v = np.asarray(value, dtype=np.float64)
    if v.shape != (3,) or not np.isfinite(v).all():
        raise ValueError(f"{name} must be three finite numbers, got {np.asarray(value).tolist()}")
    return v


def is_number(text: str | bytes) -> bool:
    """True if `text` reads as a number."""
    try:
        float(text)
    except ValueError:
        return False
    return True


def finite_or_none(x: float) -> float | None:
    """A number for JSON: None replaces infinity and NaN."""
    return float(x) if np.isfinite(x) else None
