"""Organ-like closed surfaces composed of a few smooth solids.

The frame of an organ is that of a patient lying on the back: x to the patient's left, y towards the head, z up
(anterior). Metres; the origin is the middle of the bounding box.
"""

from collections.abc import Callable

import numpy as np

from palpate.base import cache
from palpate.base.arrays import Array
from palpate.world.shapes import surface_nets
from palpate.world.shapes.surface_nets import Field, Triangles, Vertices, extract, refine, triangle_count

MM = 1e-3
COARSEST, FINEST_EXTRACTION = 2000, 60_000  # triangles


def organ(triangles: int = 30_000, seed: int = 0) -> tuple[Vertices, Triangles]:
    """A liver-like surface, about 195 mm wide: thick right lobe, tapering left lobe, thin inferior edge.

    The count `triangles` is met within 10 % up to 60,000 and within a factor of two above, where triangles are split
    into four; `seed` sets the gentle relief of the surface. Returns vertices (n, 3) [m] and triangles (m, 3), closed
    and counter-clockwise seen from outside; the same arguments give the same arrays. Raises ValueError below 2,000
    triangles, where the thin edge is lost.
    """
    box = np.array([[-105.0, -95.0, -65.0], [110.0, 85.0, 65.0]]) * MM
    return _cached("organ", triangles, seed, lambda: _surface(_liver(seed), box, triangles))


def gallbladder(triangles: int = 8000, seed: int = 0) -> tuple[Vertices, Triangles]:
    """A pear-shaped gallbladder along y, about 80 mm long; arguments, result and errors as in `organ`."""
    box = np.array([[-30.0, -55.0, -30.0], [30.0, 55.0, 35.0]]) * MM
    return _cached("gallbladder", triangles, seed, lambda: _surface(_pear(seed), box, triangles))


def _cached(
    kind: str, triangles: int, seed: int, make: Callable[[], tuple[Vertices, Triangles]]
) -> tuple[Vertices, Triangles]:
    """Read a surface from the user's cache (milliseconds), or generate it (seconds) and store it there."""

    def arrays() -> cache.Arrays:
        vertices, faces = make()
        return {"vertices": vertices, "triangles": faces}

    key = cache.source_key((__file__, surface_nets.__file__), kind, triangles, seed)
    found = cache.load_or_make(kind, key, arrays)
    return found["vertices"], found["triangles"]


def _surface(field: Field, box: Array, triangles: int) -> tuple[Vertices, Triangles]:
    if triangles < COARSEST:
        raise ValueError(f"triangles = {triangles}: the shape needs at least {COARSEST} to keep its thin edge")
    splits = max(0, int(np.ceil(np.log(triangles / FINEST_EXTRACTION) / np.log(4.0))))
    target = triangles / 4**splits
    spacing = float((box[1] - box[0]).max()) / 40.0
    for _ in range(2):  # the count is proportional to 1 / spacing^2
        spacing *= np.sqrt(triangle_count(field, box[0], box[1], spacing) / target)
    vertices, faces = extract(field, box[0], box[1], spacing)
    while not _is_closed(faces):  # two sheets of a thin fold may cross one cell; another spacing separates them
        spacing *= 0.98
        vertices, faces = extract(field, box[0], box[1], spacing)
    for _ in range(splits):
        vertices, faces = refine(field, vertices, faces, spacing)
        spacing *= 0.5
    return vertices - 0.5 * (vertices.min(axis=0) + vertices.max(axis=0)), faces


def _is_closed(faces: Triangles) -> bool:
    """True if every edge is shared by exactly two triangles."""
    sides = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1).astype(np.int64)
    _, count = np.unique(sides[:, 0] << 32 | sides[:, 1], return_counts=True)
    return bool((count == 2).all())


# Solids: approximate signed distances [mm] at points p (..., 3) [mm], negative inside.


