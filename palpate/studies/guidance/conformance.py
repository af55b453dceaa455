"""``palpate study guidance --conformance``: the conformance suite on every core, and how far the tool gets in."""

from __future__ import annotations

import json
from typing import TypedDict, cast

from rich.console import RenderableType
from rich.table import Table

from palpate.certificate.guidance import FORCES
from palpate.studies._command import Sweeper
from palpate.sweep import Axis, sweep
from palpate.sweep.grid import Point
from palpate.verify import conformance
from palpate.verify.conformance import entry
from palpate.verify.conformance.run import Summary


class Entered(TypedDict):
    """How far the tool got in, as `entry` in docs/json.md."""

    hard_entry: list[entry.Hard]
    soft_entry: list[dict[str, float]]
    entry_passed: bool


class Conformance(Summary, Entered):
    """The suite's summary, and how far the tool got in."""


def conform(sweep: Sweeper = sweep) -> Conformance:
    """As `conformance` in docs/json.md."""
    grid = {"role": Axis(conformance.ROLES), "geometry": Axis(conformance.SPECIMENS)}
    rows = sweep(examined, grid, title="conformance").rows()
    wrong = {name: found for row in rows for name, found in json.loads(row["failures"]).items()}
    told = conformance.summary({c: wrong.get(str(c), {}) for c in conformance.combinations()})
    return {**told, **entered(sweep)}


def entered(sweep: Sweeper = sweep) -> Entered:
    """As `entry` in docs/json.md."""
    most = max(region.hands for region in entry.REGIONS.values())
    grid = {"region": Axis(entry.REGIONS), "hand": Axis(range(most)), "fixture": Axis([1, 0])}
    hard = entry.hard_rows(cast(list[entry.HandRun], sweep(gone_in, grid, where=_has_hand, title="entry").rows()))
    soft = [entry.soft(force) for force in FORCES]
    return {"hard_entry": hard, "soft_entry": soft, "entry_passed": entry.passed(hard, soft)}


def examined(point: Point, seed: int) -> dict[str, int | str]:
    """All laws and policies of a role with a geometry; nothing in it is random."""
    mine = [c for c in conformance.combinations() if (c.role, c.geometry) == (point["role"], point["geometry"])]
    found = {str(c): conformance.examine(c) for c in mine}
    return {"examined": len(mine), "failures": json.dumps({name: wrong for name, wrong in found.items() if wrong})}


def gone_in(point: Point, seed: int) -> dict[str, float]:
    """One hand at one hard region, or at none."""
    return entry.hard(point["region"], point["hand"], bool(point["fixture"]))


def _has_hand(point: Point) -> bool:
    return bool(point["hand"] < entry.REGIONS[point["region"]].hands)


def conformance_words(told: Conformance) -> list[RenderableType]:
    """For people: what failed, by property; what has no meaning, and why; how far the tool got in."""
    kinds: dict[str, list[str]] = {}
    for failure in told["failures"]:
        for name, wrong in failure.items():
            if name != "combination":
                kinds.setdefault(name, []).append(f"{failure['combination']}: {wrong}")
    lines: list[RenderableType] = []
    for name, found in kinds.items():
        lines += [f"{name}: {len(found)} combinations", *(f"  {text}" for text in found[:3])]
    lines += [f"not judged: {name}" for name in told["unjudged"]]
    lines += [f"refused, as it has to be: {n} combinations, {why}" for why, n in told["reasons"].items()]
    passed = f"{told['passed']} of {told['combinations']} combinations passed, {told['refused']} refused as due"
    return [*lines, *entry_words(told), f"conformance: {passed}, {len(told['unjudged'])} not judged"]


def entry_words(told: Entered) -> list[RenderableType]:
    """For people: how far the tool got in."""
    hard = Table(box=None, pad_edge=False, title="into hard regions, whatever the hands do", title_justify="left")
    for column in ("region", "hands", "in", "held back", "without the fixture"):
        hard.add_column(column, justify="left" if column == "region" else "right")
    for row in told["hard_entry"]:
        hard.add_row(row["region"], str(row["hands"]), f"{row['entry_mm']:.3f} mm", f"{100 * row['held_share']:.0f} %",
                     f"{row['entry_without_mm']:.1f} mm")  # fmt: skip
    worst = max(told["hard_entry"], key=lambda row: row["entry_mm"])
    pressed = ", ".join(
        f"{e['force_N']:g} N {e['measured_mm']:.3f} mm (certified {e['certified_mm']:.3f})" for e in told["soft_entry"]
    )
    one = told["soft_entry"][0]
    return [
        hard,
        f"hard: at most {worst['entry_mm']:.3f} mm in ({worst['region']})",
        f"soft: {pressed}; of {one['K_N_per_m']:g} N/m the certificate measures {one['certified_N_per_m']:.1f}",
        f"entry: {'as promised' if told['entry_passed'] else 'NOT as promised'}",
    ]
