"""Unknown correspondence: which moving marker is which fixed marker."""

from __future__ import annotations

import itertools

import numpy as np

from palpate.base.arrays import Array
from palpate.base.arrays.rigid import transform
from palpate.base.errors import RegistrationError
from palpate.world.registration import checks
from palpate.world.registration.fit import Indices, closed_form

_BASES, _KEPT = 8, 40  # triples of moving points that are tried, and hypotheses followed from each
_GATE = 0.05  # largest distance of partners relative to the extent, where the localisation error is unknown
_SIGMAS = 8.0  # the same in localisation errors, where it is known
_POOR = 0.2  # rms residual over the largest distance of partners above which mirror images are tried
_WRONG = 0.005  # a wrong marker may be this far from its place and is still matched, to be named afterwards [m]
_RIVAL = 3.0  # a second correspondence within this factor of the best cost makes the answer ambiguous


def partners(moving: Array, fixed: Array, fle: float | None = None) -> Indices:
    """Index (N,) of the fixed point of each moving point, -1 where it has none.

    Lengths do not change in a rigid motion: triples of moving points are compared with all triples of fixed points by
    their side lengths, the best hypotheses are refined by assignment and registration in turn, and the one with the
    smallest truncated sum of squares wins.

    Args:
        moving: points (N, 3) [m].
        fixed: points (M, 3) [m]; either set may have points that the other lacks.
        fle: rms localisation error of both sets together, if it is known [m].

    Raises:
        RegistrationError: no correspondence explains at least three points and half of them; two explain them almost
            equally well; the sets are mirror images.
    """
    gate = _GATE * 2.0 * min(checks.extent(moving), checks.extent(fixed)) if fle is None else max(_SIGMAS * fle, _WRONG)
    found = _search(moving, fixed, gate)
    best, cost = found[0]
    if cost > len(moving) * (_POOR * gate) ** 2:
        _refuse_mirrored(moving, fixed, gate, cost)
    _check(best, moving, fixed, gate)
    floor = 0.0 if fle is None else 3.0 * fle**2 * len(moving)
    rivals = [other for other, c in found[1:] if c < _RIVAL * max(cost, floor) + 1e-18]
    if rivals:
        raise _ambiguous(best, rivals[0])
    return best


def _refuse_mirrored(moving: Array, fixed: Array, gate: float, cost: float) -> None:
    """Raise the error of mirrored sets if the mirror image of the moving points fits much better."""
    partner, mirrored = _search(moving * [1.0, 1.0, -1.0], fixed, gate)[0]
    if mirrored < 0.2 * cost and (partner >= 0).sum() > max(3, 0.5 * min(len(moving), len(fixed))):
        raise checks.mirror_error(float(np.sqrt(cost / len(moving))), float(np.sqrt(mirrored / len(moving))))


def _search(moving: Array, fixed: Array, gate: float) -> list[tuple[Indices, float]]:
    """Correspondences with their costs [m^2], the best first."""
    found: dict[bytes, tuple[Indices, float]] = {}
    for X in _hypotheses(moving, fixed):
        partner, cost = _refined(X, moving, fixed, gate)
        key = partner.tobytes()
        if key not in found or cost < found[key][1]:
            found[key] = (partner, cost)
    return sorted(found.values(), key=lambda one: one[1])


def _hypotheses(moving: Array, fixed: Array) -> list[Array]:
    """Poses of triples whose side lengths agree best."""
    triples = np.array(list(itertools.permutations(range(len(fixed)), 3)))
    sides = _sides(fixed[triples])
    found = []
    for base in _bases(moving):
        mismatch = np.square(sides - _sides(moving[base][None])).sum(axis=1)
        for k in np.argsort(mismatch)[:_KEPT]:
            found.append(closed_form(moving[base], fixed[triples[k]]))
    return found


def _sides(triangles: Array) -> Array:
    return np.asarray(np.linalg.norm(triangles - np.roll(triangles, 1, axis=1), axis=2))


def _bases(moving: Array) -> list[Indices]:
    """Large triples of moving points that share few points: a missing marker spoils only some of them."""
    triples = np.array(list(itertools.combinations(range(len(moving)), 3)))
    a, b, c = (moving[triples[:, i]] for i in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    uses, chosen = np.zeros(len(moving)), []
    for _ in range(min(_BASES, len(triples))):
        best = int(np.argmax(areas / (1.0 + uses[triples].sum(axis=1))))
        chosen.append(triples[best])
        uses[triples[best]] += 1.0
        areas[best] = 0.0
    return chosen


def _refined(X: Array, moving: Array, fixed: Array, gate: float) -> tuple[Indices, float]:
    """Alternate assignment and registration until the correspondence stays the same; returns it with its cost."""
    from scipy.optimize import linear_sum_assignment

    last = np.zeros(0)
    partner, cost = np.full(len(moving), -1), np.inf
    for _ in range(10):
        gaps = np.minimum(np.square(transform(X, moving)[:, None] - fixed[None]).sum(axis=2), gate**2)
        rows, columns = linear_sum_assignment(gaps)
        near = gaps[rows, columns] < gate**2
        partner = np.full(len(moving), -1)
        partner[rows[near]] = columns[near]
        unmatched = min(len(moving), len(fixed)) - near.sum()
        cost = float(gaps[rows, columns][near].sum() + unmatched * gate**2)
        if np.array_equal(partner, last) or near.sum() < 3:
            break
        X, last = closed_form(moving[rows[near]], fixed[columns[near]]), partner
    return partner, cost


def _check(best: Indices, moving: Array, fixed: Array, gate: float) -> None:
    matched, possible = int((best >= 0).sum()), min(len(moving), len(fixed))
    if matched < 3 or 2 * matched < possible or (possible > 3 and matched < 4):
        raise RegistrationError(
            f"no correspondence matches more than {matched} of {possible} points within {1e3 * gate:.3g} mm",
            why="the sets are of other markers, or a localisation error is larger",
            mend="measure again, or state a larger --fle",
        )


def _ambiguous(best: Indices, rival: Indices) -> RegistrationError:
    differ = np.flatnonzero(best != rival)
    first = int(differ[0])
    return RegistrationError(
        f"the correspondence is ambiguous: moving point {first} fits the fixed points {best[first]} and {rival[first]}",
        why="the layout of the markers is nearly symmetric",
        mend="move a marker so that all distances differ, or give the correspondence",
    )
