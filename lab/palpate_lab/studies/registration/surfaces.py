"""Surfaces of the study: partial views of a liver, right and wrong ones, and a real pair of clouds."""

from __future__ import annotations

from functools import cache

import numpy as np

from palpate.base.arrays import Array
from palpate.base.arrays.rigid import displacement, exp, inverse, rigid, transform
from palpate.base.errors import MissingExtraError
from palpate.base.sweep.grid import Point
from palpate.world.registration import surface
from palpate.world.registration.cloud_files import averaged, read_cloud
from palpate.world.registration.clouds import sampled
from palpate.world.shapes.organs import gallbladder, organ
from palpate_lab import places
from palpate_lab.studies.registration.fiducials import pose
from palpate_lab.studies.registration.result import Real

VISIBLE, NOISE, OUTLIERS, POINTS = 0.3, 1e-3, 0.05, 1200
ANGLE, REACH = np.radians(30.0), 0.03  # largest error of the rough pose [rad], [m] per axis
CONVERGED = 2e-3  # rms error of the cloud's points in a right answer [m]
_VOXEL = 0.02  # [m]

KINDS = ("rough", "none", "far", "mirrored", "another")
"""Start near the truth; no start; a start 80 to 180 deg away; a mirrored view; a view of a gallbladder."""


@cache
def models() -> tuple[Array, Array, Array]:
    """The liver's surface (20,000 points), other samples of it and of a gallbladder (5,000 points each) [m]."""
    liver = organ(20_000)
    return sampled(*liver, 20_000), sampled(*liver, 5000, seed=1), sampled(*gallbladder(8000), 5000)


def view(rng: np.random.Generator, pool: Array) -> Array:
    """A partial view (1200, 3) with noise and outliers, in the frame of the surface [m]."""
    middle = pool[rng.integers(len(pool))]
    near = np.argsort(np.linalg.norm(pool - middle, axis=1))[: round(VISIBLE * len(pool))]
    p = pool[rng.choice(near, POINTS)] + NOISE * rng.normal(size=(POINTS, 3))
    far = rng.random(POINTS) < OUTLIERS
    p[far] = middle + rng.uniform(-0.06, 0.06, (int(far.sum()), 3))
    return np.asarray(p)


def rough(rng: np.random.Generator, seen: Array, X: Array, angles: tuple[float, float], reach: float) -> Array:
    """The pose X (4, 4) with an error about the middle of the view: an angle in these bounds [rad], a shift [m]."""
    axis = rng.normal(size=3)
    R = exp(axis / np.linalg.norm(axis) * rng.uniform(*angles))
    c = seen.mean(axis=0)
    return np.asarray(rigid(R, c - R @ c + rng.uniform(-reach, reach, 3)) @ X)


def judged(point: Point, seed: int) -> dict[str, float]:
    """Error and verdict of one registration of a view."""
    rng = np.random.default_rng(seed)
    fixed, pool, other = models()
    kind, X = KINDS[point["kind"]], pose(rng)
    seen = view(rng, other if kind == "another" else pool)
    start = rough(rng, seen, X, (-ANGLE, ANGLE), REACH)
    if kind == "far":
        start = rough(rng, seen, X, (np.radians(80.0), np.pi), 0.08)
    if kind == "mirrored":
        seen = seen * [1.0, 1.0, -1.0]
    m = transform(inverse(X), seen)
    found = surface(m, fixed, None if kind == "none" else start)
    moved = transform(found.X, m) - seen
    error = float(np.sqrt(np.square(moved).sum(axis=1).mean())) if kind not in ("mirrored", "another") else np.inf
    xi = displacement(found.X, X)
    predicted = surface_error(found.X, found.covariance, m)
    return {
        "error_m": min(error, 1.0), "wrong": float(error > CONVERGED), "trusted": float(found.trusted),
        "predicted_m": predicted, "nees": float(xi @ np.linalg.solve(found.covariance, xi)),
    }  # fmt: skip


def surface_error(X: Array, covariance: Array, m: Array) -> float:
    """Predicted rms error of the cloud's points (N, 3) [m]."""
    from palpate.world.registration.predict import target

    return float(np.sqrt(np.mean([target(X, covariance, p).tre ** 2 for p in m[::40]])))


def real() -> Real | None:
    """A Kinect pair registered here and by small_gicp alone; None if the data are absent."""
    paths = [places.data() / "clouds" / f"capture000{k}.pcd" for k in (2, 1)]
    if not all(path.is_file() for path in paths):
        return None
    m, f = (read_cloud(path) for path in paths)
    small = averaged(m, _VOXEL)
    found = surface(small, averaged(f, _VOXEL), np.eye(4), overlap=0.6)
    try:
        import small_gicp
    except ModuleNotFoundError as missing:
        raise MissingExtraError("small_gicp", "registration") from missing
    peer = small_gicp.align(
        f, m, np.eye(4), registration_type="GICP", downsampling_resolution=_VOXEL, max_correspondence_distance=0.1,
        max_iterations=100,
    )  # fmt: skip
    T = np.asarray(peer.T_target_source, dtype=np.float64)
    apart = np.square(transform(found.X, small) - transform(T, small)).sum(axis=1)
    angle = float(np.linalg.norm(displacement(T, found.X)[3:]))
    return {
        "points": len(small), "explained": found.explained, "rms_m": found.fre, "noise_m": found.fle,
        "trusted": found.trusted, "moved_m": float(np.sqrt(np.square(transform(found.X, small) - small).sum(1).mean())),
        "from_small_gicp_m": float(np.sqrt(apart.mean())), "from_small_gicp_rad": angle,
    }  # fmt: skip
