"""Fiducials of the study: predicted and simulated target error, correspondence, wrong markers."""

from __future__ import annotations

import numpy as np

from palpate.base.arrays import Array
from palpate.base.arrays.rigid import exp, rigid, transform
from palpate.base.errors import RegistrationError
from palpate.base.sweep.grid import Point
from palpate.world.registration import fit, points
from palpate.world.registration.noise import covariances
from palpate_lab.studies.registration.references import fitzpatrick, horn

COUNT, FLE, AWAY, WRONG = 8, 0.25e-3, 0.1, 3e-3  # markers; rms error, distance of the target, error of a marker [m]
_CUBE, _CLOSEST = 0.1, 0.015  # edge of the cube of markers, smallest distance between two [m]
_DRAWS = 500  # simulated registrations per layout
_STRETCH = (0.3, 0.6, 1.6)  # standard deviations along the axes over those of isotropic errors


def layout(rng: np.random.Generator) -> Array:
    """Markers (8, 3) in a cube [m]."""
    while True:
        p = rng.uniform(-_CUBE / 2, _CUBE / 2, (COUNT, 3))
        if (np.linalg.norm(p[:, None] - p[None], axis=2) + np.eye(COUNT)).min() > _CLOSEST:
            return np.asarray(p)


def pose(rng: np.random.Generator) -> Array:
    """A pose (4, 4): any rotation, up to 50 mm along each axis."""
    q = rng.normal(size=4)
    w, v = q[0] / np.linalg.norm(q), q[1:] / np.linalg.norm(q)
    angle = 2.0 * np.arctan2(np.linalg.norm(v), w)
    return rigid(exp(angle * v / np.linalg.norm(v)), rng.uniform(-0.05, 0.05, 3))


def predicted(point: Point, seed: int) -> dict[str, float]:
    """Predicted and simulated target error of one layout; isotropic or anisotropic errors of the same rms length.

    The closed form exists for isotropic errors alone; otherwise `closed_form_m` is 0.
    """
    rng = np.random.default_rng(seed)
    m, X = layout(rng), pose(rng)
    direction = rng.normal(size=3)
    goal = m.mean(axis=0) + AWAY * direction / np.linalg.norm(direction)
    sigma = FLE / np.sqrt(3.0) * np.ones(3)
    if point["anisotropic"]:
        sigma = FLE * np.array(_STRETCH) / np.linalg.norm(_STRETCH)
    S, truth = covariances(sigma, COUNT), transform(X, goal[None])[0]
    errors, differ, found = [], 0.0, None
    for _ in range(_DRAWS):
        f = transform(X, m) + sigma * rng.normal(size=m.shape)
        found = fit.solve(m, f, 0.0 * S, S)
        errors.append(float(np.linalg.norm(transform(found, goal[None])[0] - truth)))
        if not point["anisotropic"]:
            differ = max(differ, float(np.abs(found - horn(m, f)).max()))
    tre = float(points(m, f, goal[None], fle=sigma).tre[0])
    rms = float(np.sqrt(np.mean(np.square(errors))))
    closed = 0.0 if point["anisotropic"] else fitzpatrick(m, FLE, goal)
    return {"predicted_m": tre, "simulated_m": rms, "closed_form_m": closed, "p95_m": float(np.quantile(errors, 0.95)),
            "error": tre / rms - 1.0, "from_horn": differ}  # fmt: skip


def unknown(point: Point, seed: int) -> dict[str, float]:
    """Whether the correspondence of shuffled markers is found, and whether a wrong one is refused."""
    rng = np.random.default_rng(seed)
    m, X = layout(rng), pose(rng)
    order = rng.permutation(COUNT)
    f = (transform(X, m) + FLE / np.sqrt(3.0) * rng.normal(size=m.shape))[order]
    try:
        found = points(m, f, correspond=False, fle=FLE if point["known"] else None)
    except RegistrationError:
        return {"right": 0.0, "refused": 1.0}
    return {"right": float(np.array_equal(order[found.correspondence], np.arange(COUNT))), "refused": 0.0}


def wrong(point: Point, seed: int) -> dict[str, float]:
    """Whether a marker 3 mm off its place is found, alone, and whether a right set gives a false alarm."""
    rng = np.random.default_rng(seed)
    m, X = layout(rng), pose(rng)
    f = transform(X, m) + FLE / np.sqrt(3.0) * rng.normal(size=m.shape)
    stated = FLE if point["known"] else None
    alarm = float(len(points(m, f, fle=stated).outliers) > 0)
    k, direction = int(rng.integers(COUNT)), rng.normal(size=3)
    f[k] += WRONG * direction / np.linalg.norm(direction)
    found = points(m, f, fle=stated).outliers
    return {"alarm": alarm, "found": float(k in found), "alone": float(found == (k,))}
