"""Draws the plane that is felt where a remote site touches what the scene does not have, with its confidence."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import viser
from viser.transforms import SO3

from palpate.base.arrays import Array
from palpate.scene.remote import UNKNOWN

if TYPE_CHECKING:
    from palpate import _network

REACH = 0.03
"""Half of the drawn square, and distance of the tool from the plane up to which the plane is drawn [m]."""
SURE, UNSURE = np.array([40, 150, 90]), np.array([222, 120, 20])
"""Colours of a plane whose place is known to `KNOWN`, and of one that is ten times as uncertain."""
KNOWN = 1e-4
"""Standard deviation of the place from which the plane has the first colour [m]."""
_NAME = "/plane"


class PlaneDrawing:
    """A square of the plane below the tool."""

    def __init__(self, scene: viser.SceneApi) -> None:
        """Draws nothing until a plane is shown."""
        self._scene = scene
        self._square: viser.MeshHandle | None = None
        self._label: viser.LabelHandle | None = None

    def show(self, plane: _network.ModelEstimate | None, p: Array) -> None:
        """Moves the square to the point of the plane that is next to the tool at p (3,) [m]; None: no plane."""
        seen = plane is not None and abs(float(np.dot(plane.normal, p - plane.shift))) < REACH
        if self._square is None or self._label is None:
            if not seen:
                return
            self._square, self._label = self._made()
        for node in (self._square, self._label):
            if node.visible != seen:
                node.visible = seen
        if plane is None or not seen:
            return
        n = np.array(plane.normal)
        at = p - float(n @ (p - plane.shift)) * n
        self._square.position, self._square.wxyz = at, upright(n)
        self._square.color = shade(float(plane.sd_shift))
        self._label.position = at - REACH * across(n)
        self._label.text = words(plane)

    def _made(self) -> tuple[viser.MeshHandle, viser.LabelHandle]:
        corners = REACH * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
        faces = np.array([[0, 1, 2], [0, 2, 3]], np.uint32)
        square = self._scene.add_mesh_simple(
            _NAME, corners, faces, color=shade(KNOWN), side="double", opacity=0.5, cast_shadow=False
        )
        return square, self._scene.add_label(f"{_NAME}_words", "", anchor="top-center")


def words(plane: _network.ModelEstimate) -> str:
    """What is known about a plane, with standard deviations."""
    return f"{UNKNOWN}: {plane.K:.0f} N/m (sd {plane.sd_K:.0f}), place sd {1e3 * plane.sd_shift:.2f} mm"


def shade(sd: float) -> tuple[int, int, int]:
    """Colour of a plane whose place has this standard deviation [m]."""
    share = float(np.clip(np.log10(max(sd, KNOWN) / KNOWN), 0.0, 1.0))
    red, green, blue = (SURE + share * (UNSURE - SURE)).round().astype(int)
    return int(red), int(green), int(blue)


def across(normal: Array) -> Array:
    """A unit vector along a plane of this normal (3,), as much along -y as the plane allows."""
    y = np.array([0.0, 1.0, 0.0]) if abs(normal[1]) < 0.9 else np.array([1.0, 0.0, 0.0])
    along = y - float(normal @ y) * normal
    return np.asarray(along / np.linalg.norm(along))


def upright(normal: Array) -> Array:
    """Quaternion (4,) w x y z of a frame whose z axis is the normal (3,)."""
    y = across(normal)
    return np.asarray(SO3.from_matrix(np.column_stack([np.cross(y, normal), y, normal])).wxyz)