def _ellipsoid(p: Array, centre: tuple[float, ...], radii: tuple[float, ...], tilt: float = 0.0) -> Array:
    """Ellipsoid turned by `tilt` [rad] about z; first-order distance k0 (k0 - 1) / k1."""
    q = p - np.array(centre)
    c, s = np.cos(tilt), np.sin(tilt)
    q = np.stack([c * q[..., 0] + s * q[..., 1], -s * q[..., 0] + c * q[..., 1], q[..., 2]], axis=-1)
    r = np.array(radii)
    k0 = np.linalg.norm(q / r, axis=-1)
    k1 = np.linalg.norm(q / (r * r), axis=-1)
    return np.asarray(k0 * (k0 - 1.0) / np.maximum(k1, 1e-9))


def _union(a: Array, b: Array, blend: float) -> Array:
    """Smooth union of two solids, blended over `blend` [mm]."""
    h = np.maximum(blend - np.abs(a - b), 0.0) / blend
    return np.asarray(np.minimum(a, b) - h * h * h * blend / 6.0)


def _minus(a: Array, b: Array, blend: float) -> Array:
    """Solid a without b, with the new rim rounded over `blend` [mm]."""
    return np.asarray(-_union(-a, b, blend))


def _relief(p: Array, seed: int, amplitude: float, wavelength: float) -> Array:
    """Gentle relief: six plane waves of random direction and phase [mm]."""
    draw = np.random.default_rng(seed)
    directions = draw.normal(size=(6, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    phases = draw.uniform(0.0, 2.0 * np.pi, 6)
    waves = sum(np.sin(p @ (2.0 * np.pi / wavelength * d) + phase) for d, phase in zip(directions, phases, strict=True))
    return np.asarray(amplitude / np.sqrt(6.0) * waves)


def _liver(seed: int) -> Field:
    def field(points: Array) -> Array:
        p = points / MM
        right = _ellipsoid(p, (-40.0, -6.0, -2.0), (46.0, 70.0, 46.0), tilt=-0.10)
        middle = _ellipsoid(p, (-4.0, 10.0, 4.0), (54.0, 52.0, 40.0), tilt=0.5)
        left = _ellipsoid(p, (40.0, 21.0, 9.0), (48.0, 35.0, 21.0), tilt=0.22)
        tip = _ellipsoid(p, (84.0, 34.0, 10.0), (26.0, 16.0, 9.0), tilt=0.1)
        f = _union(_union(_union(right, middle, 30.0), left, 26.0), tip, 24.0)
        # The visceral side is hollow where it rests on stomach, duodenum and colon; its inferior edge is thin.
        f = _minus(f, _ellipsoid(p, (6.0, -58.0, -66.0), (150.0, 88.0, 70.0), tilt=0.30), 9.0)
        # Heart above the left lobe; notch and groove of the falciform ligament; bed of the gallbladder.
        f = _minus(f, _ellipsoid(p, (44.0, 84.0, 14.0), (44.0, 34.0, 44.0)), 18.0)
        f = _minus(f, _ellipsoid(p, (22.0, -34.0, 16.0), (5.0, 20.0, 50.0), tilt=-0.35), 14.0)
        f = _minus(f, _ellipsoid(p, (19.0, 22.0, 58.0), (5.0, 66.0, 18.0), tilt=-0.12), 22.0)
        f = _minus(f, _ellipsoid(p, (-16.0, -54.0, -8.0), (9.0, 36.0, 13.0), tilt=-0.3), 9.0)
        return np.asarray(MM * (f + _relief(p, seed, 0.5, 34.0)))

    return field


def _pear(seed: int) -> Field:
    def field(points: Array) -> Array:
        p = points / MM
        fundus = _ellipsoid(p, (0.0, -14.0, 0.0), (17.0, 24.0, 16.0))
        body = _ellipsoid(p, (0.0, 10.0, 2.0), (10.5, 24.0, 10.0))
        neck = _ellipsoid(p, (2.0, 33.0, 6.0), (5.0, 12.0, 5.0), tilt=-0.35)
        f = _union(_union(fundus, body, 14.0), neck, 8.0)
        return np.asarray(MM * (f + _relief(p, seed, 0.3, 18.0)))

    return field
