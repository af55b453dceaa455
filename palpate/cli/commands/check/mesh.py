"""`palpate check` of a mesh: its defects, how its facets would be felt, a suitable radius, and a repaired copy."""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from palpate import _core
from palpate.base.arrays.plain import Content
from palpate.base.errors import MeshError, OutputError, PalpateError, PalpateWarning
from palpate.base.values.units import FILE_UNITS
from palpate.cli.terminal.output import say
from palpate.scene.contact import touchable
from palpate.world.mesh import Mesh, Unit, check, quiet
from palpate.world.mesh import files as mesh_files
from palpate.world.mesh import repair as mesh_repair
from palpate.world.mesh.volumes import Selection


@dataclass(frozen=True)
class Touch:
    """How the mesh will be touched: lengths [m], stiffness [N/m], and where the repaired copy goes."""

    radius: float
    stiffness: float
    feature: float | None
    noise: float | None
    repair: Path | None
    hole: float | None
    force: bool

    @classmethod
    def of(
        cls,
        radius: float | None,
        stiffness: float | None,
        feature: float | None,
        noise: float | None,
        repair: Path | None,
        hole: float | None,
        force: bool,
    ) -> Touch:
        """Make the settings from the options of the command line, whose lengths are in millimetres.

        Raises:
            PalpateError: a number is not positive.
        """
        given = {"radius": radius, "stiffness": stiffness, "feature": feature, "noise": noise, "hole": hole}
        for name, value in given.items():
            if value is not None and not (math.isfinite(value) and (value > 0 or (name == "noise" and value == 0))):
                raise PalpateError(f"--{name} must be a positive number, got {value:g}", mend=f"e.g. --{name} 2")
        mm = {name: None if x is None else 1e-3 * x for name, x in given.items()}
        return cls(
            mm["radius"] or _core.ContactOptions().radius,
            stiffness or float(_core.Material().K[0]),
            mm["feature"],
            mm["noise"],
            repair,
            mm["hole"],
            force,
        )


@dataclass(frozen=True)
class RepairedCopy:
    """A repaired copy of a mesh; see `palpate.world.mesh.repair.Repairs` for the counts."""

    file: str
    sewn: int
    collapsed: int
    flipped: int
    filled: int
    left_open: int
    widest_left_mm: float
    after: check.MeshReport


@dataclass(frozen=True)
class Findings:
    """What `palpate check` finds on a mesh, as docs/json.md describes it."""

    mesh: check.MeshReport
    fineness: touchable.Fineness
    radius: Content
    repair: RepairedCopy | None


def inspect(path: Path, unit: Unit | None, part: Selection, touch: Touch, console: Console) -> Findings:
    """Print the findings on a mesh file, and return them."""
    if touch.repair is not None:
        _require_free(touch.repair, path, touch.force)
    mesh = Mesh.load(path, unit, label=part.label, threshold=part.threshold)
    fine = touchable.fineness(mesh.core, touch.stiffness)
    suits = touchable.radius(mesh.core, touch.radius, feature=touch.feature, noise=touch.noise)
    table = Table(show_header=False, box=None, pad_edge=False)
    for name, value in (*_rows(mesh.core, mesh.report, mesh.unit), *_touch_rows(fine, suits, touch)):
        table.add_row(name, value)
    console.print(table)
    touchable.warn_of_facets(fine, str(path))
    _warn_of_radius(suits, str(path))
    repaired = _repair(mesh, touch.repair, mesh.unit, touch, console) if touch.repair is not None else None
    return Findings(mesh.report, fine, suits.figures(), repaired)


def _warn_of_radius(suits: touchable.Radius, where: str) -> None:
    """Warn of a radius that the noise or the features of the mesh do not allow."""
    if suits.conflict:
        what = (
            f"no radius suits: noise of {suits.noise_mm:.2g} mm needs {suits.smallest_mm:.2g} mm or more, the "
            f"features need {suits.largest_mm:.2g} mm or less"
        )
        why = f"at {suits.recommended_mm:g} mm the noise turns the force by {suits.direction_noise_deg:.0f} deg"
        mend = f"{_smoothed(suits)}, or filter the force: stability.rate_cap of 5 to 10 N/s (palpate study radius)"
        warnings.warn(PalpateWarning(what, where=where, why=why, mend=mend), stacklevel=2)
    elif suits.smallest_mm == 0.0 and suits.direction_noise_deg > touchable.DIRECTION_LIMIT_DEG:
        what = f"noise of {suits.noise_mm:.2g} mm turns the force by {suits.direction_noise_deg:.0f} deg at any radius"
        why = "the surface that is felt goes through every vertex"
        warnings.warn(PalpateWarning(what, where=where, why=why, mend=_smoothed(suits)), stacklevel=2)
    elif suits.given_mm < 0.99 * suits.smallest_mm:
        what = f"radius {suits.given_mm:g} mm is small for noise of {suits.noise_mm:.2g} mm"
        limit = f"{touchable.DIRECTION_LIMIT_DEG:g} deg"
        why = f"below {suits.smallest_mm:.2g} mm the noise turns the force by more than {limit}"
        warnings.warn(PalpateWarning(what, where=where, why=why, mend=f"{suits.recommended_mm:g} mm"), stacklevel=2)
    elif suits.given_mm > 1.01 * suits.largest_mm:
        what = f"radius {suits.given_mm:g} mm is too large to feel {suits.feature_mm:.2g} mm"
        why = f"{suits.unreachable_share:.1%} of the surface lies in hollows tighter than this radius"
        warnings.warn(PalpateWarning(what, where=where, why=why, mend=f"{suits.recommended_mm:g} mm"), stacklevel=2)


