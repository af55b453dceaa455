"""Draws the targets of a registration: the enlarged ellipsoid that holds the error with 95 %, and the rms error."""

from __future__ import annotations

import numpy as np
import viser

from palpate.base.arrays import Array, so3
from palpate.viewer.labels import Label
from palpate.viewer.stage import TargetMark

LARGER = 5.0
"""Scale of the ellipsoids, which would be too small to see otherwise [-]."""
_INSIDE = 2.7955
"""Radius in standard deviations that holds 95 % of a normal distribution in space [-]."""
_GOLD, _POINT = (240, 190, 40), 0.0006
_THINNEST = 1e-5  # smallest standard deviation that is drawn [m]


class TargetDrawing:
    """One target; it changes while a registration runs."""

    def __init__(self, scene: viser.SceneApi, mark: TargetMark) -> None:
        """Draws the target as known at the start."""
        self._mark = mark
        name = f"/targets/{mark.name}"
        self.ellipsoid = scene.add_icosphere(f"{name}/ellipsoid", 1.0, _GOLD, cast_shadow=False)
        self._point = scene.add_icosphere(f"{name}/point", _POINT, (30, 30, 30), cast_shadow=False)
        self.label = scene.add_label(f"{name}/name", mark.name, anchor="bottom-center")
        self.named = Label(self.label, lambda: np.array(self.label.position))
        self._shown: Array | None = None
        self._draw(mark.p_W, mark.covariance)

    def show(self) -> None:
        """Shows the newest prediction of a running registration."""
        if self._mark.newest is not None:
            self._draw(*self._mark.newest())

    def _draw(self, p_W: Array, covariance: Array) -> None:
        if self._shown is not None and np.array_equal(self._shown, np.vstack([p_W, covariance])):
            return
        self._shown = np.vstack([p_W, covariance])
        wxyz, sizes = axes(covariance)
        self.ellipsoid.position, self.ellipsoid.wxyz = p_W, wxyz
        a, b, c = LARGER * _INSIDE * sizes
        self.ellipsoid.scale = (float(a), float(b), float(c))
        self._point.position, self.label.position = p_W, p_W + np.array([0.0, 0.0, c])
        tre = 1e3 * float(np.sqrt(np.trace(covariance)))
        self.label.text = f"{self._mark.name}: TRE {tre:.2f} mm rms (drawn {LARGER:g} x)"


def axes(covariance: Array) -> tuple[Array, Array]:
    """Orientation (4,) w x y z and standard deviations (3,) [m] of the ellipsoid of a covariance (3, 3) [m^2]."""
    variances, directions = np.linalg.eigh(covariance)
    if np.linalg.det(directions) < 0.0:
        directions = directions * [1.0, 1.0, -1.0]
    return so3.quaternions(directions), np.sqrt(np.maximum(variances, _THINNEST**2))
