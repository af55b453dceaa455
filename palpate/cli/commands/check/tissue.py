"""`palpate check` of the soft tissue in a scene: quality of its tetrahedra, and the time step."""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np

from palpate.base.errors import PalpateWarning
from palpate.world.tissue import Tissue, edge_lengths, shapes
from palpate.world.tissue.element_quality import POOR

MUCH_MASS = 20.0
"""Added mass above which the motion of a body is visibly slower [%]."""

THIN = 2.0
"""Thickness over the radius of the tip below which a body needs `THROUGH` [-]. The figure `layers` of `palpate bench
tissue` meets its limits with four cells through a layer as thick as 2 radii, not through one as thick as a radius."""

THROUGH = 3.5
"""Thickness over the median edge that such a body needs [-]: five cells of a layer, whose median edge is a diagonal.
The force then errs by 4.4 % and ripples by 0.7 %; with four cells it errs by 5.5 % and ripples by 1.4 %."""


_POISSON = (0.0, 0.3, 0.45, 0.49, 0.495)
_ONE_CELL = (0.58, 0.40, 0.64, 1.42, 1.77)
"""Excess of the stiffness in bending of plates that are one cell thick, by Poisson's ratio; bars and twist err less."""

_MORE_CELLS = 0.10
"""Largest error of bending and twist from two cells on [-], of parts four times as long as thick
(tests/tissue/test_bending.py)."""

_STUBBY = (1.5, 2.0, 3.0, 4.0)
_SHORT = {0.3: (0.13, 0.12, 0.11, 0.10), 0.45: (0.16, 0.13, 0.11, 0.10), 0.49: (0.26, 0.20, 0.12, 0.10)}
"""Largest error of shorter parts of two cells, by Poisson's ratio, at these lengths over the thickness [-]."""

_THIN_SHARE = 0.05
"""Share of the nodes in parts of one tetrahedron's thickness from which a body is told to be thin [-]."""

JUDGED_TIPS = (0.13, 3.5)
"""Radius of a tip over the mean edge of the surface for which `palpate bench tissue --only stillness` judges whether
the force comes to rest: .15 to 4 cells, where an edge is 1.14 cells [-]."""

JUDGED_PERIOD = 4.0
"""Longest period of a thread for which the force of a body of up to 20 kPa comes to rest within 2 mN [ms]."""

_SWING = 65
"""Largest force, peak to peak, that swings at rest after a press with longer periods, up to 20 ms [mN]."""


@dataclass(frozen=True)
class TissueFindings:
    """Soft tissue of an object."""

    tets: int
    nodes: int
    edge_mm: float  # median length of the edges
    shortest_edge_mm: float
    worst_quality: float  # 1: regular tetrahedron, 0: flat
    poor_tets: int  # with a quality below POOR
    stable_step_ms: float  # longest stable time step without added mass
    step_ms: float  # time step
    added_mass_percent: float  # mass added for this time step
    thread_period_ms: float  # of a thread of its own; 0: it steps in the haptic cycle
    thickness_mm: float  # smallest extent at rest, in the axes of the object
    longest_edge_for_tip_mm: float | None  # median edge that the largest tip needs; None: the body is not thin
    one_cell_percent: float  # share of the nodes in parts that are one tetrahedron thick
    bending_error_percent: float  # predicted: by how much such parts, or stubby ones of two cells, are too stiff

    tip_over_edge: float  # radius of the largest tip over the mean edge of the surface [-]


def inspect_tissue(soft: Tissue, radius: float = 0.0) -> TissueFindings:
    """Judge the tetrahedra and the time step of a soft body. radius: of the largest sphere that touches it [m]."""
    quality, edges = shapes(soft), edge_lengths(soft)
    thickness = float(np.ptp(soft.nodes, axis=0).min())
    one_cell = float(np.mean(soft.body.layers() == 0))
    bending = float(np.interp(soft.poisson, _POISSON, _ONE_CELL)) if one_cell > _THIN_SHARE else _of_more_cells(soft)
    return TissueFindings(
        tets=len(soft.tets),
        nodes=len(soft.nodes),
        edge_mm=1e3 * float(np.median(edges)),
        shortest_edge_mm=1e3 * float(edges.min()),
        worst_quality=float(quality.min()),
        poor_tets=int((quality < POOR).sum()),
        stable_step_ms=1e3 * soft.body.stable_step(),
        step_ms=1e3 * soft.body.time_step,
        added_mass_percent=100.0 * soft.body.added_mass(),
        thread_period_ms=1e3 * soft.period,
        thickness_mm=1e3 * thickness,
        longest_edge_for_tip_mm=1e3 * thickness / THROUGH if thickness < THIN * radius else None,
        one_cell_percent=100.0 * one_cell,
        bending_error_percent=100.0 * bending,
        tip_over_edge=radius / soft.core.edge,
    )


