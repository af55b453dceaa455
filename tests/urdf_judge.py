"""A second reader of the same URDF, for tests: Pinocchio's collision geometry, and Coal called directly on it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest


class Judge:
    """Collision geometry of a URDF file as Pinocchio reads it.

    Args:
        urdf: the file.
        packages: folders that contain packages.
    """

    def __init__(self, urdf: Path, packages: list[str] | None = None) -> None:
        pin = pytest.importorskip("pinocchio")
        self._pin = pin
        self.model = pin.buildModelFromUrdf(str(urdf))
        self.geometry = pin.buildGeomFromUrdf(
            self.model, str(urdf), pin.GeometryType.COLLISION, None, packages or [str(urdf.parent)]
        )

    def links(self) -> list[str]:
        """Link of each part."""
        return [self.model.frames[one.parentFrame].name for one in self.geometry.geometryObjects]

    def placed(self, q: np.ndarray) -> list[np.ndarray]:
        """Poses (4, 4) in the base of all parts."""
        data, placed = self.model.createData(), self.geometry.createData()
        self._pin.updateGeometryPlacements(self.model, data, self.geometry, placed, q)
        return [X.homogeneous for X in placed.oMg]

    def to_sphere(self, q: np.ndarray, centre: np.ndarray, radius: float) -> float:
        """Distance of the nearest part from a sphere [m]."""
        import coal

        still, ball = coal.Transform3s(np.eye(3), centre), coal.Sphere(radius)
        return min(
            coal.distance(one.geometry, coal.Transform3s(X[:3, :3], X[:3, 3]), ball, still, coal.DistanceRequest(),
                          coal.DistanceResult())
            for one, X in zip(self.geometry.geometryObjects, self.placed(q), strict=True)
        )  # fmt: skip

    def touching(self, q: np.ndarray, pairs: set[frozenset[str]]) -> list[frozenset[str]]:
        """Those of some pairs of links that overlap."""
        import coal

        poses = [coal.Transform3s(X[:3, :3], X[:3, 3]) for X in self.placed(q)]
        parts, links, found = self.geometry.geometryObjects, self.links(), []
        for i in range(len(parts)):
            for j in range(i):
                pair = frozenset((links[i], links[j]))
                if pair in pairs and coal.collide(
                    parts[i].geometry, poses[i], parts[j].geometry, poses[j], coal.CollisionRequest(),
                    coal.CollisionResult(),
                ):  # fmt: skip
                    found.append(pair)
        return found