def _smoothed(suits: touchable.Radius) -> str:
    """The key of a scene that removes the noise."""
    return f"smooth the mesh: noise: {suits.noise_mm:.2g}mm beside mesh: in the scene"


def _rows(core: _core.Mesh, r: check.MeshReport, unit: Unit) -> tuple[tuple[str, str], ...]:
    x, y, z = (1e3 * e for e in r.extents_m)
    small = mesh_repair.small_parts(core) if r.components > 1 else 0
    return (
        ("triangles", f"{r.triangles:,}"),
        ("vertices", f"{r.vertices:,}"),
        ("extents", f"{x:.1f} x {y:.1f} x {z:.1f} mm (file in {unit})"),
        ("parts", f"{r.components:,}" + (f", {small:,} of them below 1 % of the triangles" if small else "")),
        ("closed", "yes" if r.watertight else f"no: {r.open_edges:,} open edges"),
        ("volume", f"{1e6 * r.volume_m3:,.3g} cm^3" if r.watertight else "-"),
        ("dropped", f"{r.degenerate:,} degenerate, {r.duplicate:,} duplicate"),
        ("turned", f"{r.turned:,} inconsistent, {r.inverted:,} inside out"),
    )


def _touch_rows(fine: touchable.Fineness, suits: touchable.Radius, touch: Touch) -> tuple[tuple[str, str], ...]:
    bounds = [f"up to {suits.largest_mm:.2g} mm reaches into the hollows"] if math.isfinite(suits.largest_mm) else []
    if suits.smallest_mm:
        bounds.append(f"noise of {suits.noise_mm:.2g} mm needs {suits.smallest_mm:.2g} mm or more")
    turn, depth = touchable.turn_per_ms_deg(touch.radius), 1.0 / touch.stiffness
    deep, mm = touchable.turn_per_ms_deg(touch.radius, depth), 1e3 * depth
    return (
        (
            "facets",
            f"edges of {fine.edge_mm:.2g} mm; 95 % turn by less than {fine.turn_deg:.2g} deg; "
            f"{fine.stepping_share:.1%} of the surface is on slivers or creases, where the force may step",
        ),
        (
            "felt",
            f"force off by {fine.direction_error_deg:.2g} deg, {fine.force_error_mN:.2g} mN at {touch.stiffness:g} N/m "
            f"(without smoothing {fine.turn_deg / 2:.2g} deg, {fine.facet_error_mN:.2g} mN)",
        ),
        ("radius", "; ".join([f"{suits.recommended_mm:g} mm suits", *bounds])),
        (
            "sharp edges",
            f"rounded by {suits.given_mm:g} mm: at 50 mm/s the force turns by {turn:.2g} deg per millisecond"
            + (f", {deep:.2g} deg at 1 N" if math.isfinite(deep) else "")
            + (
                ""
                if math.isfinite(deep)
                else f"; at 1 N ({mm:.2g} mm deep) it jumps: a radius above {mm:.2g} mm turns it"
            ),
        ),
    )


def _require_free(out: Path, source: Path, force: bool) -> None:
    if out.exists() and not force:
        what = "this is the mesh itself" if out.samefile(source) else "the file exists"
        raise OutputError(what, where=str(out), mend="choose another name, or --force to overwrite it")


def _repair(mesh: Mesh, file: Path, unit: Unit, touch: Touch, console: Console) -> RepairedCopy:
    widest = touch.hole if touch.hole is not None else 0.1 * float(np.linalg.norm(mesh.report.extents_m))
    vertices, triangles, done = mesh_repair.repair(mesh.core, widest)
    mesh_files.write(file, vertices / FILE_UNITS[unit], triangles)
    with quiet():
        try:
            after = Mesh.load(file, unit)
        except MeshError as error:  # a format that cannot be read back
            raise OutputError("the repaired copy cannot be read back", where=str(file), why=error.what) from None
    console.print(_comparison(mesh, after))
    left = f", {done.left_open} left open (the widest {done.widest_left_mm:.1f} mm)" if done.left_open else ""
    say(
        console,
        f"{file}: sewn {done.sewn} rim vertices, collapsed {done.collapsed} slivers, flipped {done.flipped} edges of "
        f"thin triangles, filled holes: {done.filled}{left}",
    )
    return RepairedCopy(
        file=str(file),
        sewn=done.sewn,
        collapsed=done.collapsed,
        flipped=done.flipped,
        filled=done.filled,
        left_open=done.left_open,
        widest_left_mm=done.widest_left_mm,
        after=after.report,
    )


def _comparison(before: Mesh, after: Mesh) -> Table:
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for heading in ("repaired copy", "before", "after"):
        table.add_column(heading, justify="left" if heading == "repaired copy" else "right")
    rows = {
        "triangles": [f"{m.report.triangles:,}" for m in (before, after)],
        "parts": [f"{m.report.components:,}" for m in (before, after)],
        "closed": ["yes" if m.report.watertight else "no" for m in (before, after)],
        "open edges": [f"{m.report.open_edges:,}" for m in (before, after)],
        "edges of many triangles": [f"{m.report.non_manifold_edges:,}" for m in (before, after)],
        "volume, cm^3": [f"{1e6 * m.report.volume_m3:,.4g}" if m.report.watertight else "-" for m in (before, after)],
    }
    for name, values in rows.items():
        table.add_row(name, *values)
    return table
