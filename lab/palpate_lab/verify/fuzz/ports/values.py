"""Numbers, texts and arrays as senders with faults or bad intentions send them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from palpate.base.arrays import Array

NUMBERS = (0.0, -0.0, 1.0, -1.0, 1e-9, 1e3, -1e9, 1e308, -1e308, 5e-324, np.nan, np.inf, -np.inf)
TEXTS = (
    *("", "enable", "disable", "home", "unhome", "pause", "resume", "align_MTM", "MTMR_PSM1", "LARGE_NEEDLE_DRIVER"),
    *("x" * 5000, "ä☃", "../../etc/passwd", "<img src=x onerror=alert(1)>", "\0", "%s%n", "-1", "nan"),
)


def pick(rng: np.random.Generator, choices: Sequence[Any]) -> Any:
    """One of the choices; ``rng.choice`` takes ten times as long."""
    return choices[int(rng.integers(len(choices)))]


def number(rng: np.random.Generator) -> float:
    """A number: half of them usual ones."""
    return float(rng.uniform(-1.0, 1.0)) if rng.random() < 0.5 else float(pick(rng, NUMBERS))


def array(rng: np.random.Generator, n: int) -> Array:
    """An array (n,), of which about one number in four is odd."""
    values = rng.uniform(-1.0, 1.0, n)
    for _ in range((n + 3) // 4):
        values[rng.integers(n)] = pick(rng, NUMBERS)
    return values


def text(rng: np.random.Generator) -> str:
    """A text."""
    return str(pick(rng, TEXTS))


def matrix(rng: np.random.Generator) -> Array:
    """A pose (4, 4), of which half are no pose."""
    X = np.eye(4)
    kind = rng.integers(6)
    if kind == 0:
        X[:3, :3] = array(rng, 9).reshape(3, 3)
    elif kind == 1:
        X[:3, :3] = np.diag(np.full(3, number(rng)))
    elif kind == 2:
        X[0, 0] = -1.0
    X[:3, 3] = 0.1 * array(rng, 3) if rng.random() < 0.5 else rng.uniform(-0.2, 0.2, 3)
    return X
