"""A hand in front of a headset as a device (WebXR): the viewer's page in the headset's browser measures it.

The page sends poses to the viewer's server (`palpate/viewer/xr.js`, `xr.py`), which puts them into a `Feed`; the driver
reads the newest one. There is no force: a controller vibrates by the force over its cap. A hand that is not tracked
counts as a pressed clutch, so that the tool stays, and goes on from where it is.
"""

from __future__ import annotations

import math
import time
from importlib.util import find_spec
from typing import Any, Final

import numpy as np

from palpate.base.arrays import Array, so3
from palpate.base.errors import DeviceError
from palpate.devices.buttons import CLUTCH, bits
from palpate.devices.driver import Driver, Reading
from palpate.devices.evdev import OPENING

HANDS: Final = ("right", "left")
STALE = 0.1
"""Age of a pose from which on the hand counts as not tracked [s]."""
_FAR = 10.0  # largest coordinate of a hand [m]
_AXES = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""From WebXR (x right, y up, z towards the user) to the base: x right, y away from the user, z up."""


class Feed:
    """The newest pose of one hand, from a page; written by one thread and read by another."""

    def __init__(self) -> None:
        self.vibration = 0.0  #: strength that the page shall give, 0 to 1
        self.force_cap = 0.0  #: force of the full strength [N]
        self._newest = (-math.inf, Reading(np.eye(4), None, OPENING, 0))

    def take(self, message: dict[str, Any]) -> bool:
        """Take a message of the page: p (3,) [m] and q (4,) x, y, z, w in its axes, pinch 0 to 1, buttons by name.

        Returns False, and keeps the last pose, if it is not valid.
        """
        try:
            p, q = (np.array(message[key], dtype=np.float64) for key in ("p", "q"))
            pinch, buttons = float(message["pinch"]), dict(message["buttons"])
            pressed = {str(name): down is True for name, down in buttons.items()}
            held = bits(pressed, "webxr")
        except (KeyError, TypeError, ValueError):
            return False
        sound = p.shape == (3,) and q.shape == (4,) and bool(np.isfinite(p).all()) and 0.0 <= pinch <= 1.0
        if not sound or np.abs(p).max() > _FAR or not abs(float(np.linalg.norm(q)) - 1.0) < 0.05:
            return False
        X = np.eye(4)
        X[:3, :3] = _AXES @ so3.matrices(np.roll(q, 1) / np.linalg.norm(q)) @ _AXES.T
        X[:3, 3] = _AXES @ p
        self._newest = (time.monotonic(), Reading(X, None, OPENING * (1.0 - pinch), held))
        return True

    def lose(self) -> None:
        """The hand is not tracked any more."""
        self._newest = (-math.inf, self._newest[1])

    @property
    def tracked(self) -> bool:
        """True while poses come."""
        return time.monotonic() - self._newest[0] < STALE

    def reading(self) -> Reading:
        """The newest pose; with the clutch pressed while the hand is not tracked."""
        at, reading = self._newest
        lost = time.monotonic() - at >= STALE
        return reading._replace(buttons=reading.buttons | CLUTCH) if lost else reading


FEEDS: dict[str, Feed] = {}
"""The hands that are asked for, by name."""
PAGES: set[int] = set()
"""Viewers that are open."""


class WebXR(Driver):
    """A hand or controller of a headset (``webxr``), by the viewer's page in its browser; it vibrates, without force.

    ``webxr:left`` is the left hand. A pinch of thumb and index finger, or the trigger, closes the gripper; a pinch of
    thumb and middle finger, or the squeeze button, is the clutch.
    """

    rate, force_max, workspace = 250.0, 0.0, (0.6, 0.6, 0.6)

    def __init__(self, hand: str = "right") -> None:
        if hand not in HANDS:
            raise DeviceError(f"there is no hand {hand!r}", mend="write webxr:right or webxr:left")
        self.hand = hand
        self._feed = Feed()

    @classmethod
    def missing(cls) -> str:
        """Empty if the viewer is installed."""
        return "" if find_spec("viser") else "the viewer (pip install 'palpate[viewer]')"

    def open(self) -> None:
        """Offer the hand to the page.

        Raises:
            DeviceError: there is no viewer, or another pair has the hand.
        """
        if not PAGES:
            mend = "run it with the viewer: palpate run SCENE --leader webxr --serve"
            raise DeviceError("the hand is measured by the viewer's page, and no viewer is open", mend=mend)
        if FEEDS.get(self.hand, self._feed) is not self._feed:
            raise DeviceError(f"the {self.hand} hand leads already", mend="take webxr:left for the other pair")
        self._feed.force_cap = self.force_cap
        FEEDS[self.hand] = self._feed

    def read(self) -> Reading:
        """The newest pose."""
        return self._feed.reading()

    def write(self, wrench: Array) -> None:
        """Let the controller vibrate: full at the force cap."""
        force = float(np.linalg.norm(wrench[:3]))
        self._feed.vibration = min(1.0, force / self.force_cap) if self.force_cap > 0.0 else 0.0

    def close(self) -> None:
        """No vibration; the page no longer measures the hand."""
        self._feed.vibration = 0.0
        FEEDS.pop(self.hand, None)
