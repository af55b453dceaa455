"""The instrument as balls in W: a camera sees it, but it is not part of the surface that it touches."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array, so3
from palpate.base.errors import SceneError
from palpate.record.ticks import Ticks
from palpate.scene import tool
from palpate.scene.rig import Rig


class Instrument:
    """The contact spheres of the tool: that of the tip, and those of the model of the arm and of the scene.

    Args:
        rig: the rig, whose follower carries the tool.
    """

    def __init__(self, rig: Rig) -> None:
        self._follower, self._X_WB = rig.arms.follower, rig.arms.X_WB
        self._radius = rig.scene.contact.radius
        try:
            self._spheres = tool.tool_spheres(self._follower, rig.scene.contact.spheres, whole=True)
        except SceneError:  # the model of this arm has no spheres
            self._spheres = rig.spheres

    def balls(self, tick: Ticks, margin: float) -> Array:
        """Centres and radii (k, 4) in W [m] at a tick, each radius larger by a margin [m]; the first is on the tip."""
        p = np.asarray(tick["p_WT"], dtype=np.float64)
        found = [np.r_[p, self._radius + margin]]
        quat = np.asarray(tick["quat_WT"], dtype=np.float64)
        if quat.any():
            X_WT = so3.pose(p, quat)
            links = self._follower.link_poses(np.asarray(tick["q_follower"], dtype=np.float64)[: self._follower.n])
            for s in self._spheres:
                found.append(np.r_[s.centre(X_WT, self._X_WB, links, float(tick["jaw"])), s.core.radius + margin])
        return np.ascontiguousarray(found)

    def is_hidden(self, points_W: Array, p_WC: Array, balls: Array) -> npt.NDArray[np.bool_]:
        """Whether a camera at p_WC (3,) sees a ball in front of each point (n, 3) in W: (n,) of bool."""
        d = points_W - p_WC
        length = np.maximum(np.linalg.norm(d, axis=1), 1e-12)
        d = d / length[:, None]
        hidden = np.zeros(len(points_W), dtype=bool)
        for centre, radius in zip(balls[:, :3] - p_WC, balls[:, 3], strict=True):
            along = d @ centre
            across2 = centre @ centre - along**2
            hidden |= (across2 < radius**2) & (along > 0.0) & (along - radius < length)
        return hidden
