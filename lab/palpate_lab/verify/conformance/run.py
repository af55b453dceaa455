"""Run all checks on combinations and summarise the results."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import TypedDict

from palpate_lab.verify.conformance.activation import policy
from palpate_lab.verify.conformance.at_rest import frame_change, sign_and_direction, steady
from palpate_lab.verify.conformance.bench import Bench
from palpate_lab.verify.conformance.combinations import Combination, unjudged
from palpate_lab.verify.conformance.damping import damping
from palpate_lab.verify.conformance.in_motion import continuity, energy, moving
from palpate_lab.verify.conformance.live import live_edit
from palpate_lab.verify.conformance.master import admittance_master
from palpate_lab.verify.conformance.rejected import rejected_places

#: Checks of every combination by name; each returns a description of the failure, or an empty text.
CHECKS: dict[str, Callable[[Combination], str]] = {
    "sign and direction": sign_and_direction,
    "quiet": steady,
    "damping": damping,
    "continuity": continuity,
    "energy": energy,
    "frame change": frame_change,
    "moving": moving,
    "live edit": live_edit,
    "rejected places": rejected_places,
    "policy": policy,
    "admittance master": admittance_master,
}
Place = tuple[str, str, int]
"""Role, geometry and seed."""
NO_JUDGE = "unjudged"
"""Key of a combination's result that could not be judged; the value states the reason."""


def examine(c: Combination) -> dict[str, str]:
    """Failures of a combination by check; empty if it passes.

    A meaningless combination passes if the core refuses it.
    """
    try:
        Bench(c)
    except ValueError as error:
        return {} if c.meaningless else {"refused": str(error)}
    if c.meaningless:
        return {"accepted": f"it has no meaning: {c.meaningless}"}
    found = {}
    for name, check in CHECKS.items():
        try:
            failure = check(c)
        except LookupError as error:
            name, failure = NO_JUDGE, f"{name}: {error}"
        if failure:
            found[name] = failure
    return found


class Pair(TypedDict):
    """Places and failures of a role with a geometry: a row of `pairs` in docs/json.md."""

    role: str
    geometry: str
    rejected_share: float
    places: int
    combinations: int
    failed: int


class Summary(TypedDict):
    """Summary of the suite: `conformance` in docs/json.md."""

    seeds: list[int]
    combinations: int
    checks: int
    pairs: list[Pair]
    passed: int
    refused: int
    unjudged: list[str]
    reasons: dict[str, int]
    failures: list[dict[str, str]]


def pairs(found: dict[Combination, dict[str, str]], places: Mapping[Place, tuple[float, int]]) -> list[Pair]:
    """A row for each role and geometry, with the mean of the rejected shares and all places of its seeds."""
    mine: dict[tuple[str, str], list[Combination]] = {}
    for c in found:
        if not c.meaningless:
            mine.setdefault((c.role, c.geometry), []).append(c)
    rows: list[Pair] = []
    for (role, geometry), cs in mine.items():
        drawn = [places[role, geometry, seed] for seed in {c.seed for c in cs} if (role, geometry, seed) in places]
        rows.append({
            "role": role,
            "geometry": geometry,
            "rejected_share": sum(share for share, _ in drawn) / max(len(drawn), 1),
            "places": sum(n for _, n in drawn),
            "combinations": len(cs),
            "failed": sum(bool(found[c]) for c in cs),
        })  # fmt: skip
    return rows


def summary(
    found: dict[Combination, dict[str, str]], places: Mapping[Place, tuple[float, int]] = MappingProxyType({})
) -> Summary:
    """Summarise the results of `examine` as described in docs/json.md.

    places: rejected share and number of places (`probes.drawn`) by role, geometry and seed.
    """
    reasons: dict[str, int] = {}
    judged, failures, without = 0, [], [f"the core's {name}: nothing here judges it" for name in unjudged()]
    for c, failed in found.items():
        if NO_JUDGE in failed:
            without.append(f"{c}: {failed[NO_JUDGE]}")
        if c.meaningless and not failed:
            reasons[c.meaningless] = reasons.get(c.meaningless, 0) + 1
            continue
        judged += 1
        if failed:
            failures.append({"combination": str(c), "seed": str(c.seed), **failed})
    return {
        "seeds": sorted({c.seed for c in found}),
        "combinations": judged,
        "checks": judged * len(CHECKS),
        "pairs": pairs(found, places),
        "passed": judged - len(failures),
        "refused": sum(reasons.values()),
        "unjudged": without,
        "reasons": reasons,
        "failures": failures,
    }
