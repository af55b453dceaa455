"""Estimates of whether a mesh is fine enough for haptic contact, and of the best radius of the tool's sphere.

The rules are fitted to measurements: the radius rules to ``palpate study radius``, the errors between facets to
``palpate bench contact`` (tests/contact/test_touchable.py compares them).
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from dataclasses import dataclass, fields
from hashlib import sha256

import numpy as np
import numpy.typing as npt

from palpate import _core
from palpate.base import cache
from palpate.base.arrays import Array
from palpate.base.arrays.checks import finite_or_none
from palpate.base.arrays.plain import Content, plain
from palpate.base.errors import PalpateWarning
from palpate.world.mesh import Mesh
from palpate.world.mesh.flips import thickness

Index = npt.NDArray[np.integer]

FEATURE_RADIUS = 0.5
"""Largest radius over the width of a ridge: such a sphere reaches the ground next to it, with 97 % of the relief."""
DIRECTION_LIMIT_DEG = 15.0
"""Direction error by noise (95 %) above which a larger radius is recommended; hands discriminate 20 to 35 deg."""
COARSE_DEG, COARSE_MN = 2.0, 50.0
"""Estimated errors between facets above which a mesh counts as coarse; 50 mN is 5 % of 1 N."""
DOUBTFUL_DEG = 60.0
"""Edges sharper than this are real; those between the crease angle and this may be a coarsely meshed round shape."""
SLIVER = 0.1
"""Height over longest edge below which a triangle is a sliver, whose normal tilts the smooth surface [-]."""
CACHED_FROM = 10_000
"""Triangles from which the fineness of a mesh is kept in the cache."""
MOST_TRIANGLES = 200_000
"""Triangles from which a sample of a mesh is looked at, a few in a hundred thousand of which do not matter."""
_AT_ONCE = 50_000  # triangles or edges: a large mesh takes little memory more
EDGE_SPEED = 0.05
"""Speed of a tool that slides over an edge [m/s]."""


@dataclass(frozen=True)
class Fineness:
    """Estimated effect of a mesh's facets on the force: values that 95 % of the surface does not exceed."""

    edge_mm: float  #: median length of an edge
    turn_deg: float  #: angle between neighbouring facets, without real edges
    direction_error_deg: float  #: direction error of the smoothed force of method ``proxy``
    force_error_mN: float  #: magnitude error of that force
    facet_error_mN: float  #: force error without smoothing: stiffness times the sagitta of the facets
    doubtful_share: float  #: fraction of the surface next to edges of 30 to 60 deg: coarse round shapes, or real edges
    stepping_share: float  #: fraction of the surface on slivers or next to creases, where the direction may step
    triangles_needed: int  #: number for errors below COARSE_DEG and COARSE_MN

    @property
    def coarse(self) -> bool:
        """True if a finer mesh would change the force noticeably."""
        return self.direction_error_deg > COARSE_DEG or self.force_error_mN > COARSE_MN or self.doubtful_share > 0.05


@dataclass(frozen=True)
class Radius:
    """Recommended radius for a mesh, and its limits by features and noise. Lengths in millimetres."""

    given_mm: float
    recommended_mm: float
    largest_mm: float  #: largest radius that reaches into the features; infinite without features
    smallest_mm: float  #: smallest radius that keeps the direction error by noise below the limit
    feature_mm: float | None  #: narrowest feature: given, or the tightest hollows of the mesh; None without hollows
    noise_mm: float  #: standard deviation: given, or from the mesh's roughness
    direction_noise_deg: float  #: direction error by noise at the recommended radius, 95 %
    unreachable_share: float  #: fraction of the surface in hollows tighter than the given radius

    @property
    def conflict(self) -> bool:
        """True if no radius satisfies both limits."""
        return self.smallest_mm > self.largest_mm

    def figures(self) -> Content:
        """The values for JSON; an infinite radius becomes None."""
        return {**plain(self), "largest_mm": finite_or_none(self.largest_mm)}


@dataclass(frozen=True)
class _Edges:
    """Inner edges of a mesh, one row each."""

    turn: Array  # angle between its two facets, positive if convex [rad]
    across: Array  # mean height of the two facets over the edge [m]
    area: Array  # total area of the two facets [m^2]
    length: Array  # length of the edge [m]


