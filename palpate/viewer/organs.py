"""Draws the objects that can be touched, with their regions and the dent under the tool, and moves them."""

from __future__ import annotations

import numpy as np
import viser
from numpy.typing import NDArray
from viser.transforms import SE3

from palpate import _core
from palpate.base.arrays import Array
from palpate.record import live
from palpate.record.ticks import Ticks
from palpate.viewer.dent import Press
from palpate.viewer.patch import PatchCutter
from palpate.viewer.skins import BandedSkin, Color, ColoredSkin, PlainSkin, Skin
from palpate.viewer.stage import RegionMark, TouchedObject
from palpate.world.mesh.coarse import coarser

HIDDEN, HIDDEN_SHARE = (120, 125, 130), 0.7
"""Colour and least transparency of an object that a simulated remote site alone has."""

TINT: Color = (222, 178, 62)
"""Colour of a region: of the object's triangles inside the region, and of the region's own body."""

LIGHT_TRIANGLES = 4000
"""Number of triangles of an object in a light picture."""


class OrganDrawing:
    """One object, split by region, under a frame that moves. The tool's spheres press dents into it."""

    def __init__(self, scene: viser.SceneApi, obj: TouchedObject, color: Color) -> None:
        """Draws the object at its rest pose; color: used unless the scene or the mesh file names one."""
        self._moving, self._slot, self._X_WO = obj.moving, obj.slot, np.array(obj.X_WO)
        self._takes_dents = not obj.is_cloud
        self._scene, self._share = scene, 0.0
        self._coloured: BandedSkin | None = None
        self.holds = obj.holds or bool(obj.regions)
        self._name = f"/objects/{obj.name}"
        X = SE3.from_matrix(obj.X_WO)
        self._frame = scene.add_frame(self._name, show_axes=False, wxyz=X.rotation().wxyz, position=X.translation())
        self._vertices = obj.vertices if obj.colors is None else np.hstack([obj.vertices, obj.colors])
        self._triangles = obj.triangles
        inside = np.any([mark.triangles for mark in obj.regions], axis=0) if obj.regions else None
        self._labels = np.zeros(len(obj.triangles), np.int64) if inside is None else inside.astype(np.int64)
        self._least = HIDDEN_SHARE if obj.hidden else 0.0
        own = obj.color or (HIDDEN if obj.hidden else color)
        shades = [None if obj.colors is not None else own, TINT]
        self._parts, self._patches = (
            [_skin(scene, f"{self._name}/{k}{suffix}", shade) for k, shade in enumerate(shades)]
            for suffix in ("", "_pressed")
        )
        self._full = self._vertices, self._triangles, self._labels
        self._may_be_coarse = self._takes_dents and not obj.soft and len(obj.triangles) > LIGHT_TRIANGLES
        self.is_light = False
        self._cutter: PatchCutter | None = None
        self._is_pressed = False
        self._draw(np.ones(len(obj.triangles), dtype=bool))
        for k, mark in enumerate(obj.regions):
            _body(scene, f"{self._name}/region{k}", mark)
        if obj.hidden:
            self.see_through(0.0)
            top = obj.vertices[np.argmax(obj.vertices @ obj.X_WO[2, :3])]
            scene.add_label(f"{self._name}/hidden", f"{obj.name}: hidden from the hand", position=top,
                            anchor="bottom-center")  # fmt: skip

    def see_through(self, share: float) -> None:
        """Sets the transparency: 0 opaque, up to 0.9."""
        self._share = share = max(share, self._least)
        for part in (*self._parts, *self._patches):
            part.see_through(share)
        if self._coloured is not None:
            self._coloured.see_through(share)

    def set_light(self, light: bool) -> None:
        """Draws at most about `LIGHT_TRIANGLES` triangles, or all of them again."""
        if light == self.is_light or not self._may_be_coarse:
            return
        if self._is_pressed:
            self._release()
        self.is_light, self._cutter = light, None
        self._vertices, self._triangles, self._labels = self._full
        if light:
            self._vertices, self._triangles, source = coarser(self._vertices, self._triangles, LIGHT_TRIANGLES)
            self._labels = self._labels[source]
        self._draw(np.ones(len(self._triangles), dtype=bool))

    def error(self) -> float:
        """Largest distance of a vertex of the full surface from the drawn one [m]: zero unless it is light."""
        if not self.is_light:
            return 0.0
        drawn = _core.Mesh(self._vertices[:, :3], self._triangles)
        return float(np.abs(drawn.nearest(self._full[0][:, :3])[0]).max())

    def show(self, tick: Ticks) -> None:
        """Moves the object to its pose at a tick."""
        X_WO = self._moving(float(tick["t"])) if self._moving is not None else None
        if self._slot is not None:
            X_WO = live.object_pose(tick, self._slot)
        if X_WO is None:
            return
        self._X_WO = X_WO
        X = SE3.from_matrix(X_WO)
        self._frame.wxyz, self._frame.position = X.rotation().wxyz, X.translation()

    def press(self, spheres: list[tuple[Array, float, Array, Array | None]]) -> None:
        """Draws the dents of spheres; without spheres the surface is as it was at the start.

        Args:
            spheres: centre (3,) and radius of each [m], the point (3,) where its proxy touches the object, and the
                surface normal (3,) there, None if it is to be estimated. In W.
        """
        if not spheres or not self._takes_dents:
            if self._is_pressed:
                self._release()
            return
        if self._cutter is None:
            self._cutter = PatchCutter(self._vertices, self._triangles, self._labels)
        presses = [self._in_object(*sphere) for sphere in spheres]
        patch = self._cutter.patch([press for press in presses if press.depth > 0.0] or presses[:1])
        if patch is None:
            return
        if patch.is_new_cut:
            self._draw(patch.rest)
        for k, skin in enumerate(self._patches):
            skin.show(patch.vertices, patch.triangles[patch.labels == k])
        self._is_pressed = True

    def deform(self, vertices: Array, bands: NDArray[np.int64] | None = None) -> None:
        """Draws a soft object as deformed; from then on it takes no dents.

        Args:
            vertices: (n, 3) in O [m], in the order of the drawn object.
            bands: (m,) number of the colour in `skins.BANDS` of each triangle; None: the object's own colours.
        """
        if self._is_pressed:
            self._release()
        self._takes_dents = False
        self._vertices = vertices
        if bands is not None and self._coloured is None:
            self._coloured = BandedSkin(self._scene, f"{self._name}/coloured")
            self._coloured.see_through(self._share)
        if self._coloured is not None:
            none = np.full(len(self._triangles), -1)
            self._coloured.show(vertices, self._triangles, none if bands is None else bands)
        self._draw(np.full(len(self._triangles), bands is None))

    def _in_object(self, centre: Array, radius: float, point: Array, normal: Array | None) -> Press:
        assert self._cutter is not None
        R_WO, p_WO = self._X_WO[:3, :3], self._X_WO[:3, 3]
        p_OC = R_WO.T @ (point - p_WO)
        n = self._cutter.normal(p_OC, radius) if normal is None else R_WO.T @ normal
        return Press(R_WO.T @ (centre - p_WO), radius, p_OC, n)

    def _release(self) -> None:
        assert self._cutter is not None
        self._cutter.reset()
        self._is_pressed = False
        self._draw(np.ones(len(self._triangles), dtype=bool))
        for skin in self._patches:
            skin.show(self._vertices, self._triangles[:0])

    def _draw(self, chosen: NDArray[np.bool_]) -> None:
        for k, part in enumerate(self._parts):
            part.show(self._vertices, self._triangles[chosen & (self._labels == k)])


def _skin(scene: viser.SceneApi, name: str, color: Color | None) -> Skin:
    return ColoredSkin(scene, name) if color is None else PlainSkin(scene, name, color)


def _body(scene: viser.SceneApi, name: str, mark: RegionMark) -> None:
    """Draws a region slightly too small, so that coincident surfaces do not flicker."""
    if mark.half.any():
        x, y, z = (0.98 * 2.0 * (mark.half + mark.radius)).tolist()
        scene.add_box(name, TINT, (x, y, z), position=mark.centre, cast_shadow=False)
    else:
        scene.add_icosphere(name, 0.98 * mark.radius, TINT, position=mark.centre, cast_shadow=False)
