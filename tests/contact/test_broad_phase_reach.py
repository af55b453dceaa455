"""No contact comes late: a fast tool among all kinds of objects against the distance to every object at every tick."""

import numpy as np
import pytest

from palpate import _core, _verify
from palpate._tissue import PointSurface
from palpate.base.arrays import so3
from palpate.world.shapes.analytic import SHAPES

RATE = 1000.0
RADII = (0.002, 0.0007, 0.008)
OFFSETS = np.array([[0, 0, 0], [0.01, 0, 0.002], [-0.004, 0.03, 0]])
WAVE, PERIOD = 0.02, 0.3  # of the first object [m, s]
SPREAD = 0.1  # of the objects around the origin [m]
TICKS = 4  # in which a proxy that the tool left behind in a jump goes round its object
MATERIAL = _core.Material(np.full(3, 300.0))


def mesh(shape, triangles, size=0.012):
    vertices, faces = SHAPES[shape].mesh(triangles)
    return _core.Mesh(np.ascontiguousarray(vertices * (size / np.abs(vertices).max())), faces)


def grid(of, steep=1.0, most=1.0):
    """Samples of the distance of a mesh, `steep` times too large and cut off at `most` [m]."""
    values = np.empty((24, 24, 24), np.float32)
    at = np.stack(np.meshgrid(*3 * [np.linspace(-0.016, 0.016, 24)], indexing="ij"), axis=-1)
    values[:] = np.clip(steep * of.nearest(at.reshape(-1, 3))[0], -most, most).reshape(values.shape)
    return _core.DistanceGrid(np.full(3, -0.016), np.full(3, 0.032 / 23), values)


def surfaces(rng):
    """All kinds of surfaces, the last two of which are grids with values that are no distances."""
    ball = rng.normal(size=(3000, 3))
    ball /= np.linalg.norm(ball, axis=1)[:, None]
    cap = ball[ball[:, 2] > 0.3]
    return [
        _core.Sphere(0.006), _core.Box(np.array([0.01, 0.02, 0.004])), _core.Capsule(0.003, 0.02),
        _core.Cylinder(0.005, 0.012), _core.ImplicitSurface(np.array([1e4, 1.6e9, 2e4]), [2, 4, 2], 1.0),
        _core.Cloud(0.01 * ball[:200], 0.002), mesh("box", 12), mesh("torus", 300), mesh("sphere", 60),
        mesh("sphere", 2000), mesh("groove", 100), grid(mesh("torus", 1000)),
        PointSurface(0.03 * cap, normals=cap.copy(), thickness=0.02),
        PointSurface(0.03 * cap, normals=-cap, thickness=0.004),
        grid(mesh("box", 12), steep=1.4), grid(mesh("sphere", 500), most=0.003),
    ]  # fmt: skip


def placed(rng, k, surface):
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = so3.matrices(so3.unit(rng.normal(size=4))), rng.uniform(-SPREAD, SPREAD, 3)
    motion = _core.Motion(waves=[_core.Wave(shift=np.array([0, 0, WAVE]), period=PERIOD)]) if k == 0 else _core.Motion()
    regions = [_core.Region(np.zeros(3), radius=0.004, material=MATERIAL)] if k % 3 == 0 else []
    return _core.Object(f"o{k}", surface, X, MATERIAL, regions, motion)


def scenes(rng, kinds):
    """A scene; the same objects, three of them elsewhere; fewer objects in another order."""
    first = [placed(rng, k, one) for k, one in enumerate(kinds)]
    floor = np.eye(4)
    floor[2, 3] = -1.2 * SPREAD
    first.append(_core.Object("floor", _core.Plane(), floor, MATERIAL))
    moved = [placed(rng, k, one.surface) if k in (1, 8, 11) else one for k, one in enumerate(first)]
    return [first, moved, [first[k] for k in rng.permutation(len(first))[:-3]]]


