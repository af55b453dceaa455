"""The collision geometry of an instrument: what its URDF gives, or capsules around the drawn parts of its links."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from palpate.arm import Arm
from palpate.arm.shapes import Visual
from palpate.base.arrays import Array
from palpate.planning import geometry, links, shapes
from palpate.planning.geometry import Solid
from palpate.planning.kinematics import Kinematics
from palpate.planning.links import Part
from palpate.planning.shapes import Capsule

_SLACK = 1e-3  # primitives of one link share a capsule if it is thicker by no more than this [m]
_SMALL = 0.025  # a link of less than this is one capsule [m]
_JAW_STEP = 0.05  # largest step between the angles of jaws that move [rad]
_CHUNK = 0.02  # length of the pieces whose bounding spheres cull far objects [m]


@dataclass(frozen=True)
class Body:
    """One rigid part of an instrument, in the frame of the moving link that carries it."""

    name: str
    link: str  # link of the URDF
    carrier: int  # moving link of the kinematics; -1: the base
    capsule: Capsule  # contains the part
    mesh: tuple[Array, Array] | None = None  # vertices (v, 3) [m] and triangles (t, 3), used instead of the capsule
    part: Part | None = None  # of the URDF, used instead of the capsule: its mesh, or the primitive itself
    X_part: Array = field(default_factory=lambda: np.eye(4))  # (4, 4) pose of a primitive

    @property
    def kind(self) -> str:
        """What the collision checks use: meshes, primitives or capsules."""
        return "meshes" if self.mesh is not None else "capsules" if self.part is None else "primitives"

    def solid(self) -> tuple[Solid, Array]:
        """Coal's geometry and its pose (4, 4) in the frame of the carrier."""
        if self.mesh is not None:
            return geometry.mesh(*self.mesh), np.eye(4)
        if self.part is None:
            return geometry.capsule(self.capsule)
        return geometry.primitive(self.part.shape, self.part.size), self.X_part


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
        jaws: smallest and largest angle of the jaws while the arm moves; `jaw` alone when left out [rad].
    """

    name: str
    arm: Arm
    X_WB: Array
    jaw: float = 0.0
    attached: tuple[Attached, ...] = field(default=())
    jaws: tuple[float, float] | None = None

    @property
    def span(self) -> tuple[float, float]:
        """Smallest and largest angle of the jaws [rad]."""
        return self.jaws or (self.jaw, self.jaw)

    def with_jaws(self, low: float, high: float) -> Robot:
        """The same robot, with its jaws at any angle from `low` to `high` [rad]."""
        return replace(self, jaw=low, jaws=(low, high) if high > low else None)

    @cached_property
    def kinematics(self) -> Kinematics:
        """Poses of its links."""
        return Kinematics(self.arm, self.jaw)

    @cached_property
    def bodies(self) -> list[Body]:
        """Collision geometry, in the order of the links."""
        given = links.parts(self.arm)
        drawn = self.arm.drawn if given else self.arm.visuals
        drawn = [part for part in drawn if part.link not in given]
        found: list[Body] = []
        for link, (carrier, X) in self.kinematics.mount.items():
            made = [_of_part(part, carrier, X) for part in given.get(link, [])]
            for capsule in _capsules([part for part in drawn if part.link == link], X):
                made.append(Body(link, link, carrier, capsule))
            if self._swept(link):
                parts: list[Part | Visual] = [*given.get(link, []), *(part for part in drawn if part.link == link)]
                made = [self._sweep(link, link, [_points(part) for part in parts])] if parts else []
            found += [replace(body, name=link if i == 0 else f"{link}.{i + 1}") for i, body in enumerate(made)]
        for held in self.attached:
            carrier, X = self.kinematics.mount[held.link]
            if self._swept(held.link):
                found.append(self._sweep(held.name, held.link, [held.vertices]))
                continue
            v = held.vertices @ X[:3, :3].T + X[:3, 3]
            found.append(Body(held.name, held.link, carrier, shapes.around(v), (v, held.triangles)))
        return found

    @cached_property
    def _opened(self) -> list[Kinematics]:
        """The kinematics at all angles of the jaws, from the smallest to the largest."""
        low, high = self.span
        return [Kinematics(self.arm, a) for a in np.linspace(low, high, 1 + int(np.ceil((high - low) / _JAW_STEP)))]

    def _swept(self, link: str) -> bool:
        """True if the link moves within the range of the jaws."""
        return bool(np.abs(self._opened[-1].mount[link][1] - self._opened[0].mount[link][1]).max() > 1e-12)

    def _sweep(self, name: str, link: str, parts: list[Array]) -> Body:
        """The convex body that a link fills while the jaws move through their range.

        parts: points (k, 3) of the link whose convex hull contains each part [m].
        """
        import trimesh

        points = np.concatenate(parts)
        mounts = [kinematics.mount[link][1] for kinematics in self._opened]
        places = np.array([points @ X[:3, :3].T + X[:3, 3] for X in mounts])
        chord = np.linalg.norm(np.diff(places, axis=0), axis=-1).max()
        sagitta = 0.25 * _JAW_STEP * chord  # more than that of the arcs between two places
        corners = sagitta * np.array(list(product((-1.0, 1.0), repeat=3)))
        hull = trimesh.convex.convex_hull((places.reshape(-1, 1, 3) + corners).reshape(-1, 3))
        v = np.asarray(hull.vertices, dtype=np.float64)
        return Body(name, link, self.kinematics.mount[link][0], shapes.around(v), (v, np.asarray(hull.faces)))

    @cached_property
    def solids(self) -> list[tuple[Any, Array]]:
        """Coal's geometry of each body, and its pose (4, 4) in the frame of the carrier."""
        made = [body.solid() for body in self.bodies]
        return [(solid.coal, X) for solid, X in made]

    @property
    def geometry(self) -> str:
        """What the collision checks use: "capsules", "meshes", "primitives", or several of them."""
        kinds = sorted({body.kind for body in self.bodies})
        return " and ".join([", ".join(kinds[:-1]), kinds[-1]] if len(kinds) > 1 else kinds)

    @cached_property
    def notes(self) -> list[str]:
        """Remarks for the user: links without a body, and bodies that the URDF does not describe."""
        if links.bare(self.arm):
            return [f"the URDF of {self.arm.name} describes no bodies: thin sticks between its joints are checked"]
        have = {body.link for body in self.bodies}
        mount = self.kinematics.mount
        filled = {mount[link][0] for link in have}
        heavy = links.massive(self.arm)
        without = [name for name, (k, _) in mount.items() if name not in have and (k not in filled or name in heavy)]
        if not without:
            return []
        names = f"link {without[0]} has" if len(without) == 1 else f"links {', '.join(without)} have"
        return [f"{names} no body in the URDF of {self.arm.name} (no <collision>, no <visual>): not checked"]

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
    def probes(self) -> Probes:
        """Points of all bodies, one at least in each connected part."""
        rows: list[tuple[int, Array, float]] = []
        for i, body in enumerate(self.bodies):
            if body.mesh is not None:
                _, first = np.unique(_components(body.mesh), return_index=True)
                rows += [(i, p, 0.0) for p in body.mesh[0][first]]
                continue
            thick = body.capsule.radius
            if body.part is not None:
                thick = min(body.part.size if body.part.shape != "box" else 0.5 * np.array(body.part.size))
            pieces = max(1, int(np.ceil(body.capsule.length / _CHUNK)))
            along = ((np.arange(pieces) + 0.5) / pieces)[:, None]
            rows += [(i, p, thick) for p in body.capsule.a + along * (body.capsule.b - body.capsule.a)]
        body_of, points, depth = zip(*rows, strict=True) if rows else ((), (), ())
        return Probes(np.array(body_of, dtype=np.int64), np.array(points).reshape(-1, 3), np.array(depth))

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
        return self._reach(placed, np.arange(len(placed.bodies)), self._moving[placed.bodies], rate, half)

    def reach_between(self, placed: Placed, pairs: NDArray[np.int64], rate: Array, half: Array) -> Array:
        """Bounds (K, P) of the motion of any point of one body of a pair in the frame of the other; else as `reach`.

        pairs (P, 2): places of the bodies in `placed`. Joints that move both bodies do not move one against the other.
        """
        one, two = pairs.T
        moving = self._moving[placed.bodies]
        mine = self._reach(placed, one, moving[one] & ~moving[two], rate, half)
        return mine + self._reach(placed, two, moving[two] & ~moving[one], rate, half)

    def _reach(
        self, placed: Placed, places: NDArray[np.int64], moving: NDArray[np.bool_], rate: Array, half: Array
    ) -> Array:
        """As `reach`, for bodies at some places (R,) of `placed`, each moved by its own joints (R, m)."""
        kin = self.kinematics
        axes = (placed.X_links[..., :3, :3] @ kin.own_axes[..., None])[..., 0]  # (K, m, 3)
        away = placed.ends_W[:, places][:, :, :, None] - placed.X_links[:, None, None, :, :3, 3]  # (K, R, 2, m, 3)
        along = np.einsum("kbemi,kmi->kbem", away, axes)
        square = np.einsum("kbemi,kbemi->kbem", away, away) - along**2
        rho = np.sqrt(np.maximum(square, 0.0).max(axis=2)) + self.radii[placed.bodies[places]][:, None]  # (K, R, m)
        rho = np.where(kin.turns, rho, 0.0)
        step = np.where(moving, kin.rates(rate), 0.0) * half[:, None, None]  # (K, R, m)
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
class Probes:
    """Points of bodies that tell whether a body lies inside of an obstacle whose surface it does not cross."""

    body: NDArray[np.int64]  # (P,) index of the body
    points: Array  # (P, 3) in the frame of its carrier [m]
    depth: Array  # (P,) depth of the point below the surface of its body, at least [m]


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