def fineness_of(mesh: Mesh, stiffness: float) -> Fineness:
    """As `fineness`; kept in the user's cache unless the mesh is small."""
    if not mesh.key and len(mesh.triangles) < CACHED_FROM:
        return fineness(mesh.core, stiffness)
    content = mesh.key or "".join(sha256(a.data).hexdigest() for a in (mesh.vertices, mesh.triangles))
    key = cache.source_key([__file__], content, stiffness)
    found = cache.load_or_make("mesh_fineness", key, lambda: _as_arrays(fineness(mesh.core, stiffness)))
    values = {one.name: found[one.name].item() for one in fields(Fineness)}
    return Fineness(**values)


def _as_arrays(fine: Fineness) -> cache.Arrays:
    return {one.name: np.array(getattr(fine, one.name)) for one in fields(fine)}


def fineness(mesh: _core.Mesh, stiffness: float) -> Fineness:
    """Estimate the effect of a mesh's facets for a contact stiffness [N/m]."""
    e, n = _edges(mesh), mesh.triangle_count
    turn = np.abs(e.turn)
    smooth = turn < np.radians(DOUBTFUL_DEG)
    doubtful = smooth & (turn >= _core.CREASE_ANGLE)
    angle, sagitta = (_quantile(x[smooth], e.area[smooth], 0.95) for x in (turn, turn * e.across / 8))
    # Smoothing leaves errors of second order in the turn (measured: docs/contact.md), at most those of the facets.
    direction = min(np.degrees(angle**2), np.degrees(angle) / 2)
    force = 1e3 * stiffness * sagitta * min(8.0 * angle**2, 1.0)
    share = float(e.area[doubtful].sum() / max(e.area.sum(), 1e-300))
    more = max(direction / COARSE_DEG, np.sqrt(force / COARSE_MN), 4.0 if share > 0.05 else 0.0)
    return Fineness(
        edge_mm=1e3 * float(np.percentile(e.length, 50.0)) if len(e.length) else 0.0,
        turn_deg=float(np.degrees(angle)),
        direction_error_deg=float(direction),
        force_error_mN=float(force),
        facet_error_mN=float(1e3 * stiffness * sagitta),
        doubtful_share=share,
        stepping_share=_stepping_share(mesh, e),
        triangles_needed=int(np.ceil(n * max(more, 1.0))) if more > 1 else n,
    )


def warn_of_facets(fine: Fineness, where: str) -> None:
    """Warn of facets that the hand would feel."""
    if not fine.coarse:
        return
    what = (
        f"coarse mesh: neighbouring facets turn by {fine.turn_deg:.0f} deg; the force may be off by about "
        f"{fine.direction_error_deg:.1f} deg and {fine.force_error_mN:.0f} mN"
    )
    if fine.doubtful_share > 0.05:
        what = (
            f"coarse mesh, or an object of many edges: {fine.doubtful_share:.0%} of the surface lies next to edges of "
            f"30 to {DOUBTFUL_DEG:.0f} deg, which are felt as edges"
        )
    mend = f"about {_rounded(fine.triangles_needed):,} triangles of the same object would do"
    warnings.warn(PalpateWarning(what, where=where, mend=mend), stacklevel=2)


def _stepping_share(mesh: _core.Mesh, e: _Edges) -> float:
    """Fraction of the surface next to creases, each with a third of its two facets, or on slivers."""
    every = _every(mesh)
    triangles = mesh.triangles[::every]
    _, double, _ = _facets(mesh.vertices, triangles)
    thin = thickness(mesh.vertices, triangles) < SLIVER
    total = max(double.sum() / 2, 1e-300)
    creases = e.area[np.abs(e.turn) >= _core.CREASE_ANGLE].sum() / 3
    return float(min(creases + double[thin].sum() / 2, total) / total)


