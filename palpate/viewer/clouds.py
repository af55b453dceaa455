"""Draws the clouds that cameras see: coloured points, the camera's frustum and frame, and the age of the frame."""

from __future__ import annotations

import numpy as np
import viser
from viser.transforms import SE3

from palpate.base.arrays import Array
from palpate.sensing.sensing import Sensing
from palpate.sensing.source import CloudFrame
from palpate.world.clouds.table import Colors

MOST = 25_000
"""Number of points that are drawn; of larger clouds a part."""
EVERY = 5
"""Frames of the viewer between two updates: 6 Hz."""
_SIZE = 0.0016  # of a point [m]
_FRUSTUM = 0.06  # length of the drawn frustum [m]
_TISSUE = (176, 116, 96)
_STEEL = (90, 105, 120)


class CloudDrawing:
    """The newest frames of a session's sensors."""

    def __init__(self, scene: viser.SceneApi, sensing: Sensing) -> None:
        self._scene, self._sensing = scene, sensing
        self._nodes: dict[str, _Camera] = {}
        self._shown: dict[str, float] = {}  # stamp of the drawn frame
        self._count = 0

    def show(self, t: float) -> None:
        """Draw the newest frames at the session's time t [s]."""
        self._count += 1
        if self._count % EVERY != 1:
            return
        for name, frame in list(self._sensing.frames.items()):
            node = self._nodes.get(name)
            if node is None:
                node = self._nodes[name] = _Camera(self._scene, name)
            if self._shown.get(name) != frame.t:
                self._shown[name] = frame.t
                node.show(frame)
            node.show_age(t - frame.t, self._sensing.streams[name].section.patience)


class _Camera:
    """One camera and its cloud."""

    def __init__(self, scene: viser.SceneApi, name: str) -> None:
        self._cloud = scene.add_point_cloud(
            f"/clouds/{name}", np.zeros((1, 3), np.float32), np.zeros((1, 3), np.uint8), point_size=_SIZE
        )
        base = f"/cameras/{name}"
        self._frame = scene.add_frame(base, axes_length=0.5 * _FRUSTUM, axes_radius=0.012 * _FRUSTUM)
        self._frustum = scene.add_camera_frustum(f"{base}/frustum", 0.8, 4 / 3, scale=_FRUSTUM, color=_STEEL)
        self._label = scene.add_label(f"{base}/name", name, position=(0.0, -0.5 * _FRUSTUM, 0.0))
        self._name, self._fov = name, 0.8

    def show(self, frame: CloudFrame) -> None:
        """Draw a frame."""
        p, colors = drawn(frame)
        X = SE3.from_matrix(frame.X_WC)
        self._cloud.points = (p @ frame.X_WC[:3, :3].T + frame.X_WC[:3, 3]).astype(np.float32)
        self._cloud.colors = colors
        self._frame.wxyz, self._frame.position = X.rotation().wxyz, X.translation()

    def show_age(self, age: float, patience: float) -> None:
        """Write the age of the frame [s]."""
        self._label.text = f"{self._name}: {age_words(age, patience)}"


def age_words(age: float, patience: float) -> str:
    """The age of a frame in words; beyond the patience, both in seconds, the surface is stale and its force fades."""
    return f"{1e3 * age:.0f} ms" if age <= patience else f"STALE for {age:.1f} s, the force fades"


def drawn(frame: CloudFrame) -> tuple[Array, Colors]:
    """Points (n, 3) in C [m] and colours (n, 3) of at most `MOST` valid points of a frame, spread evenly over it."""
    p = np.asarray(frame.points).reshape(-1, 3)
    valid = np.flatnonzero(np.isfinite(p).all(axis=1))
    chosen = valid[:: max(1, -(-len(valid) // MOST))]
    colors = np.broadcast_to(np.array(_TISSUE, np.uint8), (len(chosen), 3))
    if frame.colors is not None and len(frame.colors) == len(p):
        colors = frame.colors[chosen]
    return p[chosen].astype(np.float64), np.ascontiguousarray(colors)
