"""Examines combinations, and sums up."""

from __future__ import annotations

from typing import Any

from palpate.conformance.bench import Bench, fixture
from palpate.conformance.checks import CHECKS
from palpate.conformance.combinations import Combination, combinations, unjudged


def examine(c: Combination) -> dict[str, str]:
    """What is wrong with a combination, by property; empty when it passes.

    One without a meaning passes when the product refuses it.
    """
    try:
        Bench(fixture(c))
    except ValueError as error:
        return {} if c.meaningless else {"refused": str(error)}
    if c.meaningless:
        return {"accepted": f"it has no meaning: {c.meaningless}"}
    found = {}
    for name, check in CHECKS.items():
        try:
            wrong = check(c)
        except LookupError as error:
            wrong = str(error)
        if wrong:
            found[name] = wrong
    return found


def summary(failures: dict[Combination, dict[str, str]], examined: list[Combination]) -> dict[str, Any]:
    """As in docs/json.md: ``{combinations, passed, ...}``."""
    missing = unjudged()
    reasons: dict[str, int] = {}
    for c in examined:
        if c.meaningless:
            reasons[c.meaningless] = reasons.get(c.meaningless, 0) + 1
    return {
        "combinations": len(examined) + len(missing),
        "passed": len(examined) - len(failures),
        "of_all": len(combinations()),
        "refused": sum(reasons.values()),
        "reasons": reasons,
        "unjudged": missing,
        "failures": [{"combination": str(c), **wrong} for c, wrong in failures.items()],
    }
