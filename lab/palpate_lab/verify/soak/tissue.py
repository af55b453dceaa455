"""``palpate soak tissue``: random pokes, slides and grasps of soft bodies, one after another on each body.

The actions and their evaluation are in C++ (``core/palpate/verify/tissue_soak.hpp``); this module makes the bodies.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from time import perf_counter

import numpy as np
from rich.table import Table

from palpate import _verify
from palpate.base.arrays import Array
from palpate.world.tissue import PRESETS, Tissue
from palpate.world.tissue.blocks import block

POKES = 10_000
PER_BODY = 25  # actions on a body before it is made anew
BODIES = ("liver", "kidney", "silicone_20kPa", "liver_diseased", "silicone_60kPa")
_SIZE = np.array([0.06, 0.06, 0.03])  # [m]
_CELLS = ((6, 6, 3), (5, 5, 4), (8, 8, 4))
_RADIUS = 5e-3  # of the tool [m]
_LARGE = (1.0, 1.5, 0.67)
"""Radii of the tool over the length of a cell, for every second body."""
_AROUND = 6.0  # width of such a body, twice its thickness [radius]
_DEEPEST = 2.5  # longest way into such a body [radius]

_COUNTS = ("pokes", "slides", "grasps", "hard", "touched", "ticks", "held", "restless", "not_finite", "popped",
           "guarded", "guarded_hard", "hurried", "rests", "inverted_at_rest", "moved_at_rest")  # fmt: skip


@dataclass
class Body:
    """Counts of the actions on bodies of one material."""

    material: str
    counts: dict[str, int] = field(default_factory=lambda: dict.fromkeys(_COUNTS, 0))
    least_volume: float = 1.0  #: smallest det F in an action [-]
    least_volume_at_rest: float = 1.0  #: the same at rest [-]
    largest_force_N: float = 0.0  #: of the actions up to 3 N


@dataclass
class TissueSoak:
    """Counts of a soak run. The keys are the documented contract of ``--json``."""

    seed: int
    actions: int = 0
    seconds: float = 0.0
    bodies: list[Body] = field(default_factory=list)

    def total(self, name: str) -> int:
        """Sum of a count over all materials."""
        return sum(body.counts[name] for body in self.bodies)

    @property
    def failures(self) -> int:
        """Number of events that must not happen: below 3 N the guard, at any force what is never right."""
        return sum(
            map(self.total, ("not_finite", "popped", "restless", "guarded", "inverted_at_rest", "moved_at_rest"))
        )


def run(
    actions: int = POKES,
    seed: int = 1,
    on_progress: Callable[[TissueSoak], None] | None = None,
    range_: _verify.TissueSoakRange | None = None,
) -> TissueSoak:
    """Run random actions, shared out over the materials; the same seed gives the same actions.

    Args:
        actions: number of pokes, slides and grasps.
        seed: of the actions.
        on_progress: called after each body.
        range_: ranges of the actions; by default up to 3 N and 1 m/s, and 2 % of them up to 20 N.

    Raises:
        ValueError: ``actions`` is below 1.
    """
    if actions < 1:
        raise ValueError(f"pokes must be at least 1, got {actions}")
    out, start = TissueSoak(seed, bodies=[Body(name) for name in BODIES]), perf_counter()
    for k in range(-(-actions // PER_BODY)):
        into, count = out.bodies[k % len(BODIES)], min(PER_BODY, actions - out.actions)
        _add(into, _at_one_body(into.material, count, seed + k, *_blocks(k), _range(k, range_)))
        out.actions += count
        out.seconds = perf_counter() - start
        if on_progress:
            on_progress(out)
    return out


def _blocks(k: int) -> tuple[tuple[int, int, int], Array]:
    """Cells and size [m] of the body with the number k: with cells larger than the tool, or smaller ones by turns."""
    if k % 2 == 0:
        return _CELLS[k // 2 % len(_CELLS)], _SIZE
    through = max(3, round(0.5 * _AROUND * _LARGE[k // 2 % len(_LARGE)]))
    cell = _RADIUS / _LARGE[k // 2 % len(_LARGE)]
    return (2 * through, 2 * through, through), cell * np.array([2.0 * through, 2.0 * through, through])


def _range(k: int, given: _verify.TissueSoakRange | None) -> _verify.TissueSoakRange:
    """The range for the body with the number k: those with smaller cells are pressed less deep."""
    out = _verify.TissueSoakRange()
    for name in [name for name in dir(out) if given is not None and not name.startswith("_")]:
        setattr(out, name, getattr(given, name))
    if k % 2 == 1:
        out.depth = min(out.depth, _DEEPEST * _RADIUS)
    return out


def _at_one_body(
    material: str,
    count: int,
    seed: int,
    cells: tuple[int, int, int],
    size: Array,
    range_: _verify.TissueSoakRange | None,
) -> _verify.TissueSoakReport:
    nodes, tets = block(cells, size)
    nodes = nodes - [0.5 * size[0], 0.5 * size[1], size[2]]
    m, held = PRESETS[material], nodes[:, 2] < -0.999 * size[2]
    soft = Tissue((nodes, tets), young=m.young, poisson=m.poisson, density=m.density, yeoh=m.yeoh, prony=m.prony,
                  fixed=held, thread="cycle")  # fmt: skip
    return _verify.soak_tissue(soft.core, count, seed, -float(size[2]), range_ or _verify.TissueSoakRange())


def _add(into: Body, report: _verify.TissueSoakReport) -> None:
    for name in _COUNTS:
        into.counts[name] += getattr(report, name)
    into.least_volume = min(into.least_volume, report.least_volume)
    into.least_volume_at_rest = min(into.least_volume_at_rest, report.least_volume_at_rest)
    into.largest_force_N = max(into.largest_force_N, report.largest_force)


def table(done: TissueSoak) -> Table:
    """The counts by material."""
    shown = Table(title=f"{done.actions:,} actions on soft bodies, seed {done.seed}, {done.seconds:.0f} s")
    for name in ("material", "touched", "held", "restless", "not finite", "popped", "guard to 3 N", "guard beyond",
                 "rests", "inverted", "moved", "least det F", "at rest"):  # fmt: skip
        shown.add_column(name, justify="left" if name == "material" else "right")
    for body in done.bodies:
        c = body.counts
        shown.add_row(
            body.material, *(f"{c[k]:,}" for k in ("touched", "held", "restless", "not_finite", "popped", "guarded",
                                                   "guarded_hard", "rests", "inverted_at_rest", "moved_at_rest")),
            f"{body.least_volume:.3f}", f"{body.least_volume_at_rest:.4f}",
        )  # fmt: skip
    return shown
