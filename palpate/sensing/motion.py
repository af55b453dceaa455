"""The velocity of a surface between frames, from the displacements between them."""

from __future__ import annotations

import numpy as np

from palpate.base.arrays import Array

_ALIKE = 1.2e-3  # two displacements that differ by less are one motion, and not a jump [m]
_SMOOTH = 0.6  # share of a new velocity in the filtered one [-]
_SLOW = 1.5e-3  # lower speeds are those of noise [m/s]


class SurfaceMotion:
    """A filtered velocity of a surface that translates.

    A displacement counts as motion once the displacement of the following frame is alike. A jump between two frames is
    therefore not extrapolated.
    """

    def __init__(self) -> None:
        self.V = np.zeros(3)  #: velocity in W [m/s]; zero while the displacements are not alike
        self._measured = np.zeros(3)

    def update(self, shift: Array | None, dt: float) -> Array:
        """The velocity (3,) [m/s] after a displacement (3,) [m] in a time dt [s]; None: it is not known."""
        if shift is None or not dt > 0.0:
            self.V, self._measured = np.zeros(3), np.zeros(3)
            return self.V
        measured = np.asarray(shift) / dt
        alike = float(np.linalg.norm(measured - self._measured)) * dt < _ALIKE
        self._measured = measured
        self.V = (
            self.V + _SMOOTH * (measured - self.V) if alike and self.V.any() else measured if alike else np.zeros(3)
        )
        if float(np.linalg.norm(self.V)) < _SLOW:
            self.V = np.zeros(3)
        return self.V
