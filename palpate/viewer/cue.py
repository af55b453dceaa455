"""Shows force to the eyes and ears: of users of devices that render none, and as a condition of experiments.

Displacing the drawn tool against the hand is felt as resistance (A. Lecuyer, Simulating haptic feedback using vision,
Presence 18:39, 2009), and so are a dent and a colour at the tip (M. Li and others, IEEE Trans. Haptics 2015). Only
drawing and sound change; a wire sphere marks where a displaced tool really is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import viser

from palpate.base.arrays import Array
from palpate.record.ticks import Ticks
from palpate.viewer.stage import Stage

LARGEST = 4.0
"""Radius of the halo at the force cap over the radius of the tool's sphere [-]."""
LOWEST_TONE = 220.0
"""Frequency of the tone at no force [Hz]."""
_WEAK, _STRONG = np.array([255.0, 214.0, 70.0]), np.array([225.0, 20.0, 20.0])


@dataclass(frozen=True)
class Cues:
    """The gain of each cue; 0: off."""

    displaced: float = 0.0
    """Distance of the drawn tool from its true place over that to the surface; 1: it stays on the surface."""
    dimple: float = 0.0
    """Depth of the drawn dent over the true depth; 0: as deep as the drawn tool."""
    colour: float = 0.0
    """Halo that grows and reddens; 1: full at the force cap."""
    bar: float = 0.0
    """Bar beside the picture and in the surgeon's view; 1: full at the force cap."""
    tone: float = 0.0
    """Octaves by which the tone has risen at the force cap."""

    def bar_share(self, force: float, cap: float) -> float:
        """Filled share of the bar, 0 to 1, for a force [N]."""
        return min(self.bar * force / cap, 1.0)

    def tone_Hz(self, force: float, cap: float) -> float:
        """Frequency of the tone for a force [Hz]; 0: silent, without the cue or a force."""
        return 0.0 if self.tone <= 0.0 or force <= 0.0 else LOWEST_TONE * 2.0 ** (self.tone * min(force / cap, 1.0))


PSEUDO_HAPTIC = Cues(displaced=1.0, colour=1.0)
"""The cues of the box `force cue`, and of devices without force."""


def force_of(tick: Ticks) -> float:
    """The force that cues show [N]: that of the contact on the tool, whether or not it is felt."""
    return float(np.linalg.norm(tick["F_T_W"]))


class ForceCue:
    """A halo that grows and reddens with the force on the tool, and the true place of a displaced tool's sphere."""

    def __init__(
        self, scene: viser.SceneApi, stage: Stage, cues: Cues = PSEUDO_HAPTIC, enabled: bool | None = None
    ) -> None:
        self.cues = cues
        self.enabled = stage.pseudo_haptic if enabled is None else enabled
        self._radius, self._cap = stage.radius, stage.force_cap
        self.halo = scene.add_icosphere("/cue/halo", 1.0, opacity=0.35, cast_shadow=False, visible=False)
        self.true_place = scene.add_icosphere(
            "/cue/true", stage.radius, (90, 170, 255), subdivisions=2, wireframe=True, cast_shadow=False, visible=False
        )

    def _touches(self, tick: Ticks) -> bool:
        return self.enabled and float(tick["contacts"]) > 0.0

    def shift(self, tick: Ticks) -> Array:
        """Displacement (3,) of the drawn tool in W [m]: with the gain 1 from the tool to the proxy on the surface."""
        return self.cues.displaced * np.array(tick["delta_x"]) if self._touches(tick) else np.zeros(3)

    def dent(self, tick: Ticks) -> Array | None:
        """Centre (3,) in W of the sphere at the tip that dents the surface [m]; None: as the tool is drawn."""
        if not self._touches(tick) or self.cues.dimple <= 0.0:
            return None
        return np.asarray(tick["p_WP"] - self.cues.dimple * np.array(tick["delta_x"]))

    def show(self, tick: Ticks) -> None:
        """Draws the force of a tick."""
        touches = self._touches(tick)
        halo, true = touches and self.cues.colour > 0.0, touches and self.cues.displaced > 0.0
        if halo:
            share = min(self.cues.colour * force_of(tick) / self._cap, 1.0)
            radius = self._radius * (1.0 + (LARGEST - 1.0) * share)
            red, green, blue = np.rint((1.0 - share) * _WEAK + share * _STRONG).astype(int).tolist()
            self.halo.position = np.array(tick["p_WP"]) - tick["delta_x"] + self.shift(tick)
            self.halo.scale, self.halo.color = radius, (red, green, blue)
        if true:
            self.true_place.position = np.array(tick["p_WP"]) - tick["delta_x"]
        for node, seen in ((self.halo, halo), (self.true_place, true)):
            if node.visible != seen:
                node.visible = seen
