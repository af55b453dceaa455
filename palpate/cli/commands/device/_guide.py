"""The questions of `palpate device bench` in a terminal: one step after the other, each with what the person does."""

from __future__ import annotations

import math
import sys
from contextlib import suppress

from palpate.cli.commands.device._common import require_consent
from palpate.devices.published import NAMES

STEPS = ("driver", "rest", "move", "weight", "spring", "published figures")
"""The steps of the guide, in their order."""


class Guide:
    """Leads a person through the measurements; silent outside of a terminal and with ``--yes``.

    Args:
        name: of the driver.
        yes: push without asking, and ask nothing.
    """

    def __init__(self, name: str, yes: bool) -> None:
        self._name, self._yes = name, yes
        self.asks = not yes and sys.stdin.isatty() and sys.stderr.isatty()
        """True if a person answers."""

    def begin(self, step: str, words: str) -> None:
        """Say which step begins, and what it measures."""
        if self.asks:
            print(f"\nstep {STEPS.index(step) + 1} of {len(STEPS)}, {step}: {words}", file=sys.stderr)

    def rest(self) -> None:
        """Ask the person to let go."""
        self.begin("rest", "rate, noise and steps of the position, without a force")
        self._answer("Put the handle down, let go of it, and press Enter: ")

    def push(self) -> None:
        """Ask for consent before the motors push.

        Raises:
            DeviceError: the person does not say yes, or there is nobody to ask.
        """
        self.begin("move", "mass, friction, damping and delay, by a push to and fro")
        require_consent(self._yes, f"{self._name} will push with 0.5 N along each axis")

    def number(self, step: str, given: float | None, words: str, unit: str) -> float | None:
        """A number that the person types, or that an option gives; None without one."""
        if given is not None or not self.asks:
            return given
        self.begin(step, words)
        while True:
            text = self._answer(f"Its value [{unit}], or Enter to go on without: ")
            if not text:
                return None
            with suppress(ValueError):
                if 0.0 < (value := float(text)) < math.inf:
                    return value
            print(f"{text!r} is no number above 0; with a point, e.g. 0.1", file=sys.stderr)

    def like(self, given: str | None) -> str | None:
        """The device of the table of published figures, by an option or by the person."""
        if given is not None or not self.asks:
            return given
        self.begin("published figures", "what the vendor publishes beside what was measured")
        while True:
            text = self._answer(f"Which device is it? {NAMES}, or Enter for another one: ").lower()
            if not text or text in NAMES.split(", "):
                return text or None
            print(f"{text!r} is not in the table", file=sys.stderr)

    def _answer(self, words: str) -> str:
        if not self.asks:
            return ""
        print(words, end="", file=sys.stderr, flush=True)
        return sys.stdin.readline().strip()
