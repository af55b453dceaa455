"""The console of a session: pedals, operator presence, locks, scale. All sources of pedals meet here.

    console = session.console
    console.press("clutch")                      # a program
    console.press("clutch", source="foot")       # a foot switch: the pedal stays down until both have released it
    console.lock_rotation(True)

Sources are named: a dVRK, a foot switch, a gamepad, buttons of the viewer, a program. A source that is lost fails to
the safe side: the operator counts as absent if it reported presence, and a clutch that it held stays pressed.
"""

from __future__ import annotations

import difflib
import threading
from collections.abc import Callable, Sequence
from typing import Any, Final, Protocol

from palpate.base.errors import StateError
from palpate.session import machine

PEDALS: Final = {
    "clutch": "the hands move freely, the tools hold",
    "camera": "the hands move the endoscope, the tools hold",
    "coag": "coagulation: reported to programs; while the clutch is down, accepts tracked tools that were moved",
    "operator": "the operator is at the console; present until a source reports it",
    "head": "the head is in the viewer; present until a source reports it",
}
"""Pedals and sensors by name, with their effect."""
PRESENCE: Final = ("operator", "head")
LARGEST_SCALE: Final = 10.0
"""Largest motion scale [-]."""


class Hand(Protocol):
    """A session, as far as the console needs it."""

    def change(self, **values: Any) -> None:
        """Assign some controls of the loop."""
        ...

    def request(self, request: str) -> None:
        """Ask for a change of the session's state."""
        ...


