"""All figures by name, their run, and their table."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

from palpate_lab.verify.bench.tissue import (
    both_kernels,
    finding,
    flex,
    holding,
    large_strain,
    layers,
    lump,
    port_energy,
    relaxing,
    stillness,
    theories,
    threads,
    ticks,
)
from palpate_lab.verify.bench.tissue.bodies import Lab
from palpate_lab.verify.bench.tissue.rows import Found, Row

if TYPE_CHECKING:
    from rich.table import Table

FIGURES: dict[str, Callable[[Lab, bool], Found]] = {
    "ticks": ticks.measure,
    "threads": threads.measure,
    "realtime": threads.measure_real_time,
    "layers": layers.measure,
    "large-strain": large_strain.measure,
    "stiffening": large_strain.measure_stiffening,
    "lump": lump.measure,
    "finding": finding.measure,
    "viscosity": relaxing.measure,
    "smoothness": holding.measure,
    "stillness": stillness.measure,
    "energy": port_energy.measure,
    "kernels": both_kernels.measure,
    "theories": theories.measure,
    "mujoco": flex.measure,
}
"""Measurements by name; each takes the lab, and whether to run a short version."""

KEYS = ("tick_ms", "control_ms", "layer_error", "ripple", "mujoco")
"""Keys that ``--json`` always has; null if their figure was not run."""


def run(
    only: Iterable[str] = (),
    lab: Lab | None = None,
    *,
    short: bool = False,
    on_progress: Callable[[str], None] = lambda _: None,
) -> dict[str, Any]:
    """Measure the named figures, or all; the keys are the documented contract of ``--json``."""
    found: dict[str, Any] = dict.fromkeys(KEYS)
    rows: list[Row] = []
    for name in only or FIGURES:
        on_progress(name)
        one = FIGURES[name](lab or Lab(), short)
        rows += one.rows
        found |= one.details
    return found | {"rows": rows}


def table(figures: dict[str, Any]) -> Table:
    """The figures as a table."""
    from rich.table import Table

    out = Table(box=None)
    out.add_column("figure")
    for heading in ("value", "asked", "met"):
        out.add_column(heading, justify="right")
    for tets, times in (figures["tick_ms"] or {}).items():
        out.add_row(f"tick of {int(tets):,} tetrahedra, p50 / p99", _ms(times))
    if figures["control_ms"]:
        out.add_row("control: 20,000 numbers sorted, p50 / p99", _ms(figures["control_ms"]))
    for loop in figures.get("real_time", ()):
        where = f"on a thread of {1e3 * loop['period']:g} ms" if loop["period"] else "in the cycle"
        name = f"{loop['tets']:,} tetrahedra {where}: missed of {loop['ticks']:,} ticks, bare loop; late shapes"
        out.add_row(name, f"{loop['missed']}, {loop['control_missed']}; {loop['late']}")
    if other := figures["mujoco"]:
        for who, key in (("MuJoCo", ""), ("Palpate", "own_")):
            name = f"{who}, {other['tets']:,} tetrahedra: tick, error"
            out.add_row(name, f"{_ms(other[key + 'tick_ms'])}, {100 * other[key + 'layer_error']:+.1f} %")
    for one in figures.get("theories", ()):
        body = "half-space" if one["thickness_radii"] is None else f"layer of {one['thickness_radii']:g} R"
        errors = " ".join(f"{100 * error:+.1f}" for error in one["error"])
        depths = " ".join(f"{depth:g}" for depth in one["depth_radii"])
        out.add_row(f"{one['theory']}, {body}, nu {one['poisson']:g}: error at {depths} R", f"{errors} %")
    for row in figures["rows"]:
        asked = f"{'>=' if row['least'] else '<='} {row['asked']:g} {row['unit']}"
        out.add_row(row["name"], f"{row['value']:.3g} {row['unit']}", asked, "yes" if row["met"] else "[red]no[/red]")
    return out


def _ms(times: dict[str, float]) -> str:
    return f"{times['p50']:.3f} / {times['p99']:.3f} ms"
