"""Spheres of the whole tool that press one surface at once: their forces and moments add, as felt at the handle.

Sphere i at r_i from the tip adds the wrench g_i = (n, r_i x n) times its force on the tip of a rigid tool. When tip and
tool move by a small displacement x (6,), the sphere moves along n by a_i x, and a_i follows from the follower's joints:
the shaft swings about the remote centre while the wrist keeps the attitude. The springs of a plane are therefore

    K sum g_i a_i^T,    and the dampers, which act on the twist of a rigid tool,    B sum g_i g_i^T.

Which spheres touch follows from a plane that approaches the tool: sphere i touches where the force of those that touch
already is still below the force cap; beyond the cap no force grows.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from palpate.base.arrays import Array, rigid
from palpate.scene.rig import Rig

_AROUND = 72  # planes that touch the same two spheres
_BINS = 1.5  # planes are alike if their normals, times this number, round to the same integers
_STEP = 1e-5  # step of the numerical differentiation [m]


@dataclass(frozen=True)
class Spheres:
    """The spheres of the tool in one posture."""

    centres: Array
    """(m, 3) in W, the tip's sphere first [m]."""
    radii: Array
    """(m,) [m]."""
    motion: Array
    """(m, 3, 6): velocity of each centre per twist of the tool's tip, both in W."""

    def at_once(self, normals: Array, depth: float) -> NDArray[np.bool_]:
        """Which spheres (d, m) touch each plane at once.

        normals: of the planes (d, 3), in W. depth: at which a single sphere reaches the force cap [m].
        """
        heights = self.centres @ normals.T - self.radii[:, None]  # (m, d), above a plane through the origin of W
        gaps = heights - heights.min(axis=0)
        ordered = np.sort(gaps, axis=0)
        already = np.arange(len(gaps))[:, None] * ordered - (np.cumsum(ordered, axis=0) - ordered)  # force by K [m]
        last = ordered[(already <= depth).sum(axis=0) - 1, np.arange(gaps.shape[1])]
        return np.asarray(gaps <= last).T

    def springs(self, n: Array, touching: NDArray[np.bool_]) -> tuple[Array, Array]:
        """Wrench on the tip per displacement and per twist (6, 6), in W, of unit springs and dampers along n (3,)."""
        r = (self.centres - self.centres[0])[touching]
        g = np.hstack([np.broadcast_to(n, r.shape), np.cross(r, n)])
        return g.T @ (n @ self.motion[touching]), g.T @ g

    def tangent_normals(self) -> Array:
        """Normals (d, 3) of planes that touch two of the spheres, from all sides."""
        i, j = np.triu_indices(len(self.radii), 1)
        apart = self.centres[j] - self.centres[i]
        length = np.linalg.norm(apart, axis=1)
        i, j, apart, length = (x[length > np.abs(self.radii[j] - self.radii[i]) + 1e-12] for x in (i, j, apart, length))
        axis = apart / length[:, None]
        u = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis), axis=1)])
        u /= np.linalg.norm(u, axis=1)[:, None]
        angle = np.linspace(0.0, 2.0 * np.pi, _AROUND, endpoint=False)[:, None, None]
        across = np.cos(angle) * u + np.sin(angle) * np.cross(axis, u)
        along = ((self.radii[j] - self.radii[i]) / length)[:, None]
        return np.asarray(along * axis + np.sqrt(1.0 - along**2) * across).reshape(-1, 3)

    @property
    def length(self) -> float:
        """Largest distance of two points on the spheres [m]."""
        return _extent(self.centres, self.radii)


def postures(rig: Rig, fractions: tuple[float, ...]) -> list[tuple[Spheres, ...]]:
    """The tool with closed and with open jaws, at the start and at fractions of the operator's path."""
    return [_with_both_jaws(rig, X, q) for X, q in _tools(rig, fractions)]


def longest(rig: Rig, fractions: tuple[float, ...]) -> float:
    """The largest `Spheres.length` [m] of these postures, which needs no motion of the spheres."""
    if not rig.spheres:
        return 2.0 * rig.scene.contact.radius
    tools = ((X, q, jaw) for X, q in _tools(rig, fractions) for jaw in _jaws(rig))
    return max(_extent(_centres(rig, *tool), _radii(rig)) for tool in tools)


