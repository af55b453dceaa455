"""Keeps names from covering each other and the ball: each takes the first free side of its point."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
import viser
from viser.transforms import SO3

from palpate.base.arrays import Array

Anchor = Literal[
    "bottom-center", "center-left", "center-right", "top-center", "bottom-left", "bottom-right", "top-left", "top-right"
]
_SIDES: dict[Anchor, Array] = {  # centre of the text relative to its point, in halves of its width and height
    "bottom-center": np.array([0.0, -1.0]),
    "center-left": np.array([1.0, 0.0]),
    "center-right": np.array([-1.0, 0.0]),
    "top-center": np.array([0.0, 1.0]),
    "bottom-left": np.array([1.0, -1.0]),
    "bottom-right": np.array([-1.0, -1.0]),
    "top-left": np.array([1.0, 1.0]),
    "top-right": np.array([-1.0, 1.0]),
}
_LETTER, _LINE = 6.5, 17.0  # size of a letter of the browser's labels, with the frame around them [pixels]


@dataclass(frozen=True)
class Label:
    """A name in the view."""

    handle: viser.LabelHandle
    place: Callable[[], Array]
    """Its point (3,) in W [m]."""
    shown: Callable[[], bool] = lambda: True
    """False while the user hides it."""


def point_of(frame: viser.FrameHandle, p: Array) -> Array:
    """Point (3,) in W [m] of a point (3,) in a drawn frame."""
    return np.asarray(SO3(np.array(frame.wxyz)).as_matrix() @ p + np.array(frame.position))


@dataclass(frozen=True)
class Eye:
    """A browser's camera."""

    p: Array
    """(3,) position in W [m]."""
    R: Array
    """(3, 3) orientation in W: x right, y down, z into the picture."""
    width: float
    height: float
    focal: float
    """Focal length [pixels]."""

    @classmethod
    def of(cls, camera: viser.CameraHandle) -> Eye:
        """The camera of a browser."""
        focal = 0.5 * camera.image_height / np.tan(0.5 * camera.fov)
        R = np.asarray(SO3(np.array(camera.wxyz)).as_matrix())
        return cls(np.array(camera.position), R, camera.image_width, camera.image_height, float(focal))

    def pixel(self, p_W: Array) -> Array | None:
        """Pixel (2,) of a point (3,) in W; None for a point behind the camera."""
        x, y, z = self.R.T @ (p_W - self.p)
        if z <= 1e-6:
            return None
        return np.array([0.5 * self.width + self.focal * x / z, 0.5 * self.height + self.focal * y / z])


def arrange(points: list[Array | None], texts: list[str], taken: list[tuple[Array, Array]]) -> list[Anchor | None]:
    """Side of each point on which its text covers nothing before it; None where all sides are taken.

    Args:
        points: pixel (2,) of each label's point, or None if it is not in the picture.
        texts: text of each label.
        taken: boxes that stay free, as centre (2,) and half size (2,) [pixels].
    """
    boxes, sides = list(taken), list[Anchor | None]()
    for point, text in zip(points, texts, strict=True):
        side = None
        if point is not None:
            half = 0.5 * np.array([_LETTER * len(text), _LINE])
            for name, shift in _SIDES.items():
                centre = point + shift * half
                if all(np.any(np.abs(centre - c) >= half + h) for c, h in boxes):
                    side = name
                    boxes.append((centre, half))
                    break
        sides.append(side)
    return sides


class LabelPlacer:
    """Arranges the labels for the newest browser."""

    def __init__(self, server: viser.ViserServer, labels: list[Label]) -> None:
        self._server, self._labels = server, labels

    def show(self, p_ball: Array | None, radius: float) -> None:
        """Arranges all labels; p_ball: centre (3,) of the ball to drag [m], of a radius [m]."""
        clients = list(self._server.get_clients().values())
        if not clients or not self._labels:
            return
        eye = Eye.of(clients[-1].camera)
        taken = []
        centre = None if p_ball is None else eye.pixel(p_ball)
        if centre is not None and p_ball is not None:
            half = eye.focal * radius / float(np.linalg.norm(p_ball - eye.p))
            taken.append((centre, np.array([half, half])))
        points = [eye.pixel(label.place()) if label.shown() else None for label in self._labels]
        sides = arrange(points, [label.handle.text for label in self._labels], taken)
        for label, side in zip(self._labels, sides, strict=True):
            seen = side is not None
            if label.handle.visible != seen:
                label.handle.visible = seen
            if side is not None and label.handle.anchor != side:
                label.handle.anchor = side
