"""Report on a triangle mesh: what the core counted and repaired (welding, winding, holes), as findings for users."""

from __future__ import annotations

from dataclasses import dataclass, replace

from palpate import _core
from palpate.base.values.units import FILE_UNITS

#: Plausible extents of an organ, a bone or a phantom [m]; beyond them, the unit is questioned.
PLAUSIBLE_SIZE = (0.005, 2.0)
_LIKELY_SIZE = (0.03, 0.7)


@dataclass(frozen=True)
class Finding:
    """One fault of a mesh, its consequence, and what the user can do about it."""

    what: str
    why: str = ""
    mend: str = ""


@dataclass(frozen=True)
class MeshReport:
    """Report on a mesh; the names contain the units. Counts of faults refer to the triangles of the file."""

    vertices: int  # after welding
    triangles: int  # in use
    extents_m: tuple[float, float, float]
    components: int
    watertight: bool
    volume_m3: float  # enclosed volume of the closed parts; 0 for an open mesh
    open_edges: int
    non_manifold_edges: int
    degenerate: int  # dropped
    duplicate: int  # dropped
    turned: int  # triangles whose winding was reversed to match their neighbours
    inverted: int  # triangles of closed parts that were inside out; their winding was reversed
    findings: tuple[Finding, ...] = ()


def report_of(core: _core.MeshReport, unit: str = "m") -> MeshReport:
    """Report from the core's counts; ``unit`` (a key of ``FILE_UNITS``) is that of the file, for advice on the unit."""
    x, y, z = (float(e) for e in core.highest - core.lowest)
    report = MeshReport(
        vertices=core.vertices,
        triangles=core.triangles,
        extents_m=(x, y, z),
        components=core.parts,
        watertight=core.boundary_edges == 0 and core.inconsistent_edges == 0,
        volume_m3=core.volume,
        open_edges=core.boundary_edges,
        non_manifold_edges=core.branching_edges,
        degenerate=core.degenerate,
        duplicate=core.duplicate,
        turned=core.turned,
        inverted=core.inverted,
    )
    return replace(report, findings=_findings(report, core.two_sided, unit))


def _findings(r: MeshReport, two_sided: bool, unit: str) -> tuple[Finding, ...]:
    found = []
    if r.degenerate:
        found.append(Finding(f"{r.degenerate:,} degenerate triangles (no area): dropped"))
    if r.duplicate:
        found.append(Finding(f"{r.duplicate:,} duplicate triangles: dropped"))
    found.extend(_winding_findings(r, two_sided))
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
                "it is felt from either side and has no inside; through a hole the tool gets in without a force",
                "close the holes if the tool goes there: palpate check FILE --repair mended.stl fills small ones",
            )
        )
    found.extend(_size_finding(max(r.extents_m), unit))
    return tuple(found)


def _winding_findings(r: MeshReport, two_sided: bool) -> list[Finding]:
    found = []
    if not two_sided:
        found.append(
            Finding(
                "the winding cannot be made consistent: the surface has no two sides",
                "forces may point inwards on part of it",
                "palpate check FILE --repair mended.stl, or remesh it as a closed surface",
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
    return found


def _size_finding(size: float, unit: str) -> list[Finding]:
    low, high = PLAUSIBLE_SIZE
    if low <= size <= high or size == 0.0:
        return []
    numbers = size / FILE_UNITS[unit]
    likely = [u for u, scale in FILE_UNITS.items() if _LIKELY_SIZE[0] <= numbers * scale <= _LIKELY_SIZE[1]]
    mend = f"unit: {likely[0]} would make it {numbers * FILE_UNITS[likely[0]]:.3g} m" if likely else "scale the mesh"
    return [Finding(f"the largest extent is {size:.3g} m with unit {unit}: is the unit right?", "", mend)]