def _of_more_cells(soft: Tissue) -> float:
    """Largest error of bending and twist of a body of two or more cells [-]. It bends over its shorter side, or a bar
    over its length."""
    if soft.body.layers().max() > 1:
        return _MORE_CELLS
    thickness, *others = np.sort(np.ptp(soft.nodes, axis=0))
    over = min((side for side in others if side > 1.2 * thickness), default=thickness) / thickness
    return float(np.interp(soft.poisson, list(_SHORT), [np.interp(over, _STUBBY, row) for row in _SHORT.values()]))


def warn_of_tissue(found: TissueFindings, where: str) -> None:
    """Warn of a mesh whose motion or time step suffers."""
    if found.added_mass_percent > MUCH_MASS:
        what = f"{where}: {found.added_mass_percent:.0f} % of mass is added to make the time step stable"
        mend = (
            "it swings more slowly than it should: a coarser resolution, a lower modulus or a smaller step needs less"
        )
        warnings.warn(PalpateWarning(what, mend=mend), stacklevel=2)
    needed = found.longest_edge_for_tip_mm
    if needed is not None and found.edge_mm > 1.01 * needed:
        what = (
            f"{where}: {found.thickness_mm:.3g} mm thick, less than the tip's diameter, with edges of "
            f"{found.edge_mm:.3g} mm: the force on the tip errs by more than 5 %"
        )
        warnings.warn(PalpateWarning(what, mend=f"edges of {needed:.2g} mm, or a smaller tip"), stacklevel=2)
    if found.one_cell_percent > 100.0 * _THIN_SHARE:
        what = (
            f"{where}: {found.one_cell_percent:.0f} % of the nodes are in parts that are one tetrahedron thick, which "
            f"are about {found.bending_error_percent:.0f} % too stiff in bending"
        )
        mend = f"a resolution of half their thickness, with which the error is at most {100.0 * _MORE_CELLS:.0f} %"
        warnings.warn(PalpateWarning(what, mend=mend), stacklevel=2)

    least, most = JUDGED_TIPS
    if found.tip_over_edge > 0.0 and not least <= found.tip_over_edge <= most:
        what = (
            f"{where}: the radius of the tip is {found.tip_over_edge:.2g} of an edge of the surface: whether its force "
            f"comes to rest is judged from {least:g} to {most:g}"
        )
        fit = "a finer" if found.tip_over_edge < least else "a coarser"
        mend = f"{fit} resolution, or press it with `palpate.contact.render` and look at the force at rest"
        warnings.warn(PalpateWarning(what, mend=mend), stacklevel=2)
    if found.thread_period_ms > JUDGED_PERIOD:
        what = (
            f"{where}: its thread steps every {found.thread_period_ms:g} ms: after a press the force at rest may swing "
            f"by {_SWING} mN; with {JUDGED_PERIOD:g} ms, and up to 20 kPa, by 2 mN"
        )
        warnings.warn(PalpateWarning(what, mend="a shorter period, or a coarser resolution"), stacklevel=2)
    if found.poor_tets:
        what = f"{where}: {found.poor_tets:,} tetrahedra are poor (quality below {POOR:g})"
        mend = "they shorten the time step: mesh the volume again, or leave out volume: and let resolution: fill it"
        warnings.warn(PalpateWarning(what, mend=mend), stacklevel=2)


def tissue_words(found: TissueFindings) -> str:
    """The findings in a sentence."""
    poor = f", {found.poor_tets:,} are poor (below {POOR:g})" if found.poor_tets else ""
    beside = (
        f"on a thread of its own, every {found.thread_period_ms:g} ms" if found.thread_period_ms else "in the cycle"
    )
    stiff = found.bending_error_percent
    bends = f", up to {stiff:.0f} % too stiff in bending" if stiff > 100.0 * _MORE_CELLS else ""
    return (
        f"{found.tets:,} tetrahedra with {found.nodes:,} nodes, edges of {found.edge_mm:.3g} mm (shortest "
        f"{found.shortest_edge_mm:.2g} mm), worst quality {found.worst_quality:.2f}{poor}; time step "
        f"{found.step_ms:.3g} ms with {found.added_mass_percent:.3g} % added mass (without any: "
        f"{found.stable_step_ms:.3g} ms), {beside}{bends}"
    )
