"""The picture of a device: its handle in its workspace where it stands, and around the tool what the tool can reach
without a clutch. Both redden as the range comes to its end.
"""

from __future__ import annotations

from itertools import product

import numpy as np
import viser

from palpate.base.arrays import Array, so3
from palpate.record.ticks import Ticks
from palpate.viewer.stage import DeviceMark

HANDLE, AXES = 0.008, 0.03
"""Radius of the drawn handle, length of its axes [m]."""
NEAR = 0.1
"""Way to a side over the length of the workspace below which the picture is red [-]."""
_FREE, _EDGE = (60, 120, 170), (225, 38, 38)


class DeviceDrawing:
    """Draws the device of a stage in W."""

    def __init__(self, scene: viser.SceneApi, mark: DeviceMark) -> None:
        self.mark = mark
        self._scene, self._centre = scene, mark.centre
        self._handle = scene.add_icosphere("/device/handle", HANDLE, _FREE, cast_shadow=False)
        self._axes = scene.add_frame("/device/axes", axes_length=AXES, axes_radius=0.05 * AXES)
        self._place = scene.add_frame("/device/workspace", show_axes=False)
        self._reach = scene.add_frame("/device/reach", show_axes=False)
        self._box: dict[bool, list[viser.LineSegmentsHandle]] = {}
        if self._centre is not None:
            self._draw_box()

    def show(self, tick: Ticks) -> None:
        """Moves the handle; the first tick places a workspace whose centre the driver does not state."""
        p_LH = np.array(tick["p_LH"])
        if self._centre is None and float(tick["t"]) > 0.0:
            self._centre = p_LH
            self._draw_box()
        self._drag_along(p_LH)
        edge = self.at_edge(tick)
        X_WH = self.mark.X_WL @ so3.pose(p_LH, tick["quat_LH"])
        self._handle.position = self._axes.position = X_WH[:3, 3]
        self._handle.color = _EDGE if edge else _FREE
        self._axes.wxyz = so3.quaternions(X_WH[:3, :3])
        if self._centre is not None:  # the place of the tool for a handle in the middle of its workspace
            motion = self.mark.scale * self.mark.X_WL[:3, :3] @ (p_LH - self._centre)
            self._reach.position = np.array(tick["p_WT"]) - motion
            self._place.position = self.mark.X_WL[:3, :3] @ self._centre + self.mark.X_WL[:3, 3]
        for red, boxes in self._box.items():
            for box in boxes:
                if box.visible != (red == edge):
                    box.visible = red == edge

    def _drag_along(self, p_LH: Array) -> None:
        """Where nobody states the centre, the handle shows it: no handle is outside of its workspace.

        The laws `rate` and `drift` keep their centre at the first position, and act by it.
        """
        kept = self.mark.centre is not None or self.mark.mapping.startswith(("rate", "drift"))
        if self._centre is None or self.mark.workspace is None or kept:
            return
        half = 0.5 * self.mark.workspace
        self._centre = np.clip(self._centre, p_LH - half, p_LH + half)

    def corners(self) -> Array:
        """Corners (8, 3) of a box around handle and workspace, where the device stands [m]."""
        half = HANDLE + AXES if self.mark.workspace is None else 0.5 * float(np.max(self.mark.workspace)) + AXES
        return np.asarray(self._handle.position) + half * np.array(list(product((-1.0, 1.0), repeat=3)))

    def left(self, tick: Ticks) -> Array | None:
        """Way (3,) of the handle to the nearer side along each axis of the base [m]; None: the range is unknown."""
        if self.mark.workspace is None or self._centre is None:
            return None
        return np.asarray(0.5 * self.mark.workspace - np.abs(np.array(tick["p_LH"]) - self._centre))

    def at_edge(self, tick: Ticks) -> bool:
        """True if a side of the workspace is near."""
        left = self.left(tick)
        return left is not None and bool((left < NEAR * np.asarray(self.mark.workspace)).any())

    def left_in_words(self, tick: Ticks) -> str:
        """The smallest way that is left, and its direction along the axes of the base."""
        left = self.left(tick)
        if left is None or self._centre is None:
            return "unknown"
        i = int(np.argmin(left))
        side = "-+"[int(np.array(tick["p_LH"])[i] >= self._centre[i])]
        return f"{1e3 * left[i]:.0f} mm to {side}{'xyz'[i]}" if left[i] >= 0.0 else f"beyond by {-1e3 * left[i]:.0f} mm"

    def _draw_box(self) -> None:
        """The twelve edges of the workspace and of the tool's reach, once in each colour."""
        if self.mark.workspace is None or self._centre is None:
            return
        corners = np.array(list(product((-0.5, 0.5), repeat=3)))
        pairs = [(a, b) for a in range(8) for b in range(a) if np.abs(corners[a] - corners[b]).sum() == 1.0]
        turned = corners * self.mark.workspace @ self.mark.X_WL[:3, :3].T
        places = {"workspace": turned, "reach": self.mark.scale * turned}  # in their moving frames
        for red, color in ((False, _FREE), (True, _EDGE)):
            self._box[red] = []
            for place, p in places.items():
                points = np.array([[p[a], p[b]] for a, b in pairs], dtype=np.float32)
                name = f"/device/{place}/{'edge' if red else 'free'}"
                box = self._scene.add_line_segments(name, points, color, thickness=0.001, visible=not red)
                self._box[red].append(box)
