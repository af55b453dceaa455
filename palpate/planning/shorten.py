"""Shorter and smoother paths: shortcuts, then rounded corners. Each replacement is proved free before it is used."""

from __future__ import annotations

import time
from itertools import pairwise

import numpy as np

from palpate.base.arrays import Array
from palpate.planning.checker import Checker
from palpate.planning.curves import Curve, corner, line

_ATTEMPTS = 16  # random shortcuts
_PATIENCE = 5  # attempts in a row without a gain, after which shortcuts end
_ROUNDINGS = 3  # sizes tried for each corner, each half of the one before
_LARGEST = 0.04  # longest part of a leg that a corner uses, as motion of the tip [m]


def shortened(checker: Checker, waypoints: Array, scale: Array, clearance: float, seed: int, deadline: float) -> Array:
    """Fewer way points (k, n): needless ones removed, then random shortcuts (Geraerts and Overmars 2007).

    scale (n,): motion of the tip per motion of a joint, in which lengths are measured.
    """
    path = [np.array(q) for q in waypoints]
    rng = np.random.default_rng(seed)
    _remove_needless(checker, path, clearance, deadline)
    without_gain = 0
    for _ in range(_ATTEMPTS):
        if len(path) < 3 or without_gain >= _PATIENCE or time.monotonic() > deadline:
            break
        along = np.r_[0.0, np.cumsum([np.linalg.norm(scale * (b - a)) for a, b in pairwise(path)])]
        one, two = np.sort(rng.uniform(0.0, along[-1], 2))
        i, j = (int(np.clip(np.searchsorted(along, x, "right") - 1, 0, len(path) - 2)) for x in (one, two))
        without_gain += 1
        if i == j:
            continue
        a = path[i] + (one - along[i]) / (along[i + 1] - along[i]) * (path[i + 1] - path[i])
        b = path[j] + (two - along[j]) / (along[j + 1] - along[j]) * (path[j + 1] - path[j])
        if np.linalg.norm(scale * (b - a)) > 0.98 * (two - one) or not checker.free_line(a, b, clearance):
            continue
        path[i + 1 : j + 1] = [a, b]
        without_gain = 0
    _remove_needless(checker, path, clearance, deadline)
    return np.array(path)


def _remove_needless(checker: Checker, path: list[Array], clearance: float, deadline: float) -> None:
    """Remove way points between which the straight motion is free, the longest stretches first."""
    i = 0
    while i < len(path) - 2:
        step = len(path) - 1 - i
        while step > 1 and time.monotonic() < deadline:
            if checker.free_line(path[i], path[i + step], clearance):
                del path[i + 1 : i + step]
                break
            step = (step + 1) // 2 if step > 2 else 1
        i += 1


def rounded(checker: Checker, waypoints: Array, scale: Array, clearance: float, deadline: float) -> list[Curve]:
    """Curves along the way points (k, n), with corners rounded where that is proved free.

    Where no rounding is free, two straight lines meet, and the motion stops there.
    """
    curves: list[Curve] = []
    legs = np.linalg.norm(scale * np.diff(waypoints, axis=0), axis=1)
    here = waypoints[0]
    for k in range(1, len(waypoints) - 1):
        via = waypoints[k]
        size = min(0.5 * legs[k - 1], 0.5 * legs[k], _LARGEST)
        made: Curve | None = None
        for _ in range(_ROUNDINGS):
            start = via + size / legs[k - 1] * (waypoints[k - 1] - via)
            end = via + size / legs[k] * (waypoints[k + 1] - via)
            curve = corner(start, via, end)
            if time.monotonic() < deadline and checker.blocked(curve, clearance) is None:
                made = curve
                break
            size *= 0.5
        if made is None:
            curves.append(line(here, via))
            here = via
            continue
        if np.abs(made.controls[0] - here).max() > 1e-12:
            curves.append(line(here, made.controls[0]))
        curves.append(made)
        here = made.controls[-1]
    if np.abs(waypoints[-1] - here).max() > 1e-12 or not curves:
        curves.append(line(here, waypoints[-1]))
    return curves