def path(rng, n, places):
    """Straight ways at 0.01 to 6 m/s, most of them to an object, some from anywhere else: (n, 3) [m]."""
    p = np.empty((n, 3))
    at, k = rng.uniform(-SPREAD, SPREAD, 3), 0
    while k < n:
        if rng.random() < 0.1:
            at = rng.uniform(-2 * SPREAD, 2 * SPREAD, 3)
        to = places[rng.integers(len(places))] + rng.normal(scale=0.006, size=3)
        if rng.random() < 0.2:
            to = rng.uniform(-3 * SPREAD, 3 * SPREAD, 3)
        step = np.exp(rng.uniform(np.log(0.01), np.log(6.0))) / RATE
        way = np.linalg.norm(to - at)
        m = int(np.clip(way / step, 1, min(150, n - k)))
        p[k : k + m] = at + np.minimum(np.arange(1, m + 1)[:, None] * step / way, 1.0) * (to - at)
        at, k = p[k + m - 1], k + m
    return p


def true_depths(objects, t, centres):
    """Depth (2, n, spheres, objects) of each sphere by the distance and by the nearest point; below 0 outside [m]."""
    depth = np.empty((2, *centres.shape[:2], len(objects)))
    for i, one in enumerate(objects):
        X = one.X_WO
        shift = np.array([0, 0, WAVE]) * np.sin(2 * np.pi * t / PERIOD)[:, None] if one.name == "o0" else 0.0
        for s, radius in enumerate(RADII):
            p_O = np.ascontiguousarray((centres[:, s] - X[:3, 3] - shift) @ X[:3, :3])
            distance, point, _ = one.surface.nearest(p_O)
            away = np.copysign(np.linalg.norm(p_O - point, axis=1), distance)
            depth[:, :, s, i] = radius - distance, radius - away
    return depth


def both(seed, n, method):
    """Depths (n, spheres, objects) of a tool with three spheres: as found, by the distance, by the nearest point."""
    rng = np.random.default_rng(seed)
    kinds = surfaces(rng)
    made = scenes(rng, kinds if method == "penalty" else kinds[:-2])
    which = np.zeros(n, np.int32)
    for k in np.sort(rng.integers(0, n, 12)):
        which[k:] = rng.integers(3)
    other = np.diff(which == 2, prepend=False)  # a loop forgets its contacts when it gets other objects
    resets = ((rng.random(n) < 0.002) | other).astype(np.int32)
    swing = 0.01 * np.sin(np.arange(n) / 40.0)[:, None, None] * np.array([[0, 0, 0], [1, 0, 0], [0, 0, 1]])
    centres = np.ascontiguousarray(path(rng, n, [one.X_WO[:3, 3] for one in made[0]])[:, None] + OFFSETS + swing)
    options = _core.ContactOptions()
    options.radius, options.objects = RADII[0], len(made[0])
    options.spheres = [_core.ToolSphere(OFFSETS[s], RADII[s]) for s in (1, 2)]
    found = _verify.touched([_core.Snapshot(one) for one in made], which, centres, resets, method, options, RATE)
    true = np.full((2, *found.shape), -np.inf)
    for k, objects in enumerate(made):
        now = which == k
        true[:, now, :, : len(objects)] = true_depths(objects, np.flatnonzero(now) / RATE, centres[now])
    return found, *true


@pytest.mark.parametrize("seed", [12, *(pytest.param(seed, marks=pytest.mark.long) for seed in range(20, 40))])
def test_the_nearest_point_is_felt_at_every_tick(seed):
    """Method penalty has no memory: each contact and its depth are those of the distances."""
    found, true, _ = both(seed, 8000, "penalty")
    assert (true > 0).sum() > 1000
    np.testing.assert_allclose(found, np.maximum(true, 0.0), rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("seed", [12, *(pytest.param(seed, marks=pytest.mark.long) for seed in range(20, 40))])
def test_the_proxy_holds_whatever_the_tool_is_in(seed):
    """Beside a grid the distance is less than that to the nearest point, from which the proxy is held off."""
    found, true, to_point = both(seed, 8000, "proxy")
    assert (true > 0).sum() > 1000
    missing = (true > 2e-4) & (to_point > 2e-4) & (found == 0)
    late = np.lib.stride_tricks.sliding_window_view(missing, TICKS, axis=0).all(axis=-1)
    assert not late.any(), f"{late.sum()} contacts are missing"
