"""``palpate study guidance --conformance``: the conformance suite on every core, and how far the tool gets in."""

from __future__ import annotations

import json
from typing import Any

from rich.console import RenderableType

from palpate import conformance
from palpate.conformance import entry
from palpate.studies.command import Sweeper
from palpate.sweep import Axis, sweep
from palpate.sweep.grid import Point


def conform(sweep: Sweeper = sweep) -> dict[str, Any]:
    """As `conformance` in docs/json.md."""
    grid = {"role": Axis(conformance.ROLES), "geometry": Axis(conformance.SPECIMENS)}
    rows = sweep(examined, grid, title="conformance").rows()
    wrong = {name: found for row in rows for name, found in json.loads(row["failures"]).items()}
    told = conformance.summary({c: wrong.get(str(c), {}) for c in conformance.combinations()})
    grid = {"region": Axis(entry.REGIONS), "hand": Axis(range(entry.SEEDS)), "fixture": Axis([1, 0])}
    hard = entry.hard_rows(sweep(gone_in, grid, title="entry").rows())
    soft = [entry.soft(force) for force in entry.FORCES]
    return told | {"hard_entry": hard, "soft_entry": soft, "entry_passed": entry.passed(hard, soft)}


def examined(point: Point, seed: int) -> dict[str, Any]:
    """All laws and policies of a role with a geometry; nothing in it is random."""
    mine = [c for c in conformance.combinations() if (c.role, c.geometry) == (point["role"], point["geometry"])]
    found = {str(c): conformance.examine(c) for c in mine}
    return {"examined": len(mine), "failures": json.dumps({name: wrong for name, wrong in found.items() if wrong})}


def gone_in(point: Point, seed: int) -> dict[str, float]:
    """One hand at one hard region, or at none."""
    return entry.hard(point["region"], point["hand"], bool(point["fixture"]))


def conformance_words(told: dict[str, Any]) -> list[RenderableType]:
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
    worst = max(told["hard_entry"], key=lambda row: row["entry_mm"])
    least = min(told["hard_entry"], key=lambda row: row["entry_without_mm"])
    lines.append(
        f"hard: at most {worst['entry_mm']:.3f} mm in ({worst['geometry']}), whatever {worst['hands']} hands do; "
        f"without the fixture they get in by {least['entry_without_mm']:.1f} mm and more"
    )
    pressed = ", ".join(
        f"{e['force_N']:g} N {e['measured_mm']:.2f} mm (certified {e['certified_mm']:.2f})" for e in told["soft_entry"]
    )
    lines.append(f"soft: {pressed}")
    passed = f"{told['passed']} of {told['combinations']} combinations passed, {told['refused']} refused as due"
    return [*lines, f"conformance: {passed}, {len(told['unjudged'])} not judged"]
