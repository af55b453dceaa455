"""The collision geometry of an instrument: capsules around the parts of its links, or the links' own meshes."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from palpate.arm import Arm, models_folder
from palpate.arm.shapes import Visual
from palpate.arrays import Array
from palpate.errors import PlanningError
from palpate.mesh.headers import load_by_trimesh
from palpate.planning import geometry, shapes
from palpate.planning.kinematics import Kinematics, pose_of
from palpate.planning.shapes import Capsule

_SLACK = 1e-3  # primitives of one link share a capsule if it is thicker by no more than this [m]
_SMALL = 0.025  # a link of less than this is one capsule [m]
_SIZES = {"box": ("size",), "cylinder": ("radius", "length"), "sphere": ("radius",)}  # attributes in a URDF
_CHUNK = 0.02  # length of the pieces whose bounding spheres cull far objects [m]


@dataclass(frozen=True)
class Body:
    """One rigid part of an instrument, in the frame of the moving link that carries it."""

    name: str
    link: str  # link of the URDF
    carrier: int  # moving link of the kinematics; -1: the base
    capsule: Capsule  # contains the part
    mesh: tuple[Array, Array] | None = None  # vertices (v, 3) [m] and triangles (t, 3), used instead of the capsule


@dataclass(frozen=True)
class Attached:
    """An object that the jaws hold: it moves with a link.

    vertices (v, 3) [m] and triangles (t, 3) are in the frame of the link.
    """

    name: str
    link: str
    vertices: Array
    triangles: Array


@dataclass(frozen=True)
class Robot:
    """An arm at a place in the world, with its collision geometry.

    Args:
        name: name of the arm, e.g. PSM1.
        arm: its model.
        X_WB: pose (4, 4) of its base in W; for a PSM of its remote centre of motion [m].
        jaw: angle of the jaws while the arm moves [rad].
        attached: objects that it holds.
    """

    name: str
    arm: Arm
    X_WB: Array
    jaw: float = 0.0
    attached: tuple[Attached, ...] = field(default=())

    @cached_property
    def kinematics(self) -> Kinematics:
        """Poses of its links."""
        return Kinematics(self.arm, self.jaw)

    @cached_property
    def bodies(self) -> list[Body]:
        """Collision geometry, in the order of the links."""
        meshes = link_meshes(self.arm)
        found: list[Body] = []
        for link, (carrier, X) in self.kinematics.mount.items():
            if link in meshes:
                v, t = meshes[link]
                v = v @ X[:3, :3].T + X[:3, 3]
                found.append(Body(link, link, carrier, shapes.around(v), (v, t)))
                continue
            parts = [part for part in self.arm.visuals if part.link == link]
            groups = _capsules(parts, X)
            for i, capsule in enumerate(groups):
                found.append(Body(link if i == 0 else f"{link}.{i + 1}", link, carrier, capsule))
        for held in self.attached:
            carrier, X = self.kinematics.mount[held.link]
            v = held.vertices @ X[:3, :3].T + X[:3, 3]
            found.append(Body(held.name, held.link, carrier, shapes.around(v), (v, held.triangles)))
        return found

    @cached_property
    def solids(self) -> list[tuple[Any, Array]]:
        """Coal's geometry of each body, and its pose (4, 4) in the frame of the carrier."""
        found = []
        for body in self.bodies:
            solid, X = (geometry.mesh(*body.mesh), np.eye(4)) if body.mesh else geometry.capsule(body.capsule)
            found.append((solid.coal, X))
        return found

    @property
    def geometry(self) -> str:
        """What the collision checks use: "capsules", "meshes", or both."""
        kinds = {"meshes" if body.mesh else "capsules" for body in self.bodies}
        return " and ".join(sorted(kinds))

    @cached_property
    def carriers(self) -> NDArray[np.int64]:
        """Moving links (B,) that carry the bodies; -1: the base."""
        return np.array([body.carrier for body in self.bodies])

    @cached_property
    def radii(self) -> Array:
        """Radii (B,) of the capsules [m]."""
        return np.array([body.capsule.radius for body in self.bodies])

    @cached_property
    def _ends(self) -> Array:
        """Ends (B, 2, 3) of the capsules in the frames of their carriers [m]."""
        return np.array([[body.capsule.a, body.capsule.b] for body in self.bodies])

    @cached_property
    def _moving(self) -> NDArray[np.bool_]:
        """(B, m): True where a moving joint moves a body."""
        moves = np.vstack([self.kinematics.moves, np.zeros((1, len(self.kinematics.joints)), dtype=bool)])
        return moves[self.carriers]

    def chunks(self, bodies: NDArray[np.int64]) -> Chunks:
        """Pieces of the capsules of some bodies."""
        key = bodies.tobytes()
        if key not in self._chunks:
            rows = []
            for i, body in enumerate(bodies):
                capsule = self.bodies[body].capsule
                pieces = max(1, int(np.ceil(capsule.length / _CHUNK)))
                radius = capsule.radius + 0.5 * capsule.length / pieces
                rows += [(i, (k + 0.5) / pieces, radius) for k in range(pieces)]
            table = np.array(rows).reshape(-1, 3)
            index = table[:, 0].astype(np.int64)
            self._chunks[key] = Chunks(index, table[:, 1], table[:, 2], np.searchsorted(index, np.arange(len(bodies))))
        return self._chunks[key]

    @cached_property
    def _chunks(self) -> dict[bytes, Chunks]:
        return {}

    @cached_property
    def all_bodies(self) -> NDArray[np.int64]:
        """Indices (B,) of all bodies."""
        return np.arange(len(self.bodies))

    def placed(self, q: Array, bodies: NDArray[np.int64] | None = None) -> Placed:
        """Poses in W of some bodies (default: all) at q (K, n) [rad, m]."""
        bodies = self.all_bodies if bodies is None else bodies
        X = self.X_WB @ self.kinematics.poses(np.atleast_2d(q))
        X = np.concatenate([X, np.broadcast_to(self.X_WB, (len(X), 1, 4, 4))], axis=1)  # index -1: the base
        X_W = X[:, self.carriers[bodies]]
        ends_W = self._ends[bodies] @ X_W[..., :3, :3].swapaxes(-1, -2) + X_W[..., None, :3, 3]
        return Placed(self, bodies, X_W, ends_W, X[:, :-1])

    def reach(self, placed: Placed, rate: Array, half: Array) -> Array:
        """Bounds (K, B) of the motion of any point of each body while s moves by `half` (K,) from the placed poses.

        rate (n,): bound of |dq/ds| of each joint over the motion [rad, m]. A point at distance rho of the axis of
        joint j moves by at most rho |dq_j|; rho itself changes by at most the motion of the body in the frame of that
        joint, which only the joints behind it cause (after Schwarzer, Saha and Latombe, IEEE T-RO 21(3), 2005).
        """
        kin, moving = self.kinematics, self._moving[placed.bodies]
        axes = (placed.X_links[..., :3, :3] @ kin.own_axes[..., None])[..., 0]  # (K, m, 3)
        away = placed.ends_W[:, :, :, None] - placed.X_links[:, None, None, :, :3, 3]  # (K, B, 2, m, 3)
        along = np.einsum("kbemi,kmi->kbem", away, axes)
        square = np.einsum("kbemi,kbemi->kbem", away, away) - along**2
        rho = np.sqrt(np.maximum(square, 0.0).max(axis=2)) + self.radii[placed.bodies][:, None]  # (K, B, m)
        rho = np.where(kin.turns, rho, 0.0)
        step = np.where(moving, kin.rates(rate), 0.0) * half[:, None, None]  # (K, B, m)
        total = np.zeros(rho.shape[:2])
        for j in np.nonzero(step.any(axis=(0, 1)))[0][::-1]:
            total = total + step[:, :, j] * (rho[:, :, j] + total if kin.turns[j] else 1.0)
        return total


