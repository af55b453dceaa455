"""``palpate study guidance --conformance``: the conformance suite on all cores, and the penetration of fixtures."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any, TypedDict, cast

from rich.console import RenderableType
from rich.table import Table

from palpate.base.sweep import Axis, sweep
from palpate.base.sweep.grid import Point
from palpate.devices.certificate.guidance import FORCES
from palpate_lab.studies._command import Sweeper
from palpate_lab.verify import conformance
from palpate_lab.verify.conformance import entry
from palpate_lab.verify.conformance.run import Summary


class Entered(TypedDict):
    """Penetration of hard and soft fixtures; `entry` in docs/json.md."""

    hard_entry: list[entry.Hard]
    soft_entry: list[dict[str, float]]
    entry_passed: bool


class Conformance(Summary, Entered):
    """Summary of the suite, and the penetration of fixtures."""


def conform(sweep: Sweeper = sweep, seeds: int = 0, first: int = 1) -> Conformance:
    """Run the conformance suite on all cores; `conformance` in docs/json.md.

    With ``seeds`` > 0, a sample of about a thousand checks at the places of each seed from ``first``.
    """
    mine = [c for seed in range(first, first + seeds) for c in conformance.sample(seed)] or conformance.combinations()
    places = {(c.role, c.geometry, c.seed) for c in mine if not c.meaningless}
    grid = {"seed": Axis(sorted({c.seed for c in mine})), "role": Axis(conformance.ROLES),
            "geometry": Axis(conformance.SPECIMENS)}  # fmt: skip
    rows = sweep(examined, grid, title="conformance", where=lambda p: _place(p) in places or not seeds).rows()
    wrong = {(row["seed"], name): found for row in rows for name, found in json.loads(row["failures"]).items()}
    drawn = {_place(row): (row["rejected_share"], row["places"]) for row in rows}
    summary = conformance.summary({c: wrong.get((c.seed, str(c)), {}) for c in mine}, drawn)
    return {**summary, **entered(sweep)}


def _place(point: Mapping[str, Any]) -> tuple[str, str, int]:
    return point["role"], point["geometry"], point["seed"]


def entered(sweep: Sweeper = sweep) -> Entered:
    """Measure the penetration of fixtures in the full simulation; `entry` in docs/json.md."""
    most = max(region.hands for region in entry.REGIONS.values())
    grid = {"region": Axis(entry.REGIONS), "hand": Axis(range(most)), "fixture": Axis([1, 0])}
    hard = entry.hard_rows(cast(list[entry.HandRun], sweep(penetration, grid, where=_has_hand, title="entry").rows()))
    soft = [entry.soft(force) for force in FORCES]
    return {"hard_entry": hard, "soft_entry": soft, "entry_passed": entry.passed(hard, soft)}


def examined(point: Point, seed: int) -> dict[str, int | float | str]:
    """Examine all laws and policies of a role with a geometry, or those of a sample; `seed` has no effect."""
    of_seed = point["seed"]
    all_of = conformance.sample(of_seed) if of_seed else conformance.combinations()
    mine = [c for c in all_of if (c.role, c.geometry) == (point["role"], point["geometry"])]
    found = {str(c): conformance.examine(c) for c in mine}
    share, places = conformance.drawn(*_place(point)) if any(not c.meaningless for c in mine) else (0.0, 0)
    return {"examined": len(mine), "rejected_share": share, "places": places,
            "failures": json.dumps({name: wrong for name, wrong in found.items() if wrong})}  # fmt: skip


def penetration(point: Point, seed: int) -> dict[str, float]:
    """Press one hand into a hard region, with or without its fixture."""
    return entry.hard(point["region"], point["hand"], bool(point["fixture"]))


def _has_hand(point: Point) -> bool:
    return bool(point["hand"] < entry.REGIONS[point["region"]].hands)


def conformance_words(judged: Conformance) -> list[RenderableType]:
    """Failures by property, reasons for refused combinations, and the penetration of fixtures."""
    kinds: dict[str, list[str]] = {}
    for failure in judged["failures"]:
        for name, wrong in failure.items():
            if name not in ("combination", "seed"):
                kinds.setdefault(name, []).append(f"{failure['combination']}, seed {failure['seed']}: {wrong}")
    lines: list[RenderableType] = []
    for name, found in kinds.items():
        lines += [f"{name}: {len(found)} combinations", *(f"  {text}" for text in found[:3])]
    most = sorted(judged["pairs"], key=lambda pair: -pair["rejected_share"])[:5]
    shares = (f"{100 * pair['rejected_share']:.0f} % of {pair['role']} x {pair['geometry']}" for pair in most)
    lines.append(f"not smooth, judged as rejected places: {', '.join(shares)}")
    lines += [f"not judged: {name}" for name in judged["unjudged"]]
    lines += [f"refused as meaningless: {n} combinations, {why}" for why, n in judged["reasons"].items()]
    passed = (
        f"{judged['passed']} of {judged['combinations']} combinations passed ({judged['checks']} checks), "
        f"{judged['refused']} refused"
    )
    return [*lines, *entry_words(judged), f"conformance: {passed}, {len(judged['unjudged'])} not judged"]


def entry_words(found: Entered) -> list[RenderableType]:
    """Table and sentences on the penetration of fixtures."""
    hard = Table(
        box=None, pad_edge=False, title="penetration of hard regions by adversarial hands", title_justify="left"
    )
    for column in ("region", "hands", "penetration", "held back", "without the fixture"):
        hard.add_column(column, justify="left" if column == "region" else "right")
    for row in found["hard_entry"]:
        hard.add_row(row["region"], str(row["hands"]), f"{row['entry_mm']:.3f} mm", f"{100 * row['held_share']:.0f} %",
                     f"{row['entry_without_mm']:.1f} mm")  # fmt: skip
    worst = max(found["hard_entry"], key=lambda row: row["entry_mm"])
    pressed = ", ".join(
        f"{e['force_N']:g} N {e['measured_mm']:.3f} mm (certified {e['certified_mm']:.3f})" for e in found["soft_entry"]
    )
    one = found["soft_entry"][0]
    return [
        hard,
        f"hard: penetration of at most {worst['entry_mm']:.3f} mm ({worst['region']})",
        f"soft: {pressed}; of {one['K_N_per_m']:g} N/m the certificate measures {one['certified_N_per_m']:.1f}",
        f"entry: {'within the bounds' if found['entry_passed'] else 'NOT within the bounds'}",
    ]
