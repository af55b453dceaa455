"""Shapes of bodies: primitives of the engine, contact spheres, and triangles for pictures."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.base.arrays import Array
from palpate.world.bodies.sections import BodySection, PartSection

_MOST_PIECES = 64  # of a mesh, for example of one that was divided into convex pieces
THREAD = (70, 70, 160)
"""Colour of threads."""


@dataclass(frozen=True)
class Primitive:
    """A convex shape at a pose X_OS (4, 4) in the body's frame.

    kind, size: as in the engine: box (half lengths), sphere (radius), cylinder and capsule (radius, half length), mesh.
    """

    kind: str
    size: tuple[float, ...]
    X_OS: Array
    color: tuple[int, int, int]
    vertices: Array | None = None
    faces: Array | None = None

    @property
    def volume(self) -> float:
        """Volume [m^3]; of a mesh that of its surface, which is closed."""
        if self.kind == "mesh":
            assert self.vertices is not None
            assert self.faces is not None
            a, b, c = np.moveaxis(self.vertices[self.faces], 1, 0)
            return abs(float(np.sum(a * np.cross(b, c)))) / 6.0
        if self.kind == "box":
            return 8.0 * float(np.prod(self.size))
        r = self.size[0]
        ball = 4.0 / 3.0 * np.pi * r**3
        along = 2.0 * np.pi * r**2 * (self.size[1] if len(self.size) > 1 else 0.0)
        return float(along + (0.0 if self.kind == "cylinder" else ball))


@dataclass(frozen=True)
class Solid:
    """A body, or a link of a thread, as pictures and records show it."""

    name: str
    shapes: list[Primitive]
    X_WO: Array
    """(4, 4) pose in W at the start [m]."""
    moves: bool


def solids(bodies: Sequence[BodySection], path: Callable[[str], Path]) -> list[Solid]:
    """All bodies and the links of their threads, in the order of the engine; `path` resolves the path of a mesh.

    Raises:
        MeshError: a mesh cannot be read.
    """
    found: dict[str, Solid] = {}
    for body in bodies:
        X = body.pose.matrix()
        X_WO = X if body.joint is None else found[body.joint.to].X_WO @ X
        found[body.name] = Solid(body.name, primitives(body, path), X_WO, moves(bodies, body))
        found |= {link.name: link for link in _links(body, X_WO)}
    return list(found.values())


def moves(bodies: Sequence[BodySection], body: BodySection) -> bool:
    """True for a body that moves: neither fixed nor welded to one that is."""
    if body.joint is not None and body.joint.kind == "weld":
        return moves(bodies, next(one for one in bodies if one.name == body.joint.to))
    return not body.fixed


def _links(body: BodySection, X_WO: Array) -> list[Solid]:
    chain = body.thread
    if chain is None:
        return []
    each = chain.length / chain.links
    middle = np.eye(4)
    middle[2, 3] = 0.5 * each
    shape = Primitive("capsule", (chain.radius, 0.5 * each), middle, THREAD)
    X = [X_WO.copy() for _ in range(chain.links)]
    for k, one in enumerate(X):
        one[:3, 3] += k * each * X_WO[:3, 2]
    return [Solid(f"{body.name}/thread{k}", [shape], one, True) for k, one in enumerate(X)]


def primitives(body: BodySection, path: Callable[[str], Path]) -> list[Primitive]:
    """The primitives of a body; `path` resolves the path of a mesh.

    Raises:
        MeshError: a mesh cannot be read.
    """
    found: list[Primitive] = []
    for part in body.parts:
        found += _of_part(part, part.color or body.color, path)
    return found


def _of_part(part: PartSection, color: tuple[int, int, int], path: Callable[[str], Path]) -> list[Primitive]:
    X = part.pose.matrix()
    if part.box is not None:
        return [Primitive("box", tuple(0.5 * x for x in part.box), X, color)]
    if part.sphere is not None:
        return [Primitive("sphere", (part.sphere,), X, color)]
    for kind in ("cylinder", "capsule"):
        shape = getattr(part, kind)
        if shape is not None:
            return [Primitive(kind, (shape.radius, 0.5 * shape.length), X, color)]
    if part.ring is not None:
        ring = part.ring
        angles = np.linspace(0.0, np.radians(ring.arc_deg), ring.segments + 1)
        points = ring.radius * np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)], axis=1)
        return _capsules(points, 0.5 * ring.thickness, X, color)
    if part.wire is not None:
        return _capsules(np.array(part.wire.points), part.wire.radius, X, color)
    from palpate.world.mesh import Mesh

    mesh = Mesh.load(path(str(part.mesh)), part.unit)
    return [Primitive("mesh", (), X, color, *piece) for piece in _pieces(mesh.vertices, mesh.triangles)]


def _pieces(vertices: Array, faces: NDArray[Any]) -> list[tuple[Array, NDArray[Any]]]:
    """The pieces of a mesh that are not joined, each with its own hull; the whole mesh if some are flat or too many."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    edges = np.concatenate([faces[:, :2], faces[:, 1:]])
    graph = coo_matrix((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(len(vertices),) * 2)
    count, label = connected_components(graph, directed=False)
    if not 1 < count <= _MOST_PIECES:
        return [(np.asarray(vertices), np.asarray(faces))]
    found = []
    for k in range(count):
        corners, index = np.unique(faces[label[faces[:, 0]] == k], return_inverse=True)
        points = np.asarray(vertices)[corners]
        if len(points) < 4 or np.linalg.matrix_rank(points - points[0], tol=1e-6) < 3:
            return [(np.asarray(vertices), np.asarray(faces))]
        found.append((points, index.reshape(-1, 3)))
    return found


def _capsules(points: Array, radius: float, X: Array, color: tuple[int, int, int]) -> list[Primitive]:
    return [Primitive("capsule", (radius, 0.5 * float(np.linalg.norm(b - a))), X @ _between(a, b), color)
            for a, b in pairwise(points)]  # fmt: skip


def _between(a: Array, b: Array) -> Array:
    """The frame in the middle of a and b whose z points to b."""
    z = (b - a) / np.linalg.norm(b - a)
    x = np.cross([0.0, 1.0, 0.0] if abs(z[1]) < 0.9 else [1.0, 0.0, 0.0], z)
    x /= np.linalg.norm(x)
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = np.stack([x, np.cross(z, x), z], axis=1), 0.5 * (a + b)
    return X


def spheres(shapes: list[Primitive], most: int) -> list[tuple[Array, float]]:
    """Contact spheres (centre in the body's frame (3,), radius) inside of the shapes, at most `most`.

    A box has one in each corner, a cylinder or capsule one at each end.
    """
    found: list[tuple[Array, float]] = []
    for s in shapes:
        if s.kind == "mesh":
            assert s.vertices is not None
            low, high = s.vertices.min(axis=0), s.vertices.max(axis=0)
            middle, half = 0.5 * (low + high), 0.5 * (high - low)
        else:
            middle, half = np.zeros(3), np.array(s.size if s.kind == "box" else (0.0, 0.0, 0.0))
        if s.kind in ("box", "mesh"):
            r = 0.3 * float(half.min())
            corners = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).T.reshape(-1, 3)
            local = [(middle + corner * (half - r), r) for corner in corners]
        elif s.kind == "sphere":
            local = [(middle, s.size[0])]
        else:
            local = [(np.array([0.0, 0.0, sign * s.size[1]]), s.size[0]) for sign in (-1.0, 1.0)]
        found += [(s.X_OS[:3, :3] @ p + s.X_OS[:3, 3], r) for p, r in local]
    if len(found) > most:  # spread over the body: the farthest from those already taken
        points = np.array([p for p, _ in found])
        kept = [int(np.argmax(np.linalg.norm(points - points.mean(axis=0), axis=1)))]
        while len(kept) < most:
            away = np.linalg.norm(points[:, None] - points[kept][None], axis=2).min(axis=1)
            kept.append(int(np.argmax(away)))
        found = [found[k] for k in kept]
    return found