def radius(mesh: _core.Mesh, given: float, *, feature: float | None = None, noise: float | None = None) -> Radius:
    """Recommend a radius.

    Args:
        mesh: the mesh.
        given: the intended radius [m].
        feature: width of the narrowest feature to be felt [m]; default: from the concave curvature of the mesh.
        noise: standard deviation of the surface [m]; default: from its roughness.
    """
    e = _edges(mesh)
    edge = float(np.percentile(e.length, 50.0)) if len(e.length) else 0.0
    noise = roughness(mesh) if noise is None else noise
    rough = noise > 0.05 * edge  # then the curvature of the mesh is that of the noise
    hollow = (e.turn < -1e-9) & ~np.full(len(e.turn), rough)
    tightness = np.where(hollow, e.across / np.maximum(-e.turn, 1e-9), np.inf)  # radius of curvature [m]
    largest = FEATURE_RADIUS * feature if feature is not None else _quantile(tightness, e.area, 0.01)
    smallest = noise_radius(noise, edge)
    default = _core.ContactOptions().radius
    recommended = largest if smallest > largest else max(smallest, min(default, largest))
    return Radius(
        given_mm=1e3 * given,
        recommended_mm=_two_digits(1e3 * recommended),
        largest_mm=1e3 * largest,
        smallest_mm=1e3 * smallest,
        feature_mm=1e3 * largest / FEATURE_RADIUS if np.isfinite(largest) else None,
        noise_mm=1e3 * noise,
        direction_noise_deg=direction_noise_deg(noise, recommended, edge),
        unreachable_share=float(e.area[tightness < given].sum() / max(e.area.sum(), 1e-300)),
    )


def direction_noise_deg(noise: float, radius: float, spacing: float) -> float:
    """Direction error of the force by noise of the vertices, 95 % [deg].

    For noise below SMOOTHED * spacing the facets are smoothed, and the error is SLOPE * noise / spacing, because the
    smooth surface passes through every vertex. For larger noise the sphere rests on the peaks: a peak of height
    ``noise`` on flat ground touches it at the angle sqrt(2 noise / radius), which agrees with measurements.
    """
    if noise <= 0.0 or noise < SMOOTHED * spacing:
        return float(np.degrees(SLOPE * noise / spacing)) if noise > 0.0 else 0.0
    return float(np.degrees(min(np.sqrt(2 * noise / radius), np.pi / 2)))


SLOPE = 3.2
"""Slope error of the smoothed surface divided by noise / spacing, as measured (95 %)."""
SMOOTHED = 0.15
"""Noise below this fraction of the vertices' spacing leaves few edges sharper than the crease angle."""


def noise_radius(noise: float, spacing: float) -> float:
    """Smallest radius with ``direction_noise_deg`` below its limit [m]; 0 if the radius does not matter."""
    if direction_noise_deg(noise, 1e9, spacing) == 0.0 or noise < SMOOTHED * spacing:
        return 0.0
    return float(2 * noise / np.radians(DIRECTION_LIMIT_DEG) ** 2)


def roughness(mesh: _core.Mesh) -> float:
    """Standard deviation of the vertex noise [m], from subtracting the neighbours' mean twice.

    This removes almost all of a smooth surface and a known fraction of white noise. The fraction is found by applying
    the same operation to unit noise. The lower quartile is used, because edges and corners are not noise. The result
    is 0 for fewer than a hundred vertices.
    """
    v, t = mesh.vertices, mesh.triangles
    if len(v) < 100:
        return 0.0
    a, b = (np.concatenate([t[:, i] for i in order]) for order in ((0, 1, 2, 1, 2, 0), (1, 2, 0, 0, 1, 2)))
    degree = np.maximum(np.bincount(a, minlength=len(v)), 1)

    def minus_neighbours(x: Array) -> Array:
        mean = np.stack([np.bincount(a, x[b, k], len(v)) for k in range(x.shape[1])], axis=1)
        return x - mean / degree[:, None]

    n = np.cross(v[t[:, 1]] - v[t[:, 0]], v[t[:, 2]] - v[t[:, 0]])
    normal = np.stack([np.bincount(t.ravel(), np.repeat(n[:, k], 3), len(v)) for k in range(3)], axis=1)
    normal = normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    normal_part = (minus_neighbours(minus_neighbours(v - v.mean(axis=0))) * normal).sum(axis=1)
    unit = minus_neighbours(minus_neighbours(np.random.default_rng(0).normal(size=(len(v), 1))))[:, 0]
    return float(np.quantile(np.abs(normal_part), 0.25) / np.quantile(np.abs(unit), 0.25))


