"""``palpate bench contact --organs``: steps of the force on slides over organ meshes, and over ridges of known radius.

The tool slides along plane sections of the surface at 50 mm/s and a constant depth. A hand does not follow facets, so
the section is smoothed over 2 mm. The ridges have an exact answer: at the depth d, a sphere of radius r that slides
over a ridge of radius R turns the force by v dt / (R + r - d) per tick.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import TypedDict

import numpy as np
from rich.table import Table

from palpate import _core, _verify
from palpate.base.arrays import Array
from palpate.scene.contact import touchable
from palpate.scene.contact.judging import RADIUS, STIFFNESS
from palpate.scene.contact.rendering import render
from palpate.world.mesh import Mesh, quiet
from palpate.world.mesh.denoise import denoise
from palpate.world.mesh.repair import repair
from palpate_lab import places

ORGANS = ("Liver", "Kidney_right", "Stomach", "Spleen", "Duodenum", "gallbladder_visual")
DEPTHS = (1e-3, 2e-3)  # [m]
RIDGES = (0.0, 1e-3, 2e-3)  # radii of the exact ridges, which turn by 90 degrees [m]
FACETS = (0.3e-3, 2.6e-3)  # edges of the ridges' meshes: fine, and those of organ scans [m]
STEP = 5e-5  # distance in one tick: 50 mm/s at 1 kHz [m]
PATHS, LENGTH, SMOOTH = 4, 0.3, 2e-3  # sections of a mesh; length of each, and its smoothing [m]
LARGE_DEG = 5.0  # counted change of the direction in one tick
FELT = 0.05  # smallest force whose direction counts [N]
_DOWN = 400  # samples of the approach


class Slides(TypedDict):
    """Steps of the force in one tick, over all slides of one mesh at one depth."""

    mesh: str
    triangles: int
    radius_mm: float
    noise_mm: float  #: smoothing of the mesh (`noise:` of a scene); 0: none
    repaired: bool  #: by `palpate check --repair`
    depth_mm: float
    ticks: int
    large_share: float  #: fraction of the ticks in which the direction changes by more than LARGE_DEG
    step_deg: float  #: largest change of the direction
    step_N: float  #: largest change of the force
    limited_large_share: float  #: the same after the caps of the stage `stability`
    limited_step_deg: float
    limited_step_N: float
    true_step_deg: float | None  #: largest change of the exact force's direction; None: not known


def run(files: Sequence[Path] = (), on_row: Callable[[Slides], None] | None = None) -> list[Slides]:
    """Measure the ridges and the meshes; without files, the organs of the test data that are there."""
    rows = []
    for row in (*ridge_rows(), *(row for file in files or organ_files() for row in organ_rows(file))):
        rows.append(row)
        if on_row:
            on_row(row)
    return rows


def organ_files() -> list[Path]:
    """The organ meshes of the test data: PALPATE_DATA, or shared/data beside the repository."""
    return [file for name in ORGANS if (file := places.data() / "meshes" / f"{name}.stl").is_file()]


def organ_rows(file: Path) -> Iterator[Slides]:
    """Slides over a mesh as it is, smoothed by its estimated noise, with the recommended radius, and repaired."""
    with quiet():
        mesh = Mesh.load(file)
    suits = touchable.radius(mesh.core, RADIUS)
    noise, recommended = 1e-3 * suits.noise_mm, 1e-3 * suits.recommended_mm
    with quiet():
        smoothed = denoise(mesh, noise)
        repaired = Mesh(*repair(mesh.core, widest_hole=0.0)[:2])
    sections = list(_sections(mesh))
    variants = [(mesh, RADIUS, 0.0), (smoothed, RADIUS, noise), (repaired, RADIUS, 0.0)]
    if recommended != RADIUS:
        variants.append((mesh, recommended, 0.0))
    for each, radius, removed in variants:
        for depth in DEPTHS:
            paths = [_offset(p, n, radius - depth) for p, n in sections]
            row = _judge(file.stem, each, paths, radius, removed, depth, None)
            yield {**row, "repaired": each is repaired}


def ridge_rows() -> Iterator[Slides]:
    """Slides over the exact ridges."""
    for R in RIDGES:
        for edge in FACETS:
            with quiet():
                mesh = Mesh(*ridge(R, edge))
            for depth in DEPTHS:
                off = R + RADIUS - depth
                true = float(np.degrees(min(STEP / off, np.pi / 2))) if off > 0.0 else 90.0
                name = f"ridge {1e3 * R:g} mm, facets {1e3 * edge:g} mm"
                yield _judge(name, mesh, [_over_ridge(max(off, 0.0))], RADIUS, 0.0, depth, true)


def ridge(radius: float, edge: float) -> tuple[Array, Array]:
    """A ridge along y with flanks of 20 mm at 45 degrees: an arc around the origin, in facets of the length `edge`."""
    turns = np.linspace(-np.pi / 4, np.pi / 4, int(np.ceil(max(np.pi / 2 * radius / edge, 1e-9))) + 1)
    arc = radius * np.stack([np.sin(turns), np.cos(turns)], axis=1) if radius > 0.0 else np.zeros((1, 2))
    flank = np.linspace(0.02, 0.0, int(np.ceil(0.02 / edge)) + 1)[:-1, None]
    left, right = (np.array([s, -1.0]) / 2**0.5 for s in (-1.0, 1.0))
    profile = np.concatenate([arc[0] + flank * left, arc, arc[-1] + flank[::-1] * right])
    y = np.arange(-0.02, 0.02 + edge / 2, edge)
    x, along = (c.ravel() for c in np.meshgrid(np.arange(len(profile)), y, indexing="ij"))
    vertices = np.stack([profile[x, 0], along, profile[x, 1]], axis=1)
    a = (np.arange(len(profile) - 1)[:, None] * len(y) + np.arange(len(y) - 1)).ravel()
    b = a + len(y)
    faces = np.concatenate([np.stack([a, b, b + 1], axis=1), np.stack([a, b + 1, a + 1], axis=1)])
    return vertices, faces.astype(np.int32)


def _over_ridge(off: float) -> Array:
    """Tips (n, 3) [m] at the distance `off` from the axis of a ridge, from flank to flank, and the approach."""
    turns = np.linspace(-np.pi / 4, np.pi / 4, int(np.pi / 2 * off / STEP) + 2)
    arc = off * np.stack([np.sin(turns), np.cos(turns)], axis=1)
    flank = np.arange(0.008, 0.0, -STEP)[:, None]
    left, right = (np.array([s, -1.0]) / 2**0.5 for s in (-1.0, 1.0))
    xz = np.concatenate([arc[0] + flank * left, arc, arc[-1] + flank[::-1] * right])
    tips = np.stack([xz[:, 0], np.linspace(-1e-3, 1e-3, len(xz)), xz[:, 1]], axis=1)
    return _from_above(tips, np.array([-1.0, 0.0, 1.0]) / 2**0.5)


def _sections(mesh: Mesh) -> Iterator[tuple[Array, Array]]:
    """Points and outward normals (n, 3) along plane sections through random vertices, smoothed."""
    draw = np.random.default_rng(0)
    sigma = round(SMOOTH / STEP)
    weights = np.exp(-0.5 * (np.arange(-4 * sigma, 4 * sigma + 1) / sigma) ** 2)
    weights /= weights.sum()
    for _ in range(PATHS):
        across = draw.normal(size=3)
        walked = _walk(mesh, mesh.vertices[draw.integers(len(mesh.vertices))], across / np.linalg.norm(across))
        points, normals = (
            np.stack([np.convolve(rows[:, i], weights, mode="valid") for i in range(3)], axis=1) for rows in walked
        )
        yield points, normals / np.linalg.norm(normals, axis=1, keepdims=True)


def _walk(mesh: Mesh, start: Array, across: Array) -> tuple[Array, Array]:
    """Points and normals (n, 3) of the surface in steps along its section with the plane normal to `across`."""
    points, normals = np.empty((round(LENGTH / STEP), 3)), np.empty((round(LENGTH / STEP), 3))
    at, way = start, np.cross(across, [0.3, 0.5, 0.8])
    for k in range(len(points)):
        _, q, n, _ = mesh.closest(at[None])
        points[k], normals[k] = q[0], n[0]
        along = np.cross(across, n[0])
        length = float(np.linalg.norm(along))
        if length > 0.2:  # elsewhere the surface is nearly parallel to the plane: the walk goes straight on
            way = along / length
        at = q[0] + STEP * way
        at = at - across * float((at - start) @ across)
    return points, normals


def _offset(points: Array, normals: Array, off: float) -> Array:
    """Tips (n, 3) [m] at the distance `off` over a section, in steps of one tick, and the approach."""
    tips = points + off * normals
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(tips, axis=0), axis=1))])
    ticks = np.arange(0.0, arc[-1], STEP)
    return _from_above(np.stack([np.interp(ticks, arc, tips[:, i]) for i in range(3)], axis=1), normals[0])


def _from_above(tips: Array, normal: Array) -> Array:
    return np.concatenate([tips[0] + normal * np.linspace(0.02, 0.0, _DOWN)[:, None], tips])


def _judge(
    name: str, mesh: Mesh, paths: Iterable[Array], radius: float, noise: float, depth: float, true: float | None
) -> Slides:
    raw, limited = [], []
    for tips in paths:
        force = render(mesh, tips, radius=radius, stiffness=STIFFNESS).force
        limiter = _verify.Limiter(_core.StabilityOptions(), 1e-3)
        raw.append(_steps(force[_DOWN:]))
        limited.append(_steps(np.array([limiter.step(F)[0] for F in force])[_DOWN:]))
    (turn, change), (turn_limited, change_limited) = (map(np.concatenate, zip(*s, strict=True)) for s in (raw, limited))
    return {
        "mesh": name, "triangles": len(mesh.triangles), "radius_mm": 1e3 * radius, "noise_mm": 1e3 * noise,
        "repaired": False, "depth_mm": 1e3 * depth, "ticks": len(change),
        "large_share": float((turn > LARGE_DEG).mean()), "step_deg": float(turn.max(initial=0.0)),
        "step_N": float(change.max()),
        "limited_large_share": float((turn_limited > LARGE_DEG).mean()),
        "limited_step_deg": float(turn_limited.max(initial=0.0)), "limited_step_N": float(change_limited.max()),
        "true_step_deg": true,
    }  # fmt: skip


def _steps(force: Array) -> tuple[Array, Array]:
    """Changes in one tick of a force (n, 3): of its direction [deg], 0 where it is not felt, and of the force [N]."""
    a, b = force[:-1], force[1:]
    turn = np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), (a * b).sum(axis=1)))
    felt = np.linalg.norm(force, axis=1) > FELT
    return np.where(felt[:-1] & felt[1:], turn, 0.0), np.linalg.norm(b - a, axis=1)


def table(rows: Iterable[Slides]) -> Table:
    """The rows for a terminal."""
    out = Table(title="slides at 50 mm/s, k = 500 N/m: largest steps in 1 ms", box=None, padding=(0, 1, 0, 0))
    columns = ("mesh", "repaired", "r\nmm", "noise\nmm", "depth\nmm", f"over\n{LARGE_DEG:g} deg", "step\ndeg", "\nN")
    for i, column in enumerate((*columns, "after caps\ndeg", "\nN", "exact\ndeg")):
        out.add_column(column, justify="left" if i == 0 else "right", no_wrap=True)
    for r in rows:
        true = r["true_step_deg"]
        out.add_row(
            r["mesh"], "yes" if r["repaired"] else "",
            f"{r['radius_mm']:g}", f"{r['noise_mm']:.2g}", f"{r['depth_mm']:g}",
            f"{100 * r['large_share']:.2f} %", f"{r['step_deg']:.1f}", f"{r['step_N']:.2f}",
            f"{r['limited_step_deg']:.1f}", f"{r['limited_step_N']:.2f}", "" if true is None else f"{true:.1f}",
        )  # fmt: skip
    return out