@dataclass(frozen=True)
class PlaneContact:
    """A plane that several spheres touch at once."""

    posture: int
    """Index of the posture."""
    count: int
    """Number of spheres."""
    normal: Array
    """(3,) in W."""
    springs: Array
    """(6, 6) in W, see `Spheres.springs`."""
    dampers: Array
    """(6, 6) in W."""


def plane_contacts(tools: list[tuple[Spheres, ...]], depth: float, normal: Array | None) -> list[PlaneContact]:
    """Contacts with planes of one normal (3,) in W, or of any.

    Of planes whose normals differ by little, only the one that most spheres touch. Depth as in `Spheres.at_once`.
    """
    found = []
    for posture, jaws in enumerate(tools):
        for tool in jaws:
            normals = tool.tangent_normals() if normal is None else normal[None]
            touching = tool.at_once(normals, depth)
            order = np.argsort(-touching.sum(axis=1), kind="stable")
            _, first = np.unique(np.round(_BINS * normals[order]).astype(int), axis=0, return_index=True)
            found += [
                PlaneContact(posture, int(touching[k].sum()), normals[k], *tool.springs(normals[k], touching[k]))
                for k in order[first]
            ]
    return found


def _tools(rig: Rig, fractions: tuple[float, ...]) -> Iterator[tuple[Array, Array]]:
    """Poses X_WT (4, 4) of the tool and joint positions (n,) of the follower."""
    arms, path = rig.arms, rig.path
    X_WT, q = arms.X_WB @ arms.follower.fk(arms.q_follower0), arms.q_follower0
    yield X_WT, q
    last = path.period if path.period else float(path.times[-1])
    for fraction in fractions:
        X = X_WT.copy()
        X[:3, 3] = path.positions_W[int(np.argmin(np.abs(path.times - fraction * last)))]
        yield X, arms.follower.ik_nearest(np.linalg.solve(arms.X_WB, X), q, restarts=0)[0]


def _with_both_jaws(rig: Rig, X_WT: Array, q: Array) -> tuple[Spheres, ...]:
    """The spheres of one posture, with closed and with open jaws; the follower's joints do not depend on the jaws."""
    moved = []
    for e in _STEP * np.eye(6):
        X = X_WT.copy()
        X[:3, 3] += e[:3]
        X[:3, :3] = rigid.exp(e[3:]) @ X_WT[:3, :3]
        moved.append((X, rig.arms.follower.ik_nearest(np.linalg.solve(rig.arms.X_WB, X), q, restarts=0)[0]))
    found = []
    for jaw in _jaws(rig):
        here = _centres(rig, X_WT, q, jaw)
        motion = np.stack([(_centres(rig, *tool, jaw) - here) / _STEP for tool in moved], axis=-1)
        found.append(Spheres(here, _radii(rig), motion))
    return tuple(found)


def _jaws(rig: Rig) -> tuple[float, float]:
    """Angles of the closed and of the open jaws [rad]."""
    mapping = rig.options().mapping
    return mapping.jaw_min, mapping.jaw_max


def _radii(rig: Rig) -> Array:
    """Radii (m,) of all spheres [m], the tip's first."""
    return np.array([rig.scene.contact.radius, *(s.core.radius for s in rig.spheres)])


def _extent(centres: Array, radii: Array) -> float:
    """Largest distance of two points on spheres with centres (m, 3) and radii (m,) [m]."""
    apart = np.linalg.norm(centres[:, None] - centres, axis=-1)
    return float((apart + radii + radii[:, None]).max())


def _centres(rig: Rig, X_WT: Array, q: Array, jaw: float) -> Array:
    """Centres (m, 3) of all spheres in W [m]."""
    links = rig.arms.follower.link_poses(q, jaw)
    return np.array([X_WT[:3, 3], *(s.centre(X_WT, rig.arms.X_WB, links, jaw) for s in rig.spheres)])
