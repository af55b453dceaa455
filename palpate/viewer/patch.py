"""Cuts the neighbourhood of the contacts out of a drawn surface, and returns it refined and pressed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from palpate.base.arrays import Array
from palpate.viewer.dent import Press, pressed, refined

_LARGER = 1.4  # radius of a new cut over the reach of the dent [-]
_WASTED = 3.0  # ... above which the cut is made again, smaller [-]
_MOVED = 0.5  # motion of a contact over the sphere's radius, after which the surface is refined again [-]
_STILL = 2e-5  # smallest motion of a sphere that changes the drawn dent [m]

Labels = NDArray[np.int64]


@dataclass(frozen=True)
class Patch:
    """The pressed part of a surface."""

    rest: NDArray[np.bool_]
    """(m,) True for the triangles of the surface that remain as they are."""
    vertices: Array
    """(n, 3 + k) of the pressed part, in O [m]; columns of the surface beyond the first three follow."""
    triangles: NDArray[np.int32]
    labels: Labels
    """Label of each triangle."""
    is_new_cut: bool
    """True if `rest` differs from that of the last patch."""


class PatchCutter:
    """Keeps one cut until the contacts leave it, because a new cut makes the browser load the whole surface again.

    Args:
        vertices: (n, 3 + k) in O [m].
        triangles: (m, 3).
        labels: (m,) labels of the triangles.
    """

    def __init__(self, vertices: Array, triangles: NDArray[np.int32], labels: Labels) -> None:
        self._vertices, self._triangles, self._labels = vertices, triangles, labels
        corners = vertices[triangles, :3]
        self._middle = corners.mean(axis=1)
        self._size = np.linalg.norm(corners - self._middle[:, None], axis=2).max(axis=1)
        self._welded = np.unique(vertices[:, :3], axis=0, return_inverse=True)[1].ravel()
        self._cut: list[tuple[Array, float]] = []  # centre and radius of each ball of the cut
        self._rest: NDArray[np.bool_] | None = None
        self._shown: Array | None = None
        self._fine: tuple[Array, NDArray[np.int32], Labels]
        self._fine_at: list[Array] = []

    def reset(self) -> None:
        """Forgets the cut: the surface is drawn whole."""
        self._cut, self._rest, self._shown = [], None, None

    def normal(self, point: Array, radius: float) -> Array:
        """Mean outward unit normal (3,) of the triangles within `radius` [m] of a point (3,) on the surface."""
        near = np.linalg.norm(self._middle - point, axis=1) - self._size < radius
        a, b, c = (self._vertices[self._triangles[near, k], :3] for k in range(3))
        total = np.cross(b - a, c - a).sum(axis=0)
        return np.asarray(total / max(float(np.linalg.norm(total)), 1e-30))

    def patch(self, presses: list[Press]) -> Patch | None:
        """The pressed part under one sphere or more; None if it is the same as before."""
        state = np.array([[*press.centre, *press.point] for press in presses])
        shown = self._shown
        if shown is not None and shown.shape == state.shape and float(np.abs(state - shown).max()) < _STILL:
            return None
        self._shown = state
        is_new = self._rest is None or not self._holds(presses)
        if is_new:
            self._cut = [(press.point, _LARGER * press.reach) for press in presses]
            self._rest = ~np.any([self._near(*ball) for ball in self._cut], axis=0)
        if is_new or self._moved(presses):
            self._refine(presses)
        assert self._rest is not None
        surface, triangles, labels = self._fine
        vertices = surface.copy()
        for press in presses:
            vertices[:, :3] = pressed(vertices[:, :3], triangles, press)
        return Patch(self._rest, vertices, triangles, labels, is_new)

    def _refine(self, presses: list[Press]) -> None:
        cut = ~self._rest  # type: ignore[operator]
        kept, inverse = np.unique(self._triangles[cut], return_inverse=True)
        renumbered = inverse.reshape(-1, 3).astype(np.int32)
        self._fine = refined(self._vertices[kept], renumbered, self._labels[cut], presses)
        self._fine_at = [press.point for press in presses]

    def _moved(self, presses: list[Press]) -> bool:
        """True if a contact has left the part of the surface that was refined for it."""
        return any(
            min(float(np.linalg.norm(press.point - p)) for p in self._fine_at) > _MOVED * press.radius
            for press in presses
        )

    def _holds(self, presses: list[Press]) -> bool:
        """True if the present cut contains every dent without being much larger."""
        most = max(press.reach for press in presses)
        if max(radius for _, radius in self._cut) > _WASTED * most:
            return False
        return all(
            any(float(np.linalg.norm(press.point - p)) + press.reach < radius for p, radius in self._cut)
            for press in presses
        )

    def _near(self, point: Array, radius: float) -> NDArray[np.bool_]:
        """(m,) True for the triangles within a ball that hang together with the one nearest to its centre.

        Beside the drawn part of a surface, for example of an infinite plane, this is the nearest triangle alone.
        """
        from scipy.sparse import coo_array
        from scipy.sparse.csgraph import connected_components

        away = np.linalg.norm(self._middle - point, axis=1) - self._size
        chosen = np.flatnonzero(away < max(radius, float(away.min()) + 1e-12))
        corner = self._welded[self._triangles[chosen]].ravel()
        owner = np.repeat(np.arange(len(chosen)), 3)
        links = coo_array((np.ones(len(owner)), (owner, len(chosen) + corner)))
        links.resize((links.shape[1], links.shape[1]))
        _, part = connected_components(links, directed=False)
        part = part[: len(chosen)]
        found = np.zeros(len(away), dtype=bool)
        found[chosen[part == part[np.argmin(away[chosen])]]] = True
        return found