@dataclass(frozen=True)
class Chunks:
    """Bounding spheres of pieces of capsules, which cull far objects."""

    body: NDArray[np.int64]  # (C,) index of the piece's body
    along: Array  # (C,) place of the centre on the segment, 0..1
    radius: Array  # (C,) [m]
    first: NDArray[np.int64]  # (B,) first piece of each body


@dataclass(frozen=True)
class Placed:
    """Bodies of a robot in W, for K configurations."""

    robot: Robot
    bodies: NDArray[np.int64]  # (B,) indices of the bodies
    X_W: Array  # (K, B, 4, 4) poses of their carriers
    ends_W: Array  # (K, B, 2, 3) ends of the capsules [m]
    X_links: Array  # (K, m, 4, 4) poses of all moving links

    def spheres(self) -> tuple[Array, Chunks]:
        """Centres (K, C, 3) [m] of the bounding spheres of the bodies' pieces, and the pieces."""
        chunks = self.robot.chunks(self.bodies)
        a, b = self.ends_W[:, chunks.body, 0], self.ends_W[:, chunks.body, 1]
        return a + chunks.along[:, None] * (b - a), chunks


def _capsules(parts: list[Visual], X: Array) -> list[Capsule]:
    """Capsules around the parts of a link at X (4, 4): one around all parts of a small link, else one per part."""
    if not parts:
        return []
    points = np.concatenate([shapes.outline(p.shape, p.size, X @ p.X_link_visual) for p in parts])
    if len(parts) > 1 and np.ptp(points, axis=0).max() < _SMALL:
        return [shapes.around(points)]
    groups = shapes.merged([shapes.of_primitive(p.shape, p.size, X @ p.X_link_visual) for p in parts], _SLACK)
    return sorted(groups, key=lambda c: -c.length)


