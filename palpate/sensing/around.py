"""Simulated views from all around a body, for scans whose answer is known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.base.arrays import Array
from palpate.base.arrays.rigid import displaced
from palpate.sensing.depth_camera import Body, DepthErrors, SimulatedDepthCamera
from palpate.world.clouds import PointCloud

_GOLDEN = np.pi * (3.0 - np.sqrt(5.0))  # turn between neighbouring views [rad]
_DISTANCE = 2.2  # of the camera from the middle, in largest extents of the body


@dataclass(frozen=True)
class Views:
    """Clouds of a simulated camera."""

    clouds: tuple[PointCloud, ...]  #: in the camera's frames
    true: tuple[Array, ...]  #: poses (4, 4) of the camera in the body's frame [m]
    stated: tuple[Array, ...]  #: the same with errors, as a tracked camera would state them; the first one is true


def around(body: Body, n: int, noise: float, seed: int = 0, pose_error: tuple[float, float] = (3e-3, 1.0)) -> Views:
    """Views from n directions spread evenly over the sphere.

    Args:
        body: what there is to see.
        n: number of views.
        noise: standard deviation of the depth on the body's visible side [m].
        seed: seed of all errors.
        pose_error: standard deviations of the stated poses: positions [m] and angles [deg], on each axis.
    """
    low, high = body.vertices.min(axis=0), body.vertices.max(axis=0)
    middle, distance = 0.5 * (low + high), max(_DISTANCE * float((high - low).max()), 0.3)
    nearest = distance - 0.5 * float(np.median(high - low))  # about the depth of the visible side
    camera = SimulatedDepthCamera([body], errors=DepthErrors(noise=noise / nearest**2, step=0.0), seed=seed)
    rng = np.random.default_rng([seed, 1])
    height = 1.0 - 2.0 * (np.arange(n) + 0.5) / n
    clouds, true, stated = [], [], []
    for k, (z, angle) in enumerate(zip(height, _GOLDEN * np.arange(n), strict=True)):
        level = np.sqrt(1.0 - z * z)
        X = looking_at(middle + distance * np.array([level * np.cos(angle), level * np.sin(angle), z]), middle)
        clouds.append(PointCloud(camera.take(X, [np.eye(4)]).points, name=f"view {k + 1}"))
        true.append(X)
        error = np.r_[pose_error[0] * rng.normal(size=3), np.radians(pose_error[1]) * rng.normal(size=3)]
        about = displaced(np.eye(4), np.r_[np.zeros(3), error[3:]])
        about[:3, 3] = middle - about[:3, :3] @ middle + error[:3]
        stated.append(about @ X if k else X)
    return Views(tuple(clouds), tuple(true), tuple(stated))


def looking_at(p_WC: Array, target_W: Array) -> Array:
    """X_WC (4, 4) of a camera at p_WC (3,) that looks at a point (3,), with the world's z axis up in the image [m]."""
    z = target_W - p_WC
    z = z / np.linalg.norm(z)
    up = np.array([0.0, 0.0, 1.0]) if abs(z[2]) < 0.999 else np.array([0.0, 1.0, 0.0])
    x = np.cross(z, up)
    x = x / np.linalg.norm(x)
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = np.stack([x, np.cross(z, x), z], axis=1), p_WC
    return X
