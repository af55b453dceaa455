"""``palpate study radius --spheres``: noisy meshes with and without smoothing, and point clouds, of a known sphere."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypedDict

import numpy as np
from rich.table import Table

from palpate.scene.contact import render
from palpate.world.clouds import PointCloud
from palpate.world.mesh import Mesh, quiet
from palpate.world.mesh.denoise import denoise
from palpate.world.registration.clouds import sampled
from palpate.world.shapes.analytic import Sphere
from palpate.world.surfaces import PointSurface
from palpate_lab.studies.radius.work import DEPTH, STIFFNESS

MESH_NOISES, CLOUD_NOISES = (0.05e-3, 0.2e-3), (0.3e-3, 1e-3)  # standard deviations [m]
TOOL = 1e-3  # radius on the meshes [m]
RADII = (0.5e-3, 1e-3, 2e-3, 4e-3, 8e-3)  # on the clouds [m]
TRIANGLES, CLOUD_SPACING = 82_000, 2e-3  # of the meshes [-]; mean distance of the points of the clouds [m]
PLACES = 200


class OfMesh(TypedDict):
    """A noise of the vertices. Directions: 95th percentile of the angle to the sphere's normal."""

    noise_mm: float
    spacing_mm: float  #: mean length of an edge
    radius_mm: float  #: of the tool
    direction_deg: float  #: of the mesh as measured
    smoothed_deg: float  #: of the mesh whose noise is removed


class OfCloud(TypedDict):
    """A noise of the points and a radius of the tool."""

    noise_mm: float
    spacing_mm: float
    radius_mm: float
    direction_deg: float


class Spheres(TypedDict):
    """Result. The keys are the documented contract of ``--json``."""

    simulated: bool
    sphere_mm: float
    places: int
    meshes: list[OfMesh]
    clouds: list[OfCloud]


def spheres(triangles: int = TRIANGLES, spacing: float = CLOUD_SPACING, places: int = PLACES) -> Spheres:
    """Press a tool into noisy meshes and clouds of a sphere, and compare the force's direction with the normal.

    Args:
        triangles: number of triangles of the meshes.
        spacing: mean distance of the points of the clouds [m].
        places: number of random places at which the tool presses.
    """
    return {
        "simulated": True,
        "sphere_mm": 1e3 * Sphere().radius,
        "places": places,
        "meshes": [_of_mesh(noise, triangles, places) for noise in MESH_NOISES],
        "clouds": [row for noise in CLOUD_NOISES for row in _of_cloud(noise, spacing, places)],
    }


def _of_mesh(noise: float, triangles: int, places: int) -> OfMesh:
    vertices, faces = Sphere().mesh(triangles)
    edges = np.linalg.norm(vertices[faces[:, 1]] - vertices[faces[:, 0]], axis=1)
    away = noise * np.random.default_rng(3).normal(size=(len(vertices), 1))  # along the normal
    with quiet():
        mesh = Mesh(vertices * (1.0 + away / Sphere().radius), faces)
        smooth = denoise(mesh, noise)
    return {
        "noise_mm": 1e3 * noise,
        "spacing_mm": float(1e3 * edges.mean()),
        "radius_mm": 1e3 * TOOL,
        "direction_deg": _direction_deg(mesh, TOOL, places),
        "smoothed_deg": _direction_deg(smooth, TOOL, places),
    }


def _of_cloud(noise: float, spacing: float, places: int) -> list[OfCloud]:
    vertices, faces = Sphere().mesh(40_000)
    points = sampled(vertices, faces, int(4.0 * np.pi * Sphere().radius ** 2 / spacing**2), seed=3)
    surface = PointSurface(PointCloud(points + noise * np.random.default_rng(1).normal(size=points.shape)))
    return [
        {
            "noise_mm": 1e3 * noise,
            "spacing_mm": 1e3 * spacing,
            "radius_mm": 1e3 * radius,
            "direction_deg": _direction_deg(surface, radius, places),
        }
        for radius in RADII
    ]


def _direction_deg(surface: Mesh | PointSurface, radius: float, places: int) -> float:
    """The 95th percentile of the angle between force and normal, pressed straight in to ``DEPTH``."""
    normals = np.random.default_rng(4).normal(size=(places, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    deepest = Sphere().radius + radius - DEPTH
    way = np.concatenate([np.linspace(deepest + 5e-3, deepest, 60), np.full(20, deepest)])  # of the tip's centre
    forces = [render(surface, way[:, None] * n, radius=radius, stiffness=STIFFNESS).force[-1] for n in normals]
    cosines = [F @ n / np.linalg.norm(F) for F, n in zip(forces, normals, strict=True)]
    return float(np.percentile(np.degrees(np.arccos(np.clip(cosines, -1.0, 1.0))), 95))


def table(found: Spheres) -> list[Table]:
    """The directions on meshes and on clouds."""
    words = f"simulated sphere of {found['sphere_mm']:g} mm, direction of the force at {found['places']} places, 95 %"
    meshes = [(f"{row['noise_mm']:g}", f"{row['spacing_mm']:.2f}", f"{row['direction_deg']:.1f}",
               f"{row['smoothed_deg']:.1f}") for row in found["meshes"]]  # fmt: skip
    clouds = [(f"{row['noise_mm']:g}", f"{row['spacing_mm']:g}", f"{row['radius_mm']:g}",
               f"{row['direction_deg']:.1f}") for row in found["clouds"]]  # fmt: skip
    return [
        _table(f"Meshes: {words}", ("noise\nmm", "spacing\nmm", "as measured\ndeg", "smoothed\ndeg"), meshes),
        _table(f"Point clouds: {words}", ("noise\nmm", "spacing\nmm", "radius\nmm", "direction\ndeg"), clouds),
    ]


def _table(title: str, names: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> Table:
    out = Table(title=title, box=None, padding=(0, 2, 0, 0), pad_edge=False)
    for name in names:
        out.add_column(name, justify="right")
    for row in rows:
        out.add_row(*row)
    return out
