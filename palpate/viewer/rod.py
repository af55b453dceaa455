"""Draws the rod that instruments hold and hand over."""

from __future__ import annotations

import numpy as np
import viser
from viser.transforms import SE3

from palpate.base.arrays.so3 import pose
from palpate.record.ticks import Ticks
from palpate.scene.graspable import GraspableSection

METAL = (214, 172, 58)


class RodDrawing:
    """A cylinder with round ends at the pose that a tick holds; a tick without a pose leaves it where it was."""

    def __init__(self, scene: viser.SceneApi, rod: GraspableSection) -> None:
        """Draws the rod at its start."""
        import trimesh

        mesh = trimesh.creation.capsule(rod.length, rod.radius, count=[12, 12])
        mesh.apply_translation(-mesh.bounds.mean(axis=0))  # the frame of the rod is in its middle
        self._mesh = scene.add_mesh_simple("/rod", np.asarray(mesh.vertices), np.asarray(mesh.faces), color=METAL)
        self._place(rod.pose.matrix())

    def show(self, tick: Ticks) -> None:
        """Moves the rod to a tick."""
        if np.isfinite(tick["p_WO"]).all() and np.isfinite(tick["quat_WO"]).all() and np.any(tick["quat_WO"]):
            self._place(pose(tick["p_WO"], tick["quat_WO"]))

    def _place(self, X_WO: np.ndarray) -> None:
        X = SE3.from_matrix(X_WO)
        self._mesh.position, self._mesh.wxyz = X.translation(), X.rotation().wxyz
