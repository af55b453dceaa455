"""Motions of the joints that can be checked: a straight line, and a Bezier curve that rounds a corner."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import comb

import numpy as np

from palpate.base.arrays import Array


@dataclass(frozen=True)
class Curve:
    """A Bezier curve q(s), s in 0..1, with control points (d + 1, n) [rad, m]; two points make a straight line."""

    controls: Array

    @cached_property
    def rate(self) -> Array:
        """Bound (n,) of |dq/ds|: the derivative stays in the hull of its own control points."""
        degree = len(self.controls) - 1
        return np.asarray(degree * np.abs(np.diff(self.controls, axis=0)).max(axis=0))

    def at(self, s: Array) -> Array:
        """Joint positions (K, n) at s (K,)."""
        return _bernstein(len(self.controls) - 1, s) @ self.controls

    def derivative(self, s: Array, order: int = 1) -> Array:
        """The derivative (K, n) of an order with respect to s, at s (K,)."""
        c, factor = self.controls, 1.0
        for _ in range(order):
            if len(c) == 1:
                return np.zeros((len(s), c.shape[1]))
            factor *= len(c) - 1
            c = np.diff(c, axis=0)
        return factor * (_bernstein(len(c) - 1, s) @ c)

    def part(self, a: float, b: float) -> Curve:
        """The part from a to b, 0 <= a < b <= 1; a corner is kept whole."""
        if len(self.controls) > 2:
            return self
        return Curve(self.at(np.array([a, b])))


def line(a: Array, b: Array) -> Curve:
    """The straight line from a (n,) to b (n,)."""
    return Curve(np.stack([a, b]))


def corner(start: Array, via: Array, end: Array) -> Curve:
    """The quintic from `start` to `end` (n,) along the corner at `via`, with no curvature at either end.

    Its derivative with respect to s is 2 (via - start) at the start and 2 (end - via) at the end.
    """
    u, v = 0.4 * (via - start), 0.4 * (end - via)
    return Curve(np.stack([start, start + u, start + 2.0 * u, end - 2.0 * v, end - v, end]))


def _bernstein(degree: int, s: Array) -> Array:
    s = np.asarray(s)[:, None]
    k = np.arange(degree + 1)
    binomial = np.array([comb(degree, int(i)) for i in k], dtype=float)
    return np.asarray(binomial * s**k * (1.0 - s) ** (degree - k))
