"""Stage ``contact``: render a prescribed tool path with the contact and force code of the haptic loop."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
import numpy.typing as npt

from palpate import _core
from palpate.base.arrays import Array
from palpate.base.arrays.checks import not_negative, positive

if TYPE_CHECKING:
    from palpate.world import surfaces
    from palpate.world.clouds import PointCloud
    from palpate.world.mesh import Mesh


SurfaceLike: TypeAlias = "Mesh | PointCloud | surfaces.Surface | _core.Surface | tuple[npt.ArrayLike, npt.ArrayLike]"


@dataclass(frozen=True)
class Rendered:
    """Contact and force for each of the n positions of the tool. World frame W."""

    force: Array  #: (n, 3) F_T_W, force of the surface on the tool; exactly zero without contact [N]
    normal: Array  #: (n, 3) outward unit normal of the surface; zero without contact
    depth: Array  #: (n,) deflection along the normal [m]
    proxy: Array  #: (n, 3) p_WP, the proxy; equal to the tool position without contact [m]
    latency: Array  #: (n,) computation time of one update of contact and force, measured in C++ [s]
    started_inside: bool  #: the path starts inside a closed surface; the proxy starts at the nearest point outside
    torque: Array  #: (n, 3) torque about the tool tip; zero without additional spheres [N m]


def render(
    surface: SurfaceLike,
    tips: npt.ArrayLike,
    *,
    radius: float,
    stiffness: float | npt.ArrayLike | None = None,
    damping: float | npt.ArrayLike = 0.0,
    friction: float = 0.0,
    static_friction: float = 0.0,
    method: str = "proxy",
    release: float | None = None,
    rate: float = 1000.0,
    poses: npt.ArrayLike | None = None,
    spheres: Sequence[tuple[npt.ArrayLike, float]] = (),
) -> Rendered:
    """Render the contact of ``surface`` with a sphere whose centre follows ``tips``.

    F = K delta_x - B (n . v) n with delta_x from the tool to the proxy and v by backward differences of ``tips``.

    Args:
        surface: a mesh, a point cloud, one of ``palpate.surfaces``, or ``(vertices (n, 3) [m], triangles (m, 3))``.
        tips: (n, 3) tool tip p_WT, the centre of the spherical proxy region [m].
        radius: radius of the spherical proxy region [m].
        stiffness: K, one number or one per axis of W [N/m]. A ``palpate.Tissue`` has none: it deforms, from rest.
        damping: B, likewise [N s/m].
        friction: Coulomb coefficient mu while the tool slips.
        static_friction: coefficient while the tool sticks; at least ``friction``.
        method: name of a contact method: ``proxy``; for comparison ``penalty`` and the paper's
            ``paper-plane``, ``paper-alg1``, ``face-normal``, ``approach-velocity``, which need triangles.
        release: deflection at which method ``proxy`` releases a tool that passed through a closed object [m].
        rate: sampling rate of the tips [Hz].
        poses: (n, 4, 4) X_WO, pose of the surface at each tip; default: at rest. The damping uses its velocity.
        spheres: additional spheres of the tool: (p_TS (3,) [m] in axes of W, radius [m]) each.

    Raises:
        ValueError: an argument is not valid; the message names it, its value and the requirement.
        MeshError: the vertices and triangles do not form a mesh.
    """
    points = _points(tips)
    if method not in _core.contact_methods():
        from palpate.scene.contact_method import loaded  # takes 80 ms, and `proxy` does without

        loaded(method)
    options = _options(radius, release, spheres)
    surface, stiffness = _soft(surface, stiffness)
    world = snapshot_of(
        surface, stiffness=stiffness, damping=damping, friction=friction, static_friction=static_friction
    )
    X_WO = None if poses is None else _poses(poses, len(points))
    return Rendered(*_core.contact_render(world, points, method, options, positive("rate", rate, "Hz"), X_WO))


def _soft(surface: SurfaceLike, stiffness: float | npt.ArrayLike | None) -> tuple[SurfaceLike, float | npt.ArrayLike]:
    """The surface, as the core of a soft body if it is one, and its stiffness."""
    from palpate.world.tissue import Tissue  # imported late, as below

    if isinstance(surface, Tissue):
        if stiffness is not None:
            raise ValueError("stiffness: the material of a Tissue determines it; leave it out")
        return surface.core, 0.0
    if stiffness is None:
        raise ValueError("stiffness is missing: give K in N/m, for example 500; only a Tissue has none")
    return surface, stiffness


def _options(
    radius: float, release: float | None, spheres: Sequence[tuple[npt.ArrayLike, float]]
) -> _core.ContactOptions:
    options = _core.ContactOptions()
    options.radius = positive("radius", radius, "m")
    if release is not None:
        options.release = positive("release", release, "m")
    options.spheres = [
        _core.ToolSphere(np.asarray(p, dtype=np.float64), positive("radius", r, "m")) for p, r in spheres
    ]
    return options


def snapshot_of(
    surface: SurfaceLike,
    *,
    stiffness: float | npt.ArrayLike,
    damping: float | npt.ArrayLike = 0.0,
    friction: float = 0.0,
    static_friction: float = 0.0,
) -> _core.Snapshot:
    """A world with one object, "surface", at the origin. Arguments and errors as in ``render``."""
    mu, mu_static = not_negative("friction", friction), not_negative("static_friction", static_friction)
    material = _core.Material(_axes("stiffness", stiffness), _axes("damping", damping), mu, mu_static)
    return _core.Snapshot([_core.Object("surface", _core_surface(surface), np.eye(4), material)])


def _core_surface(surface: SurfaceLike) -> _core.Surface:
    from palpate.world import surfaces  # imported late: rendering does not need the readers of files
    from palpate.world.clouds import PointCloud
    from palpate.world.mesh import Mesh

    if isinstance(surface, PointCloud):
        return surfaces.PointSurface(surface).core
    if isinstance(surface, _core.Surface):
        return surface
    if isinstance(surface, (Mesh, surfaces.Surface)):
        return surface.core
    if isinstance(surface, tuple) and len(surface) == 2:
        return Mesh(*surface, name="surface").core
    expected = "a palpate.Mesh, a palpate.PointCloud, one of palpate.world.surfaces or (vertices, triangles)"
    raise ValueError(f"surface must be {expected}, got {type(surface).__name__}")


def _points(tips: npt.ArrayLike) -> Array:
    points = np.ascontiguousarray(tips, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3:
        raise ValueError(f"tips must have shape (n, 3) in metres, got {points.shape}")
    finite = np.isfinite(points).all(axis=1)
    if not finite.all():
        raise ValueError(f"tips must be finite, row {int(np.argmin(finite))} is {points[np.argmin(finite)].tolist()}")
    return points


def _axes(name: str, value: float | npt.ArrayLike) -> Array:
    axes = np.asarray(value, dtype=np.float64)
    if axes.shape not in ((), (3,)):
        raise ValueError(f"{name} must be one number or three, for the axes of W; got shape {axes.shape}")
    if not np.isfinite(axes).all() or (axes < 0).any():
        raise ValueError(f"{name} must be finite and not negative, got {axes.tolist()}")
    return np.ascontiguousarray(np.broadcast_to(axes, (3,)))


def _poses(poses: npt.ArrayLike, n: int) -> Array:
    X = np.ascontiguousarray(poses, dtype=np.float64)
    if X.shape != (n, 4, 4):
        raise ValueError(f"poses must have shape ({n}, 4, 4), one for each tip, got {X.shape}")
    finite = np.asarray(np.isfinite(X).reshape(n, 16).all(axis=1))
    R = np.where(finite[:, None, None], X[:, :3, :3], 0.0)
    valid = finite & (X[:, 3] == [0, 0, 0, 1]).all(axis=1) & (np.linalg.det(R) > 0)
    valid &= np.abs(R @ R.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2), initial=0.0) < 1e-6
    if not valid.all():
        i = int(np.argmin(valid))
        raise ValueError(f"poses must be finite, with a rotation matrix and a last row 0 0 0 1; poses[{i}] is not")
    return X