def turn_per_ms_deg(radius: float, depth: float = 0.0) -> float:
    """Rotation of the force per millisecond while a sphere rolls over an edge at ``EDGE_SPEED`` [deg].

    At a depth [m] its centre turns around the edge at the distance radius - depth. Infinite from a depth of the radius
    on, where the centre meets the edge itself.
    """
    return float(np.degrees(EDGE_SPEED * 1e-3 / (radius - depth))) if depth < radius else float("inf")


def _edges(mesh: _core.Mesh) -> _Edges:
    """The inner edges of a mesh; of a large one those whose lower vertex has a number that `_every` divides."""
    v, t = mesh.vertices, mesh.triangles
    half, key = (np.concatenate(parts) for parts in zip(*_half_edges(mesh), strict=True))
    order = np.argsort(key, kind="stable")
    same = key[order][1:] == key[order][:-1]
    first, second = half[order[:-1][same]], half[order[1:][same]]
    blocks = [_between(v, t, first[k : k + _AT_ONCE], second[k : k + _AT_ONCE])
              for k in range(0, max(len(first), 1), _AT_ONCE)]  # fmt: skip
    return _Edges(*(np.concatenate([getattr(block, one.name) for block in blocks]) for one in fields(_Edges)))


def _half_edges(mesh: _core.Mesh) -> Iterator[tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]]:
    """Half-edges of `_edges`, by blocks of triangles, and a number of each that is the same for both of an edge."""
    every, n = _every(mesh), len(mesh.vertices)
    for begin in range(0, mesh.triangle_count, _AT_ONCE):
        t = mesh.triangles[begin : begin + _AT_ONCE]
        starts, nexts = t.ravel(), t[:, [1, 2, 0]].ravel()
        low = np.minimum(starts, nexts)
        half = np.flatnonzero(low % every == 0)
        yield half + 3 * begin, low[half].astype(np.int64) * n + np.maximum(starts[half], nexts[half])


def _between(v: Array, t: npt.NDArray[np.int32], first: Index, second: Index) -> _Edges:
    """The edges between the triangles of two half-edges each."""
    length = np.linalg.norm(v[t[first // 3, (first + 1) % 3]] - v[t[first // 3, first % 3]], axis=1)
    (n_i, double_i, middle_i), (n_j, double_j, middle_j) = (_facets(v, t[edge // 3]) for edge in (first, second))
    sharp = np.arctan2(np.linalg.norm(np.cross(n_i, n_j), axis=1), (n_i * n_j).sum(axis=1))
    convex = ((middle_j - middle_i) * n_i).sum(axis=1) <= 0
    keep = (double_i > 0) & (double_j > 0) & (length > 0)
    area = (double_i + double_j) / 2
    turn = np.where(convex, sharp, -sharp)
    return _Edges(turn[keep], (area / np.maximum(length, 1e-300))[keep], area[keep], length[keep])


def _facets(v: Array, t: npt.NDArray[np.int32]) -> tuple[Array, Array, Array]:
    """Unit normals (m, 3), double areas (m,) and middles (m, 3) of triangles (m, 3)."""
    a, b, c = (v[t[:, k]] for k in range(3))
    n = np.cross(b - a, c - a)
    double = np.linalg.norm(n, axis=1)
    return n / np.maximum(double, 1e-300)[:, None], double, (a + b + c) / 3.0


def _every(mesh: _core.Mesh) -> int:
    """Of how many vertices or triangles one is looked at."""
    return -(-mesh.triangle_count // MOST_TRIANGLES)


def _quantile(values: Array, weights: Array, q: float) -> float:
    if len(values) == 0:
        return 0.0
    order = np.argsort(values)
    share = np.cumsum(weights[order])
    return float(values[order[min(int(np.searchsorted(share, q * share[-1])), len(values) - 1)]])


def _two_digits(x: float) -> float:
    return float(f"{x:.2g}")


def _rounded(n: int) -> int:
    """Rounded up to two significant digits."""
    step = int(10 ** max(len(str(n)) - 2, 0))
    return -(-n // step) * step
