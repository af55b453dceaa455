"""Is a triangle mesh fit to be touched? Welding, winding, holes: counted, mended where that is safe, and told."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from palpate import mesh_topology as topology
from palpate.mesh_topology import Triangles, Vertices

#: Sizes an organ, a bone or a phantom may have [m]; outside, the unit is doubted.
PLAUSIBLE_SIZE = (0.005, 2.0)
_LIKELY_SIZE = (0.03, 0.7)
UNITS = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "in": 0.0254}


@dataclass(frozen=True)
class Finding:
    """One thing that is wrong with a mesh, what Palpate did about it, and what the user can do."""

    what: str
    why: str = ""
    mend: str = ""


@dataclass(frozen=True)
class MeshReport:
    """What was found in a mesh. Counts are of the file's triangles; the mesh in use is what is left."""

    vertices: int  # after welding
    triangles: int  # in use
    extents_m: tuple[float, float, float]
    components: int
    watertight: bool
    volume_m3: float  # of the closed parts; 0 when there is none
    open_edges: int
    non_manifold_edges: int
    degenerate: int  # dropped
    duplicate: int  # dropped
    turned: int  # triangles whose winding was turned to match their neighbours
    inverted: int  # triangles of closed parts that were inside out, turned
    findings: tuple[Finding, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """The report as plain JSON values (units in the keys)."""
        return asdict(self)


def prepare(vertices: Vertices, triangles: Triangles, unit: str = "m") -> tuple[Vertices, Triangles, MeshReport]:
    """Weld, drop what has no area, turn what is wound the wrong way, and say so.

    Args:
        vertices: (n, 3) finite [m].
        triangles: (m, 3) indices into ``vertices``, m >= 1.
        unit: of the file, a key of ``UNITS``; for advice about a wrong one.

    Returns:
        Welded vertices [m], the triangles in use (maybe none), and the report.
    """
    vertices, triangles = topology.weld(vertices, triangles)
    given = len(triangles)
    triangles = triangles[topology.distinct_corners(triangles)]
    edges = topology.Edges.of(triangles, len(vertices))
    duplicate = turned = inverted = 0
    if edges.crowded or edges.clashing:  # a triangle that is there twice makes its edges so
        once = topology.first_of_each(triangles)
        duplicate = len(triangles) - int(once.sum())
        triangles = triangles[once]
        edges = topology.Edges.of(triangles, len(vertices))
    orientable = True
    if edges.clashing:
        flip, orientable = topology.orient(edges, len(triangles))
        turned = int(flip.sum())
        triangles = topology.turned(triangles, flip)
        edges = topology.Edges.of(triangles, len(vertices))
    label, components = topology.components(len(vertices), triangles[:, :2], triangles[:, 1:])
    wedge = topology.wedges(vertices, triangles)
    flip, volume = topology.inside_out(vertices, triangles, wedge, label[triangles[:, 0]], edges)
    if flip.any():
        inverted = int(flip.sum())
        triangles = topology.turned(triangles, flip)
    flat = ~topology.normals(vertices, triangles).any(axis=1)
    if flat.any():
        triangles = triangles[~flat]
    size = np.ptp(vertices, axis=0) if len(vertices) else np.zeros(3)
    report = MeshReport(
        vertices=len(vertices),
        triangles=len(triangles),
        extents_m=(float(size[0]), float(size[1]), float(size[2])),
        components=components,
        watertight=edges.open == 0 and edges.clashing == 0,
        volume_m3=volume,
        open_edges=edges.open,
        non_manifold_edges=edges.crowded,
        degenerate=given - duplicate - len(triangles),
        duplicate=duplicate,
        turned=turned,
        inverted=inverted,
    )
    return vertices, triangles, replace(report, findings=_findings(report, orientable, unit))


def sound(vertices: Vertices, triangles: Triangles, unit: str) -> MeshReport | None:
    """The report of a closed, welded mesh [m] without a fault; None when a part of it is inside out after all."""
    label, components = topology.components(len(vertices), triangles[:, :2], triangles[:, 1:])
    wedge = np.concatenate(
        [topology.wedges(vertices, t) for t in np.array_split(triangles, len(triangles) // 100_000 + 1)]
    )
    flip, volume = topology.inside_out(vertices, triangles, wedge, label[triangles[:, 0]], None)
    if flip.any():
        return None
    size = np.ptp(vertices, axis=0)
    extents = (float(size[0]), float(size[1]), float(size[2]))
    n, m = len(vertices), len(triangles)
    report = MeshReport(n, m, extents, components, True, volume, 0, 0, 0, 0, 0, 0)
    return replace(report, findings=_findings(report, True, unit))


def _findings(r: MeshReport, orientable: bool, unit: str) -> tuple[Finding, ...]:
    found = []
    if r.degenerate:
        found.append(Finding(f"{r.degenerate:,} degenerate triangles (no area): dropped"))
    if r.duplicate:
        found.append(Finding(f"{r.duplicate:,} duplicate triangles: dropped"))
    if not orientable:
        found.append(
            Finding(
                "the winding cannot be made consistent: the surface has no two sides",
                "forces may point inwards on part of it",
                "repair the mesh, e.g. remesh it as a closed surface",
            )
        )
    elif r.turned:
        found.append(
            Finding(
                f"inconsistent winding: {r.turned:,} triangles face the other way than their neighbours: turned",
                "the winding says which side is outside",
                "recompute the normals in the program that made the mesh",
            )
        )
    if r.inverted:
        found.append(
            Finding(
                f"inverted winding: {r.inverted:,} triangles of closed parts are inside out: turned",
                "the enclosed volume came out negative",
                "flip the normals in the program that made the mesh",
            )
        )
    if r.non_manifold_edges:
        found.append(
            Finding(
                f"{r.non_manifold_edges:,} edges are shared by more than two triangles",
                "inside walls or parts that touch",
            )
        )
    if r.open_edges:
        found.append(
            Finding(
                f"the surface is open: {r.open_edges:,} edges have one triangle only",
                "it is felt from the side it faces; through a hole the tool gets in without a force",
                "close the holes if the tool goes there",
            )
        )
    found.extend(_size_finding(max(r.extents_m), unit))
    return tuple(found)


def _size_finding(size: float, unit: str) -> list[Finding]:
    low, high = PLAUSIBLE_SIZE
    if low <= size <= high or size == 0.0:
        return []
    numbers = size / UNITS[unit]
    likely = [u for u, scale in UNITS.items() if _LIKELY_SIZE[0] <= numbers * scale <= _LIKELY_SIZE[1]]
    mend = f"unit: {likely[0]} would make it {numbers * UNITS[likely[0]]:.3g} m" if likely else "scale the mesh"
    return [Finding(f"the largest extent is {size:.3g} m with unit {unit}: is the unit right?", "", mend)]
