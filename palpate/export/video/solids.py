"""The rigid bodies of a scene in a picture: a drawn body for each of their colours."""

from __future__ import annotations

from collections.abc import Mapping

from palpate.base.arrays import Array, so3
from palpate.export.video.drawing import Body, Canvas
from palpate.scene import held
from palpate.scene.scene import Scene
from palpate.world.bodies.shapes import by_color, triangles


class SolidBodies:
    """The bodies of a scene and the links of their threads, at their start.

    Args:
        canvas: where to draw.
        scene: the scene.

    Raises:
        SceneError, MeshError: a mesh cannot be read.
    """

    def __init__(self, canvas: Canvas, scene: Scene) -> None:
        self.bodies: dict[str, list[Body]] = {}
        for solid in held.solids(scene):
            for color, shapes in by_color(solid.shapes).items():
                vertices, faces, _ = triangles(shapes)
                body = canvas.add(vertices, faces, color, 0.15, None if solid.moves else solid.X_WO)
                body.X_WB = solid.X_WO
                self.bodies.setdefault(solid.name, []).append(body)

    def move(self, places: Mapping[str, Array]) -> None:
        """Move bodies, by name, to a position [m] and a quaternion w x y z (7,) in W."""
        for name, place in places.items():
            for body in self.bodies.get(name, ()):
                body.X_WB = so3.pose(place[:3], place[3:])
