"""States of a session: the table of transitions that the cycle runs (docs/session.md), requests and their refusal.

machine.legal("homed")               # ('power_off', 'follow', 'hold')
session.request("clutch")            # StateError: says why not, and what is possible instead
"""

from __future__ import annotations

import difflib
from typing import Final

from palpate import _core
from palpate.base.errors import StateError

STATES: Final = {name: words for name, words, _ in _core.session_states()}
"""Meaning of each state, in the order of the numbers in the signal ``session_state``."""
NAMES: Final = tuple(STATES)
CAUSES: Final = {name: words for name, words, _ in _core.session_causes()}
"""Meaning of each cause of a transition."""
REQUESTS: Final = tuple(name for name, _, request in _core.session_causes() if request)
"""Causes that a person requests; the others are measured."""
TRANSITIONS: Final = tuple(_core.session_transitions())
"""Rows (from, cause, to); in a state the first row whose cause holds is taken."""

_LEVELS: Final = {
    "power_on": ("power", True), "power_off": ("power", False), "home": ("home", True),
    "follow": ("following", True), "stop": ("following", False), "clutch": ("clutch", True),
    "unclutch": ("clutch", False), "camera": ("camera", True), "uncamera": ("camera", False),
    "hold": ("hold_all", True), "resume": ("hold_all", False),
}  # fmt: skip


def name_of(number: float) -> str:
    """Name of the state with a number in the signal ``session_state``."""
    return NAMES[int(number)]


def legal(state: str) -> tuple[str, ...]:
    """Requests with an effect in a state."""
    return tuple(cause for before, cause, _ in TRANSITIONS if before == state and cause in REQUESTS)


def require(state: str, request: str, why: str = "") -> None:
    """Refuse a request that has no effect in a state.

    Args:
        state: name of the present state.
        request: one of `REQUESTS`.
        why: what holds the session in its state, for the message.

    Raises:
        StateError: the request is unknown, or the table has no row for it.
    """
    if request not in REQUESTS:
        near = difflib.get_close_matches(request, REQUESTS, n=1)
        mend = f"did you mean {near[0]!r}?" if near else f"requests: {', '.join(REQUESTS)}"
        raise StateError(f"there is no request {request!r}", mend=mend)
    if request in legal(state):
        return
    mend = f"possible now: {', '.join(legal(state))}"
    raise StateError(f"{request!r} has no effect: the session is {state}", why=why or STATES[state], mend=mend)


def level(request: str) -> dict[str, bool]:
    """The control, with its value, that a request sets; none for `recover`, which is no level."""
    return dict([_LEVELS[request]]) if request in _LEVELS else {}


def apply(controls: _core.Controls, request: str) -> None:
    """Write a request into the controls of a loop, which takes it with its next tick."""
    if request == "recover":
        controls.recover_requests += 1
        return
    for name, value in level(request).items():
        setattr(controls, name, value)


def path(start: str, goal: str) -> tuple[str, ...]:
    """The shortest sequence of causes that leads from a state to another; empty if they are the same.

    Raises:
        StateError: no sequence leads there.
    """
    found: dict[str, tuple[str, ...]] = {start: ()}
    waiting = [start]
    while waiting:
        here = waiting.pop(0)
        for before, cause, after in TRANSITIONS:
            if before == here and after not in found:
                found[after] = (*found[here], cause)
                waiting.append(after)
    if goal not in found:
        raise StateError(f"no transition leads from {start!r} to {goal!r}", mend=f"states: {', '.join(NAMES)}")
    return found[goal]
