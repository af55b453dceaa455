"""Shows force to users of devices that render none: the tool stays on the surface while the hand goes in.

Displacing the drawn tool against the hand is felt as resistance (A. Lecuyer, Simulating haptic feedback using vision,
Presence 18:39, 2009). Only the drawing changes; a wire sphere marks where the tool really is.
"""

from __future__ import annotations

import numpy as np
import viser

from palpate.arrays import Array
from palpate.record.ticks import Ticks
from palpate.viewer.stage import Stage

LARGEST = 4.0
"""Radius of the halo at the force cap over the radius of the tool's sphere [-]."""
_WEAK, _STRONG = np.array([255.0, 214.0, 70.0]), np.array([225.0, 20.0, 20.0])


class ForceCue:
    """A halo that grows and reddens with the force on the hand, and the true place of the tool's sphere."""

    def __init__(self, scene: viser.SceneApi, stage: Stage) -> None:
        self.enabled = stage.pseudo_haptic
        self._radius, self._cap = stage.radius, stage.force_cap
        self.halo = scene.add_icosphere("/cue/halo", 1.0, opacity=0.35, cast_shadow=False, visible=False)
        self.true_place = scene.add_icosphere(
            "/cue/true", stage.radius, (90, 170, 255), subdivisions=2, wireframe=True, cast_shadow=False, visible=False
        )

    def shift(self, tick: Ticks) -> Array:
        """Displacement (3,) of the drawn tool in W [m]: from the tool to the proxy, which stays on the surface."""
        touches = self.enabled and float(tick["contacts"]) > 0.0
        return np.array(tick["delta_x"]) if touches else np.zeros(3)

    def show(self, tick: Ticks) -> None:
        """Draws the force of a tick."""
        seen = self.enabled and float(tick["contacts"]) > 0.0
        if seen:
            p_WS = np.array(tick["p_WP"]) - tick["delta_x"]
            share = min(float(np.linalg.norm(tick["F_H_L"])) / self._cap, 1.0)
            radius = self._radius * (1.0 + (LARGEST - 1.0) * share)
            red, green, blue = np.rint((1.0 - share) * _WEAK + share * _STRONG).astype(int).tolist()
            self.halo.position, self.true_place.position = tick["p_WP"], p_WS
            self.halo.scale, self.halo.color = radius, (red, green, blue)
        for node in (self.halo, self.true_place):
            if node.visible != seen:
                node.visible = seen
