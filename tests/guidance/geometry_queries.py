"""Queries of geometries in the tests, and conditions that hold for every result."""

from __future__ import annotations

from typing import Any

import numpy as np

from palpate import _guidance


def poses(points):
    X = np.tile(np.eye(4), (len(points), 1, 1))
    X[:, :3, 3] = points
    return X


def query_points(geometry: _guidance.Geometry, points: Any, t: float = 0.0) -> dict[str, Any]:
    """Query a geometry for tools at points (n, 3) [m] in W, without rotation, at time t [s]."""
    points = np.asarray(points, float)
    return geometry.query(poses(points), np.full(len(points), float(t)))


def slope(geometry: _guidance.Geometry, points: Any, h: float = 1e-6, t: float = 0.0) -> Any:
    """(n, 3) gradient of the distance by central differences."""
    after, before = ([query_points(geometry, points + s * e, t)["distance"] for e in np.eye(3)] for s in (h, -h))
    return (np.array(after) - np.array(before)).T / (2 * h)


def assert_sound(q: dict[str, Any]) -> None:
    """Check that a result is finite, with unit normals and with rotations as bases whose last column is the normal."""
    assert all(np.isfinite(values).all() for values in q.values())
    np.testing.assert_allclose(np.linalg.norm(q["normal"], axis=1), 1.0, atol=1e-9)
    for R in (q["basis"], q["attitude"]):
        np.testing.assert_allclose(R @ R.transpose(0, 2, 1), np.tile(np.eye(3), (len(R), 1, 1)), atol=1e-9)
        np.testing.assert_allclose(np.linalg.det(R), 1.0, atol=1e-9)
    np.testing.assert_allclose(q["basis"][:, :, 2], q["normal"], atol=1e-12)