def _components(mesh: tuple[Array, Array]) -> NDArray[np.int64]:
    """Number of the connected part to which each vertex (v,) of a mesh belongs."""
    vertices, triangles = mesh
    one, two = triangles[:, [0, 1, 2]].ravel(), triangles[:, [1, 2, 0]].ravel()
    joined = coo_array((np.ones(len(one)), (one, two)), shape=(len(vertices), len(vertices)))
    return np.asarray(connected_components(joined, directed=False)[1], dtype=np.int64)


def _points(part: Part | Visual) -> Array:
    """Points (k, 3) of its link whose convex hull contains a part [m]."""
    if isinstance(part, Visual):
        return shapes.outline(part.shape, part.size, part.X_link_visual)
    if part.vertices is not None:
        return np.asarray(part.vertices @ part.X_link_part[:3, :3].T + part.X_link_part[:3, 3])
    return shapes.outline(part.shape, part.size, part.X_link_part)


def _of_part(part: Part, carrier: int, X: Array) -> Body:
    """A part of the URDF as a body; X (4, 4): pose of its link in the carrier."""
    X = X @ part.X_link_part
    if part.vertices is None or part.triangles is None:
        return Body(part.link, part.link, carrier, shapes.of_primitive(part.shape, part.size, X), None, part, X)
    v = part.vertices @ X[:3, :3].T + X[:3, 3]
    return Body(part.link, part.link, carrier, shapes.around(v), (v, part.triangles), part)


def _capsules(parts: list[Visual], X: Array) -> list[Capsule]:
    """Capsules around the parts of a link at X (4, 4): one around all parts of a small link, else one per part."""
    if not parts:
        return []
    points = np.concatenate([shapes.outline(p.shape, p.size, X @ p.X_link_visual) for p in parts])
    if len(parts) > 1 and np.ptp(points, axis=0).max() < _SMALL:
        return [shapes.around(points)]
    groups = shapes.merged([shapes.of_primitive(p.shape, p.size, X @ p.X_link_visual) for p in parts], _SLACK)
    return sorted(groups, key=lambda c: -c.length)
