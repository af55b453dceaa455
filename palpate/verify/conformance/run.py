"""Run all checks on combinations and summarise the results."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypedDict

from palpate.verify.conformance.activation import policy
from palpate.verify.conformance.at_rest import frame_change, sign_and_direction, steady
from palpate.verify.conformance.bench import Bench
from palpate.verify.conformance.combinations import Combination, unjudged
from palpate.verify.conformance.in_motion import continuity, energy, moving
from palpate.verify.conformance.live import live_edit
from palpate.verify.conformance.master import admittance_master

#: Checks of every combination by name; each returns a description of the failure, or an empty text.
CHECKS: dict[str, Callable[[Combination], str]] = {
    "sign and direction": sign_and_direction,
    "quiet": steady,
    "continuity": continuity,
    "energy": energy,
    "frame change": frame_change,
    "moving": moving,
    "live edit": live_edit,
    "policy": policy,
    "admittance master": admittance_master,
}
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


class Summary(TypedDict):
    """Summary of the suite: `conformance` in docs/json.md."""

    combinations: int
    passed: int
    refused: int
    unjudged: list[str]
    reasons: dict[str, int]
    failures: list[dict[str, str]]


def summary(found: dict[Combination, dict[str, str]]) -> Summary:
    """Summarise the results of `examine` as described in docs/json.md."""
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
            failures.append({"combination": str(c), **failed})
    return {
        "combinations": judged,
        "passed": judged - len(failures),
        "refused": sum(reasons.values()),
        "unjudged": without,
        "reasons": reasons,
        "failures": failures,
    }
