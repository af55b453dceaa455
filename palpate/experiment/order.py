"""Order of the conditions of each participant."""

from __future__ import annotations

import numpy as np


def williams(n: int) -> list[list[int]]:
    """Latin square of n conditions in which each follows each other one equally often (Williams 1949).

    Returns:
        n rows for an even n; 2 n rows for an odd one, whose second half mirrors the first.
    """
    first = [0]
    for k in range(1, n):
        first.append((k + 1) // 2 if k % 2 else n - k // 2)
    rows = [[(c + shift) % n for c in first] for shift in range(n)]
    return rows if n % 2 == 0 else rows + [row[::-1] for row in rows]


def orders(conditions: tuple[str, ...], participants: int, latin_square: bool, seed: int) -> list[tuple[str, ...]]:
    """Order of the conditions for each participant; it does not depend on the number of participants.

    Args:
        conditions: names.
        participants: number of participants.
        latin_square: rows of a Williams square, whose letters are assigned by the seed; otherwise each order is drawn.
        seed: of the experiment.
    """
    n = len(conditions)
    if not latin_square:
        return [
            tuple(conditions[k] for k in np.random.default_rng([seed, 1, i]).permutation(n))
            for i in range(participants)
        ]
    letters = np.random.default_rng([seed, 1]).permutation(n)
    square = williams(n)
    return [tuple(conditions[letters[k]] for k in square[i % len(square)]) for i in range(participants)]