class Console:
    """Pedals and switches of one operator, for the sessions of all hands.

    Args:
        hands: the sessions, each with one leader and one follower. A list may change while its session does not run.
        exchange: called by `swap` to exchange the followers of two hands; None: this run cannot.
    """

    def __init__(self, hands: Sequence[Hand], exchange: Callable[[], None] | None = None) -> None:
        self._hands, self._exchange = hands, exchange
        self._lock = threading.RLock()
        self._down: dict[str, dict[str, bool]] = {name: {} for name in PEDALS}
        self._kept: set[str] = set()  # pedals that a lost source held down
        self._exchanging = False
        self._followers: list[Callable[[str, bool], None]] = []

    # -- pedals ----------------------------------------------------------------------------------------------------

    def press(self, pedal: str, source: str = "program") -> None:
        """Press a pedal, or report presence.

        Raises:
            StateError: there is no such pedal; nothing changes.
        """
        self.set(pedal, True, source)

    def release(self, pedal: str, source: str = "program") -> None:
        """Release a pedal, or report absence; raises as `press`."""
        self.set(pedal, False, source)

    def set(self, pedal: str, down: bool, source: str = "program") -> None:
        """State of a pedal by one source; raises as `press`."""
        if pedal not in PEDALS:
            near = difflib.get_close_matches(str(pedal), PEDALS, n=1)
            mend = f"did you mean {near[0]!r}?" if near else f"pedals: {', '.join(PEDALS)}"
            raise StateError(f"there is no pedal {pedal!r}", where=source, mend=mend)
        with self._lock:
            before = self.pedals
            self._down[pedal].pop(_lost(source), None)
            self._down[pedal][source] = bool(down)
            self._kept.discard(pedal)
            self._send(before)

    def lose(self, source: str) -> None:
        """A source has gone: presence that it reported ends, pedals that it held stay down until they are pressed and
        released again by another source."""
        with self._lock:
            before = self.pedals
            for pedal, sources in self._down.items():
                was_down = sources.pop(source, None)
                if was_down is not None and pedal in PRESENCE:
                    sources[_lost(source)] = False
                elif was_down:
                    self._kept.add(pedal)
            self._send(before)

    def forget(self, pedal: str, source: str) -> None:
        """End what a source reports of a pedal, as if it had never reported it."""
        with self._lock:
            before = self.pedals
            for name in (source, _lost(source)):
                self._down[pedal].pop(name, None)
            self._send(before)

    @property
    def pedals(self) -> dict[str, bool]:
        """Each pedal: True if a source holds it down; presence: True unless a source reports absence."""
        with self._lock:
            down = {name: any(sources.values()) or name in self._kept for name, sources in self._down.items()}
            return down | {name: all(self._down[name].values()) for name in PRESENCE}

    @property
    def present(self) -> bool:
        """True if the operator is at the console with the head in the viewer, as far as reported."""
        pedals = self.pedals
        return pedals["operator"] and pedals["head"]

    def on_change(self, callback: Callable[[str, bool], None]) -> None:
        """Call a function with the name and the new state of each pedal that changes."""
        self._followers.append(callback)

    def _send(self, before: dict[str, bool]) -> None:
        now = self.pedals
        changed = {name: down for name, down in now.items() if down != before[name]}
        if not changed:
            return
        present = now["operator"] and now["head"]
        for hand in self._hands:
            hand.change(clutch=now["clutch"], camera=now["camera"], operator_present=present)
        for name, down in changed.items():
            for callback in self._followers:
                callback(name, down)

    # -- switches --------------------------------------------------------------------------------------------------

    def lock_rotation(self, locked: bool = True) -> None:
        """Let the tools keep their orientation while they follow; moments on the hands are zero meanwhile."""
        self._change(lock_rotation=bool(locked))

    def lock_translation(self, locked: bool = True) -> None:
        """Let the tools keep their position while they follow; forces on the hands are zero meanwhile."""
        self._change(lock_translation=bool(locked))

    def set_scale(self, scale: float | None) -> None:
        """Motion of the tool per motion of the hand [-]; None: as in the scene. The tool does not jump.

        Raises:
            StateError: the scale is not above 0 and at most `LARGEST_SCALE`.
        """
        if scale is not None and not 0.0 < scale <= LARGEST_SCALE:
            mend = "give the motion of the tool per motion of the hand, e.g. 0.5"
            raise StateError(f"scale {scale!r} must be above 0 and at most {LARGEST_SCALE:g}", mend=mend)
        self._change(scale=0.0 if scale is None else float(scale))

    def request(self, request: str) -> None:
        """Ask for a change of the state of all hands (docs/session.md).

        A hand on which it has no effect now, because it is in a fault for example, takes it when it can: what is asked
        for is a level. To `recover` is no level; only hands in a fault take it.

        Raises:
            StateError: the request is unknown, or has no effect on any hand; nothing changes.
        """
        with self._lock:
            refused: list[tuple[Hand, StateError]] = []
            for hand in self._hands:
                try:
                    hand.request(request)
                except StateError as error:
                    refused.append((hand, error))
            if refused and len(refused) == len(self._hands):
                raise refused[0][1]
            for hand, _ in refused:
                hand.change(**machine.level(request))

    def begin_tool_exchange(self) -> None:
        """Hold everything while somebody changes an instrument; raises StateError where a hold has no effect."""
        self.request("hold")
        self._exchanging = True

    def end_tool_exchange(self) -> None:
        """Go on with the instruments that are mounted now: each hand is anchored anew at the pose of its tool.

        Raises:
            StateError: no exchange was begun, and nothing holds.
        """
        if self._exchanging:  # a session that has begun anew with another instrument has not taken a tick yet
            self._change(**machine.level("resume"))
        else:
            self.request("resume")
        self._exchanging = False

    def swap(self) -> None:
        """Exchange the followers of the two hands.

        Raises:
            StateError: there are no two pairs, or this run cannot exchange them.
        """
        if len(self._hands) < 2:
            mend = "name two pairs in the scene"
            raise StateError("swap exchanges the followers of two hands; this session has one hand", mend=mend)
        if self._exchange is None:
            what = "the followers of this run cannot be exchanged while it runs"
            raise StateError(what, mend="exchange them in the scene")
        self._exchange()

    def _change(self, **values: Any) -> None:
        with self._lock:
            for hand in self._hands:
                hand.change(**values)


def _lost(source: str) -> str:
    """Name under which the presence that a lost source reported counts as absence, until it reports again."""
    return f"{source} (lost)"
