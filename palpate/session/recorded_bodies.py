"""The markers of rigid bodies in a record (`palpate.record.extra.Marker`)."""

from __future__ import annotations

from palpate.base.arrays import Array
from palpate.record.extra import Marker
from palpate.record.snapshots import BODY
from palpate.world.bodies.shapes import Primitive, Solid, by_color, triangles


def markers(solid: Solid) -> list[Marker]:
    """The shapes of a body: primitives where a viewer has them, else triangles of each colour."""
    frame, found = BODY + solid.name, []
    for color, shapes in by_color(solid.shapes).items():
        red, green, blue = (c / 255.0 for c in color)
        rgba = (red, green, blue, 1.0)
        rest = [shape for shape in shapes if shape.kind == "mesh"]
        for shape in shapes:
            found += [Marker(frame, solid.name, kind, rgba, X, scale) for kind, X, scale in _parts(shape)]
        if rest:
            vertices, faces, _ = triangles(rest)
            found.append(Marker(frame, solid.name, 11, rgba, points=vertices[faces.reshape(-1)]))
    return found


def _parts(shape: Primitive) -> list[tuple[int, Array, tuple[float, float, float]]]:
    """Kind, pose in the body and lengths of the markers of a shape; none for a mesh."""
    if shape.kind == "mesh":
        return []
    if shape.kind == "box":
        x, y, z = (2.0 * half for half in shape.size)
        return [(1, shape.X_OS, (x, y, z))]
    width = 2.0 * shape.size[0]
    found = [] if shape.kind == "sphere" else [(3, shape.X_OS, (width, width, 2.0 * shape.size[1]))]
    ends = {"sphere": (0.0,), "capsule": (-shape.size[-1], shape.size[-1])}.get(shape.kind, ())
    for z in ends:
        X = shape.X_OS.copy()
        X[:3, 3] += z * X[:3, 2]
        found.append((2, X, (width, width, width)))
    return found