def link_meshes(arm: Arm, folder: Path | None = None) -> dict[str, tuple[Array, Array]]:
    """Vertices (v, 3) [m] and triangles (t, 3) of the links whose URDF names mesh files, in the frames of the links.

    A <collision> mesh is preferred to a <visual> one; boxes, cylinders and spheres beside a mesh belong to it. Files
    are looked for relative to `folder`, then to the models.

    Raises:
        PlanningError: a mesh file is not found.
    """
    found: dict[str, tuple[Array, Array]] = {}
    if "<mesh" not in arm.urdf:
        return found
    for link in ElementTree.fromstring(arm.urdf).findall("link"):
        name = link.get("name", "")
        kinds = [link.findall(kind) for kind in ("collision", "visual")]
        parts = next((parts for parts in kinds if any(x.find("geometry/mesh") is not None for x in parts)), [])
        vertices: list[Array] = []
        triangles: list[Array] = []
        for part in parts:
            read: Any = _read(part, name, folder)
            if read is None:
                continue
            origin = part.find("origin")
            X = pose_of(_numbers(origin, "xyz", "0 0 0"), _numbers(origin, "rpy", "0 0 0"))
            triangles.append(np.asarray(read.faces) + sum(map(len, vertices)))
            vertices.append(np.asarray(read.vertices) @ X[:3, :3].T + X[:3, 3])
        if vertices:
            found[name] = (np.concatenate(vertices), np.concatenate(triangles))
    return found


def _read(part: ElementTree.Element, link: str, folder: Path | None) -> Any:
    """A part of a link as a mesh: its file, or a solid around its primitive; None if it has neither."""
    import trimesh

    mesh = part.find("geometry/mesh")
    if mesh is None:
        shape = next((one for one in part.findall("geometry/*") if one.tag in _SIZES), None)
        if shape is None:
            return None
        size = np.concatenate([_numbers(shape, key, "0") for key in _SIZES[shape.tag]])
        return trimesh.convex.convex_hull(shapes.outline(shape.tag, tuple(size.tolist()), np.eye(4)))
    name = mesh.get("filename", "")
    file = _mesh_file(name, folder)
    if file is None:
        raise PlanningError(f"the mesh {name} of link {link} is not found", why="motions cannot be checked without it",
                            mend="give its full path in the URDF")  # fmt: skip
    try:
        read: Any = load_by_trimesh(file).process()
    except Exception as error:  # trimesh raises many types
        why = " ".join(str(error).split())[:300]
        raise PlanningError(f"the mesh of link {link} cannot be read", where=str(file), why=why) from None
    read.vertices = np.asarray(read.vertices) * _numbers(mesh, "scale", "1 1 1")
    return read


def _mesh_file(name: str, folder: Path | None) -> Path | None:
    """The file that a URDF names; None if it is not found."""
    plain = name.removeprefix("file://")
    if plain.startswith("package://"):
        plain = plain.removeprefix("package://").partition("/")[2]
    places = [Path(plain), models_folder() / plain] if folder is None else [folder / plain, models_folder() / plain]
    return next((place for place in places if place.is_file()), None)


def _numbers(element: ElementTree.Element | None, key: str, default: str) -> Array:
    text = default if element is None else element.get(key, default)
    return np.array([float(x) for x in text.split()])
