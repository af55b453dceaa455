"""Closes the hole that the tool leaves in a frame, where the surface was never seen."""

from __future__ import annotations

import numpy as np

from palpate.base.arrays import Array

_RING = 2.5  # outer radius of the points around the hole that determine the patch, in radii of the hole
_LEAST = 24  # points that determine it at least


def patch(points: Array, p_WC: Array, centre: Array, radius: float, spacing: float) -> tuple[Array, Array]:
    """Points (n, 3) and normals (n, 3) of a surface over a hole that continues the surface around it.

    The surface is the quadratic height field that fits the points around the hole by least squares. It covers a disc
    below the centre, except where there are points.

    Args:
        points: (m, 3) points of a frame in W [m].
        p_WC: (3,) position of the camera in W, from whose side the surface is seen [m].
        centre: (3,) point above or below the hole, the tip of the tool [m].
        radius: radius of the hole [m].
        spacing: distance between the new points [m].
    """
    nothing = np.empty((0, 3)), np.empty((0, 3))
    off = points - centre
    near = points[np.einsum("ni,ni->n", off, off) < (_RING * radius) ** 2]
    if len(near) < _LEAST:
        return nothing
    middle = near.mean(axis=0)
    n = np.linalg.eigh(_squares(near - middle, near - middle))[1][:, 0]
    n = n if n @ (p_WC - middle) > 0.0 else -n
    u = np.cross(n, np.eye(3)[int(np.argmin(np.abs(n)))])
    u /= np.linalg.norm(u)
    axes = np.stack([u, np.cross(n, u), n])
    local = (near - centre) @ axes.T
    scaled = local / radius  # of the order of one, as normal equations ask for
    terms = _terms(scaled[:, 0], scaled[:, 1])
    weak = 1e-9 * len(near) * np.eye(terms.shape[1])
    fit = np.linalg.solve(_squares(terms, terms) + weak, _squares(terms, scaled[:, 2:]))[:, 0]
    coefficients = fit * radius ** np.array([1, 0, 0, -1, -1, -1])
    steps = np.arange(-radius, radius + spacing, spacing)
    x, y = (a.ravel() for a in np.meshgrid(steps, steps))
    inside = np.hypot(x, y) < radius
    taken = np.zeros((len(steps) + 2,) * 2, dtype=bool)
    cells = np.floor((local[:, :2] + radius) / spacing + 0.5).astype(int)
    cells = cells[((cells >= 0) & (cells < len(taken))).all(axis=1)]
    taken[cells[:, 0], cells[:, 1]] = True
    at = np.floor((np.stack([x, y], axis=1) + radius) / spacing + 0.5).astype(int)
    free = inside & ~taken[at[:, 0], at[:, 1]]
    x, y = x[free], y[free]
    _, c1, c2, c3, c4, c5 = coefficients
    slopes = np.stack([-(c1 + 2 * c3 * x + c4 * y), -(c2 + c4 * x + 2 * c5 * y), np.ones_like(x)], axis=1)
    normals = slopes / np.linalg.norm(slopes, axis=1, keepdims=True)
    return np.stack([x, y, _terms(x, y) @ coefficients], axis=1) @ axes + centre, normals @ axes


def _squares(a: Array, b: Array) -> Array:
    """The matrix a^T b, in this thread alone: BLAS would wake its others, which disturbs the loop."""
    return np.asarray(np.einsum("ni,nj->ij", a, b))


def _terms(x: Array, y: Array) -> Array:
    return np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=1)
