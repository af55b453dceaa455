"""The keyboard as a device: each press moves the handle by a millimetre. It renders no force.

Keys come from the terminal, or, where a file of events is named, from Linux' /dev/input.
"""

from __future__ import annotations

import os
import re
import select
import sys
import termios
import time
import tty
from collections.abc import Iterator
from typing import Any

import numpy as np

from palpate.base.arrays import Array
from palpate.base.errors import DeviceError
from palpate.devices.buttons import PEDALS
from palpate.devices.driver import Reading
from palpate.devices.evdev import KEY, OPENING, EventDevice

STEP, FINE = 1e-3, 2e-4
"""Motion of a press, and of a press of a capital letter in the terminal [m]."""
SPEED = 0.05
"""Largest speed of the handle, which is on its way to where the presses have sent it [m/s]."""
_MOVES = {"left": (0, -1), "right": (0, 1), "away": (1, 1), "near": (1, -1), "up": (2, 1), "down": (2, -1)}
_TEXT = {
    b"\x1b[D": "left", b"\x1b[C": "right", b"\x1b[A": "away", b"\x1b[B": "near", b"\x1b[5~": "up", b"\x1b[6~": "down",
    b"a": "left", b"d": "right", b"w": "away", b"s": "near", b"e": "up", b"q": "down", b" ": "gripper", b"c": "clutch",
    b"v": "camera", b"x": "coag",
}  # fmt: skip
_CODES = {
    105: "left", 106: "right", 103: "away", 108: "near", 104: "up", 109: "down",
    30: "left", 32: "right", 17: "away", 31: "near", 18: "up", 16: "down", 57: "gripper", 46: "clutch",
    47: "camera", 45: "coag",
}  # fmt: skip  # linux/input-event-codes.h
_TOKEN = re.compile(rb"\x1b\[(?:[A-Z]|[0-9]+~)|.", re.DOTALL)  # a key of the terminal
_UNFINISHED = re.compile(rb"\x1b(?:\[[0-9]{0,3})?$")  # whose rest has not arrived yet


class Keyboard(EventDevice):
    """A keyboard (``keyboard``): each press moves by 1 mm, held keys go on; it renders no force.

    Arrows or W A S D move left, right, away and near; Page Up and Page Down, or E and Q, move up and down. The space
    bar closes and opens the gripper; C, V and X press and release clutch, camera pedal and coagulation. Capital letters
    in the terminal move by 0.2 mm.
    """

    handler = "kbd"

    def __init__(self, path: str = "") -> None:
        super().__init__(path)
        self._target = np.zeros(3)
        self._bytes = b""
        self._terminal: list[Any] | None = None

    @classmethod
    def missing(cls) -> str:
        """Empty if the standard input is a terminal."""
        return "" if sys.stdin is not None and sys.stdin.isatty() else "the standard input is no terminal"

    def open(self) -> None:
        """Open the file of events, or take the keys of the terminal one by one, without showing them."""
        self._last = time.monotonic()
        if self._path:
            super().open()
            return
        if self.missing():
            mend = "run it in a terminal, or name a file of events: keyboard:/dev/input/eventN"
            raise DeviceError(self.missing(), mend=mend)
        self._file = os.dup(sys.stdin.fileno())
        if os.tcgetpgrp(self._file) != os.getpgrp():
            self.close()
            raise DeviceError("this program does not run in the foreground of its terminal", mend="start it without &")
        self._terminal = termios.tcgetattr(self._file)
        tty.setcbreak(self._file)

    def close(self) -> None:
        """Give the terminal back as it was."""
        if self._terminal is not None:
            termios.tcsetattr(self._file, termios.TCSADRAIN, self._terminal)
            self._terminal = None
        super().close()

    def read(self) -> Reading:
        """The pose on its way to the target, after all keys; a closed terminal raises OSError."""
        now = time.monotonic()
        for key, step in self._events_of_file() if self._path else self._events_of_terminal():
            self._press(key, step)
        most = SPEED * min(now - self._last, 0.05)
        way = self._target - self._p
        self._p = self._p + way * min(1.0, most / max(float(np.linalg.norm(way)), 1e-12))
        self._last = now
        X = np.eye(4)
        X[:3, 3] = self._p
        return Reading(X, None, self._gripper, self._buttons)

    def write(self, wrench: Array) -> None:
        """No force."""

    def _press(self, key: str, step: float) -> None:
        if key == "gripper":
            self._gripper = OPENING - self._gripper
        elif key in PEDALS:
            self._buttons ^= PEDALS[key]
        else:
            axis, sign = _MOVES[key]
            self._target[axis] += sign * step
            half = 0.5 * np.array(self.workspace)
            self._target = np.clip(self._target, -half, half)

    def _events_of_file(self) -> Iterator[tuple[str, float]]:
        for kind, code, value in self._events():
            held = value == 2 and _CODES.get(code) in _MOVES  # the kernel repeats held keys
            if kind == KEY and code in _CODES and (value == 1 or held):
                yield _CODES[code], STEP

    def _events_of_terminal(self) -> Iterator[tuple[str, float]]:
        if select.select([self._file], [], [], 0.0)[0]:
            data = os.read(self._file, 4096)
            if not data:
                raise OSError("the terminal was closed")
            self._bytes += data
        unfinished = _UNFINISHED.search(self._bytes)
        end = len(self._bytes) if unfinished is None else unfinished.start()
        tokens, self._bytes = _TOKEN.findall(self._bytes[:end]), self._bytes[end:]
        for token in tokens:
            key = _TEXT.get(token) or _TEXT.get(token.lower())
            if key is not None:
                yield key, FINE if token.isupper() and len(token) == 1 else STEP
