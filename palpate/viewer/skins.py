"""A surface in the browser: in one colour, or with a colour for each vertex."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
import viser
from numpy.typing import NDArray

from palpate.base.arrays import Array

Color = tuple[int, int, int]
BANDS: tuple[Color, ...] = (
    (68, 1, 84), (72, 35, 116), (64, 67, 135), (52, 94, 141), (41, 120, 142),
    (32, 144, 140), (34, 167, 132), (68, 190, 112), (121, 209, 81), (189, 222, 38), (253, 231, 37),
)  # fmt: skip
"""Colours of a quantity from zero to its largest value: those of matplotlib's viridis at equal distances."""


class Skin(Protocol):
    """A surface whose shape can change."""

    def show(self, vertices: Array, triangles: NDArray[np.int32]) -> None:
        """Draws vertices (n, 3 + k) [m], with their colours in the last three columns, and triangles (m, 3)."""
        ...

    def see_through(self, share: float) -> None:
        """Sets the transparency: 0 opaque, up to 0.9."""
        ...


class PlainSkin:
    """A surface in one colour."""

    def __init__(self, scene: viser.SceneApi, name: str, color: Color) -> None:
        self._scene, self._name, self._color = scene, name, color
        self._opacity: float | None = None
        self.mesh: viser.MeshHandle | None = None

    def show(self, vertices: Array, triangles: NDArray[np.int32]) -> None:
        """As `Skin.show`; without triangles the surface is hidden."""
        if not len(triangles):
            if self.mesh is not None:
                self.mesh.visible = False
            return
        points, faces = vertices[:, :3].astype(np.float32), triangles.astype(np.uint32)
        if self.mesh is None:
            self.mesh = self._scene.add_mesh_simple(
                self._name, points, faces, color=self._color, side="double", opacity=self._opacity
            )
            return
        self.mesh.vertices = points
        if not np.array_equal(self.mesh.faces, faces):
            self.mesh.faces = faces
        if not self.mesh.visible:
            self.mesh.visible = True

    def see_through(self, share: float) -> None:
        """As `Skin.see_through`."""
        self._opacity = None if share < 0.01 else 1.0 - share
        if self.mesh is not None:
            self.mesh.opacity = self._opacity


class ColoredSkin:
    """A surface with a colour for each vertex, sent to the browser as glTF."""

    def __init__(self, scene: viser.SceneApi, name: str) -> None:
        self._scene, self._name = scene, name
        self._opacity = 1.0
        self._shape: tuple[Array, NDArray[np.int32]] | None = None
        self.mesh: viser.GlbHandle | None = None

    def show(self, vertices: Array, triangles: NDArray[np.int32]) -> None:
        """As `Skin.show`; without triangles the surface is hidden."""
        if not len(triangles):
            if self.mesh is not None:
                self.mesh.visible = False
            return
        self._shape = vertices, triangles
        data = glb(vertices, triangles, self._opacity)
        if self.mesh is None:
            self.mesh = self._scene.add_glb(self._name, data)
            return
        self.mesh.glb_data = data
        if not self.mesh.visible:
            self.mesh.visible = True

    def see_through(self, share: float) -> None:
        """As `Skin.see_through`."""
        self._opacity = 1.0 - share
        if self._shape is not None and self.mesh is not None and self.mesh.visible:
            self.show(*self._shape)


class BandedSkin:
    """A surface in a few colours, one mesh each. The vertices of a mesh move in place in the browser; one mesh with a
    colour for each vertex would be loaded anew, with its shader, at every update."""

    def __init__(self, scene: viser.SceneApi, name: str) -> None:
        self._parts = [PlainSkin(scene, f"{name}/{k}", color) for k, color in enumerate(BANDS)]

    def show(self, vertices: Array, triangles: NDArray[np.int32], bands: NDArray[np.int64]) -> None:
        """Draws vertices (n, 3) [m] and triangles (m, 3) with the number (m,) of their colour; hidden without any."""
        for k, part in enumerate(self._parts):
            part.show(vertices, triangles[bands == k])

    def see_through(self, share: float) -> None:
        """As `Skin.see_through`."""
        for part in self._parts:
            part.see_through(share)


def glb(vertices: Array, triangles: NDArray[np.int32], opacity: float) -> bytes:
    """A binary glTF file of a surface; vertices (n, 6): positions [m] and colours, 0 to 255."""
    import trimesh

    mesh = trimesh.Trimesh(
        vertices[:, :3], triangles, vertex_colors=np.rint(vertices[:, 3:6]).astype(np.uint8), process=False
    )

    def add_material(tree: dict[str, Any]) -> None:
        surface = {"metallicFactor": 0.0, "roughnessFactor": 0.7, "baseColorFactor": [1.0, 1.0, 1.0, opacity]}
        mode = "OPAQUE" if opacity > 0.99 else "BLEND"
        tree["materials"] = [{"pbrMetallicRoughness": surface, "doubleSided": True, "alphaMode": mode}]
        tree["meshes"][0]["primitives"][0]["material"] = 0

    scene = trimesh.Scene(mesh)
    made = trimesh.exchange.gltf.export_glb(scene, include_normals=True, tree_postprocessor=add_material)  # type: ignore[no-untyped-call]
    return bytes(made)
