"""Examines combinations, and sums up."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypedDict

from palpate.verify.conformance.at_rest import frame_change, quiet, sign_and_direction
from palpate.verify.conformance.bench import Bench
from palpate.verify.conformance.combinations import Combination, unjudged
from palpate.verify.conformance.in_motion import continuity, energy, moving
from palpate.verify.conformance.live import live_edit
from palpate.verify.conformance.master import admittance_master
from palpate.verify.conformance.shares import policy

#: The properties that every combination is held to; each tells what is wrong in words, or nothing.
CHECKS: dict[str, Callable[[Combination], str]] = {
    "sign and direction": sign_and_direction,
    "quiet": quiet,
    "continuity": continuity,
    "energy": energy,
    "frame change": frame_change,
    "moving": moving,
    "live edit": live_edit,
    "policy": policy,
    "admittance master": admittance_master,
}
NO_JUDGE = "unjudged"
"""Among what is wrong with a combination: nothing is known of it, and why."""


def examine(c: Combination) -> dict[str, str]:
    """What is wrong with a combination, by property; empty when it passes.

    One without a meaning passes when the product refuses it.
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
            wrong = check(c)
        except LookupError as error:
            name, wrong = NO_JUDGE, f"{name}: {error}"
        if wrong:
            found[name] = wrong
    return found


class Summary(TypedDict):
    """What the suite found, as `conformance` in docs/json.md."""

    combinations: int
    passed: int
    refused: int
    unjudged: list[str]
    reasons: dict[str, int]
    failures: list[dict[str, str]]


def summary(found: dict[Combination, dict[str, str]]) -> Summary:
    """As in docs/json.md, of what `examine` found: ``{combinations, passed, refused, unjudged, ...}``."""
    reasons: dict[str, int] = {}
    judged, failures, without = 0, [], [f"the core's {name}: nothing here judges it" for name in unjudged()]
    for c, wrong in found.items():
        if NO_JUDGE in wrong:
            without.append(f"{c}: {wrong[NO_JUDGE]}")
        if c.meaningless and not wrong:
            reasons[c.meaningless] = reasons.get(c.meaningless, 0) + 1
            continue
        judged += 1
        if wrong:
            failures.append({"combination": str(c), **wrong})
    return {
        "combinations": judged,
        "passed": judged - len(failures),
        "refused": sum(reasons.values()),
        "unjudged": without,
        "reasons": reasons,
        "failures": failures,
    }