def by_color(shapes: list[Primitive]) -> dict[tuple[int, int, int], list[Primitive]]:
    """The shapes of each colour."""
    return {color: [one for one in shapes if one.color == color] for color in sorted({s.color for s in shapes})}


def triangles(shapes: list[Primitive]) -> tuple[Array, Array, Array]:
    """Vertices (n, 3) in the body's frame [m], triangles (m, 3) and colours of the vertices (n, 3), for pictures."""
    vertices, faces, colors, count = [], [], [], 0
    for s in shapes:
        if s.kind == "mesh":
            assert s.vertices is not None
            assert s.faces is not None
            v, f = s.vertices, s.faces
        else:
            made = _triangulated(s)
            v, f = np.asarray(made.vertices), np.asarray(made.faces)
        vertices.append(v @ s.X_OS[:3, :3].T + s.X_OS[:3, 3])
        faces.append(f + count)
        colors.append(np.tile(np.array(s.color), (len(v), 1)))
        count += len(v)
    return np.concatenate(vertices), np.concatenate(faces).astype(np.int32), np.concatenate(colors)


def _triangulated(s: Primitive) -> Any:
    import trimesh

    if s.kind == "box":
        return trimesh.creation.box(2.0 * np.array(s.size))
    if s.kind == "sphere":
        return trimesh.creation.icosphere(2, s.size[0])
    if s.kind == "cylinder":
        return trimesh.creation.cylinder(s.size[0], 2.0 * s.size[1], sections=24)
    mesh = trimesh.creation.capsule(2.0 * s.size[1], s.size[0], count=[8, 8])
    mesh.apply_translation(-mesh.bounds.mean(axis=0))
    return mesh
