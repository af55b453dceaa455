"""What an instrument must not touch: the objects of a scene, other instruments, and the version of both."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from palpate.base.arrays import Array
from palpate.base.errors import SceneError
from palpate.planning import geometry
from palpate.planning.geometry import Solid
from palpate.planning.robot import Robot

if TYPE_CHECKING:
    from palpate.world.mesh import Mesh
    from palpate.world.surfaces.surface import Surface

Distance = Callable[[Array], Array]
"""Signed distances (k,) [m] of points (k, 3) [m], negative inside."""


@dataclass(frozen=True)
class Obstacle:
    """One rigid object at a place in W."""

    name: str
    solid: Solid
    X_WO: Array  # (4, 4)
    inside: Distance | None = None
    """Signed distance in the object's frame; None for surfaces without an inside, and for solids of Coal."""
    note: str = ""
    """Remark for the user, e.g. that an open mesh is treated as a surface."""

    @cached_property
    def transform(self) -> Any:
        """Pose in W for Coal."""
        return geometry.transform(self.X_WO[:3, :3], self.X_WO[:3, 3])

    @cached_property
    def bounds_W(self) -> Array:
        """Box (2, 3) around it in W, with its inflation [m]."""
        low, high = self.solid.bounds
        corners = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
        corners = corners @ self.X_WO[:3, :3].T + self.X_WO[:3, 3]
        return np.stack([corners.min(axis=0) - self.solid.inflation, corners.max(axis=0) + self.solid.inflation])

    @cached_property
    def digest(self) -> str:
        """Text that changes with the geometry."""
        shape = self.solid.coal
        data = [self.solid.bounds.tobytes(), str(type(shape)).encode()]
        if hasattr(shape, "vertices"):
            data.append(np.ascontiguousarray(shape.vertices(), dtype=np.float64).tobytes())
        return hashlib.sha256(b"".join(data)).hexdigest()[:16]


def obstacle(name: str, surface: Mesh | Surface, X_WO: Array) -> Obstacle:
    """An object of a scene; an open mesh has no inside and is treated as a surface."""
    from palpate.world.mesh import Mesh

    solid, note = geometry.of_surface(surface), ""
    inside: Distance | None = None
    if isinstance(surface, Mesh) and not surface.report.watertight:
        note = f"{name} is not a closed volume: it is treated as a surface"
    elif solid.kind in ("mesh", "triangulated"):
        inside = lambda points: surface.core.nearest(np.ascontiguousarray(points))[0]  # noqa: E731 - bound to this surface
    if solid.kind in ("triangulated", "cloud"):
        note = f"{name} is a {solid.kind} surface, thicker by {1e3 * solid.inflation:.2g} mm"
    return Obstacle(name, solid, X_WO, inside, note)


def instrument(robot: Robot, q: Array) -> list[Obstacle]:
    """Another instrument that stays at q (n,): one obstacle per body, named ARM/BODY."""
    placed = robot.placed(q[None])
    found = []
    for i, body in enumerate(robot.bodies):
        solid, X = body.solid()
        note = "; ".join(robot.notes) if i == 0 else ""
        found.append(Obstacle(f"{robot.name}/{body.name}", solid, placed.X_W[0, i] @ X, note=note))
    return found


@dataclass(frozen=True)
class World:
    """The obstacles at one moment. A change makes a new world with another version."""

    obstacles: tuple[Obstacle, ...] = ()
    allowed: frozenset[frozenset[str]] = field(default_factory=frozenset)
    """Pairs of names that may touch: of a body or its link, and of an obstacle."""

    @cached_property
    def version(self) -> str:
        """Text that changes whenever an obstacle is added, removed, moved or reshaped."""
        parts = [f"{o.name} {o.digest} {np.round(o.X_WO, 9).tolist()}" for o in self.obstacles]
        parts += sorted(" ".join(sorted(pair)) for pair in self.allowed)
        return hashlib.sha256("\n".join(parts).encode()).hexdigest()[:16]

    @property
    def notes(self) -> list[str]:
        """Remarks on the obstacles."""
        return [o.note for o in self.obstacles if o.note]

    def with_added(self, obstacles: Iterable[Obstacle]) -> World:
        """The world with further obstacles."""
        return replace(self, obstacles=(*self.obstacles, *obstacles))

    def without(self, name: str) -> World:
        """The world without one obstacle, or without an instrument of this name.

        Raises:
            SceneError: there is no such obstacle.
        """
        self._require(name)
        return replace(self, obstacles=tuple(o for o in self.obstacles if not _is(o.name, name)))

    def moved(self, name: str, X_WO: Array) -> World:
        """The world with one obstacle at another pose X_WO (4, 4).

        Raises:
            SceneError: there is no such obstacle.
        """
        self._require(name)
        moved = tuple(replace(o, X_WO=np.array(X_WO)) if o.name == name else o for o in self.obstacles)
        return replace(self, obstacles=moved)

    def replaced(self, obstacle: Obstacle) -> World:
        """The world with another geometry for the obstacle of the same name, e.g. the newest cloud of a sensor."""
        self._require(obstacle.name)
        return replace(self, obstacles=tuple(obstacle if o.name == obstacle.name else o for o in self.obstacles))

    def _require(self, name: str) -> None:
        if not any(_is(o.name, name) for o in self.obstacles):
            names = ", ".join(dict.fromkeys(o.name.partition("/")[0] for o in self.obstacles)) or "none"
            raise SceneError(f"there is no obstacle {name!r}", mend=f"the obstacles are {names}")


def _is(full: str, name: str) -> bool:
    return full == name or full.startswith(f"{name}/")
