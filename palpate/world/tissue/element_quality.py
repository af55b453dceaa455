"""Quality of a tetrahedral mesh, and the time step that explicit integration allows on it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.base.arrays import Array
from palpate.world.tissue.body import Tetrahedra
from palpate.world.tissue.material import TissueMaterial
from palpate.world.tissue.tetrahedra import FACES, TetMesh, signed_volumes

POOR = 0.1
"""Quality below which a tetrahedron counts as poor; a regular one has 1."""


@dataclass(frozen=True)
class Quality:
    """Figures of a mesh with its material."""

    nodes: int
    tets: int
    volume_ml: float  #: [ml]
    edge_mm: float  #: median length of an edge [mm]
    shortest_edge_mm: float  #: [mm]
    worst: float  #: smallest quality: 1 for a regular tetrahedron, 0 for a flat one
    poor: int  #: tetrahedra below `POOR`
    stable_step_ms: float  #: largest step of explicit integration without added mass [ms]
    added_mass_percent: float  #: mass that makes `step_ms` stable, over the body's mass [%]
    step_ms: float  #: step for which the mass is added [ms]


def quality(mesh: TetMesh, materials: list[TissueMaterial], step: float = 0.5e-3) -> Quality:
    """Judge a mesh.

    Args:
        mesh: the tetrahedra; `mesh.region` numbers the materials.
        materials: one for each region.
        step: time step of the body [s].
    """
    stable = stable_steps(mesh, materials)
    density = np.array([m.density for m in materials])[mesh.region]
    mass = density * mesh.volumes
    added = float(np.sum(mass * (np.maximum(step / stable, 1.0) ** 2 - 1.0)) / mass.sum())
    edges = edge_lengths(mesh)
    shape = shapes(mesh)
    return Quality(
        nodes=len(mesh.nodes),
        tets=len(mesh.tets),
        volume_ml=1e6 * float(mesh.volumes.sum()),
        edge_mm=1e3 * float(np.median(edges)),
        shortest_edge_mm=1e3 * float(edges.min()),
        worst=float(shape.min()),
        poor=int((shape < POOR).sum()),
        stable_step_ms=1e3 * float(stable.min()),
        added_mass_percent=100.0 * added,
        step_ms=1e3 * step,
    )


def stable_steps(mesh: TetMesh, materials: list[TissueMaterial]) -> Array:
    """Largest stable step (m,) of central differences for each element [s], with lumped mass.

    The highest frequency of a linear tetrahedron is at most c |B|, with the wave speed c and |B|^2 = 4 sum |grad N_i|^2
    (four equal masses; Belytschko 2000, section 6.2.9, and the bound of a matrix's eigenvalue by its trace).
    """
    speed = np.array([m.wave_speed for m in materials])[mesh.region]
    p = mesh.nodes[mesh.tets]  # (m, 4, 3)
    face = p[:, FACES]  # (m, 4, 3, 3)
    area = 0.5 * np.linalg.norm(np.cross(face[:, :, 1] - face[:, :, 0], face[:, :, 2] - face[:, :, 0]), axis=2)
    slopes = (area / (3.0 * mesh.volumes[:, None])) ** 2  # |grad N_i|^2 = (A_i / 3V)^2
    steps: Array = 2.0 / (speed * np.sqrt(4.0 * slopes.sum(axis=1)))
    return steps


def shapes(mesh: Tetrahedra) -> Array:
    """Quality (m,) of each tetrahedron: 12 (3 V)^(2/3) over the sum of its squared edges (mean ratio)."""
    e = mesh.nodes[mesh.tets[:, _EDGES]]
    squared = ((e[:, :, 1] - e[:, :, 0]) ** 2).sum(axis=(1, 2))
    ratio: Array = 12.0 * (3.0 * signed_volumes(mesh.nodes, mesh.tets)) ** (2.0 / 3.0) / squared
    return ratio


_EDGES = np.array([[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]])


def edge_lengths(mesh: Tetrahedra) -> Array:
    """Lengths (k,) of all edges [m]."""
    pairs = np.unique(np.sort(mesh.tets[:, _EDGES].reshape(-1, 2), axis=1), axis=0)
    lengths: Array = np.linalg.norm(mesh.nodes[pairs[:, 1]] - mesh.nodes[pairs[:, 0]], axis=1)
    return lengths
