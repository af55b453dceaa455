"""Draws arms: a mesh per colour and arm, whose vertices follow the links.

Nodes per link would be ten times as many draw calls, which is what limits a browser without a graphics card.
"""

from __future__ import annotations

import numpy as np
import viser
from viser.transforms import SE3

from palpate.arm.shapes import Visual
from palpate.base.arrays import Array
from palpate.viewer.solids import merged
from palpate.viewer.stage import ArmPlace

Color = tuple[int, int, int]
TINT = 0.55
"""Share of a pair's colour in the colours of its arms [-]."""
STILL = 2e-5
"""Smallest change of a link's pose that is drawn [m, rad]."""


class ArmDrawing:
    """The primitives of an arm's links."""

    def __init__(self, scene: viser.SceneApi, place: ArmPlace, tint: Color | None = None) -> None:
        """Draws the arm at its home position; `tint` is mixed into its colours."""
        self._arm = place.arm
        X = SE3.from_matrix(place.X_WA)
        base = f"/{place.name}"
        self._base = scene.add_frame(base, show_axes=False, wxyz=X.rotation().wxyz, position=X.translation())
        self._p_WA, self._shift = np.array(X.translation()), np.zeros(3)
        self._links = list(dict.fromkeys(visual.link for visual in place.arm.visuals))
        looks: dict[Color, list[Visual]] = {}
        for visual in place.arm.visuals:
            looks.setdefault(_mixed(visual.colour, tint), []).append(visual)
        self._skins = [_Skin(scene, f"{base}/{k}", look, self._links) for k, look in enumerate(looks.items())]
        self._shown = np.zeros((len(self._links), 4, 4))
        self.show(place.arm.home, 0.0)

    def show(self, q: Array, pinch: float) -> dict[str, Array]:
        """Moves the links to joints q (n,) [rad, m] and jaw or grip angle `pinch` [rad]; returns their poses."""
        poses = self._arm.link_poses(q[: self._arm.n], pinch)  # the arrays of a tick are longer than n
        X_AL = np.stack([poses[link] for link in self._links])
        moved = np.abs(X_AL - self._shown).max(axis=(1, 2)) > STILL
        if moved.any():
            self._shown = X_AL
            for skin in self._skins:
                skin.show(X_AL, moved)
        return poses

    def shift(self, by: Array) -> None:
        """Displaces the whole drawn arm by (3,) in W [m]."""
        if np.abs(by - self._shift).max() > STILL or (self._shift.any() and not by.any()):
            self._shift, self._base.position = by, self._p_WA + by


class _Skin:
    """The primitives of one colour."""

    def __init__(self, scene: viser.SceneApi, name: str, look: tuple[Color, list[Visual]], links: list[str]) -> None:
        color, visuals = look
        self._p_LV, triangles, owner = merged(visuals)
        self._link = np.array([links.index(visual.link) for visual in visuals])[owner]
        points = self._p_LV.astype(np.float32)
        self._mesh = scene.add_mesh_simple(name, points, triangles, color=color)

    def show(self, X_AL: Array, moved: Array) -> None:
        """Moves the vertices to link poses X_AL (m, 4, 4); moved (m,): True for the links that have moved."""
        if moved[self._link].any():
            X = X_AL[self._link]
            p_AV = np.einsum("nij,nj->ni", X[:, :3, :3], self._p_LV) + X[:, :3, 3]
            self._mesh.vertices = p_AV.astype(np.float32)


def _mixed(own: tuple[float, ...], tint: Color | None) -> Color:
    """Colour of a visual (0 to 1) with a share of the tint, 0 to 255."""
    share = 0.0 if tint is None else TINT
    r, g, b = (round((1.0 - share) * 255.0 * c + share * t) for c, t in zip(own[:3], tint or (0, 0, 0), strict=True))
    return r, g, b
