"""Mouse and gamepad as devices, read from Linux' /dev/input. They render no force: one sees the contact in the viewer.

The motion of a mouse moves the handle; the sticks of a gamepad set its velocity (rate control).
"""

from __future__ import annotations

import fcntl
import os
import re
import struct
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import ClassVar

import numpy as np

from palpate.base.arrays import Array
from palpate.base.errors import DeviceError
from palpate.devices.buttons import CAMERA, CLUTCH, COAG
from palpate.devices.driver import Driver, Reading

EVENT = struct.Struct("llHHi")
"""struct input_event: time [s, us], type, code, value."""
KEY, _REL, _ABS = 1, 2, 3  # types of events (linux/input-event-codes.h)
_LISTED = Path("/proc/bus/input/devices")
_GET_RANGE = 0x80184540  # ioctl EVIOCGABS of axis 0
_DEFAULT_RANGE = (-32768, 32767)
OPENING = 0.5
"""Angle of the gripper while its button or trigger is released [rad]."""


class EventDevice(Driver):
    """Base of the drivers of /dev/input: reads the events that have arrived since the last reading."""

    rate, force_max, workspace = 250.0, 0.0, (0.2, 0.2, 0.2)
    handler = ""  # of /proc/bus/input/devices: mouse, js

    def __init__(self, path: str = "") -> None:
        self._path = path
        self._file = -1
        self._p = np.zeros(3)
        self._gripper, self._buttons = OPENING, 0
        self._last = 0.0

    @classmethod
    def missing(cls) -> str:
        """Empty if such a device is connected."""
        try:
            find(cls.handler)
        except DeviceError as error:
            return error.what
        return ""

    def open(self) -> None:
        """Open the file of the events."""
        self._path = self._path or find(self.handler)
        try:
            self._file = os.open(self._path, os.O_RDONLY | os.O_NONBLOCK)
        except OSError as error:
            mend = f"sudo usermod -aG input {os.environ.get('USER', 'YOU')}, then log in again"
            raise DeviceError(f"{self._path} cannot be opened", why=error.strerror or "", mend=mend) from None
        self._last = time.monotonic()

    def read(self) -> Reading:
        """The pose after all events; an unplugged device raises OSError."""
        now = time.monotonic()
        for kind, code, value in self._events():
            self.take(kind, code, value)
        self._p = self._p + min(now - self._last, 0.05) * self.velocity()
        half = 0.5 * np.array(self.workspace)
        self._p, self._last = np.clip(self._p, -half, half), now
        X = np.eye(4)
        X[:3, 3] = self._p
        return Reading(X, None, self._gripper, self._buttons)

    def write(self, wrench: Array) -> None:
        """No force."""

    def close(self) -> None:
        """Close the file."""
        if self._file >= 0:
            os.close(self._file)
        self._file = -1

    def take(self, kind: int, code: int, value: int) -> None:
        """Take one event."""
        raise NotImplementedError

    def velocity(self) -> Array:
        """Velocity (3,) of the handle by the present deflections [m/s]."""
        return np.zeros(3)

    def _set(self, bit: int, down: bool) -> None:
        """Press or release a button of `palpate.devices.buttons`."""
        self._buttons = self._buttons | bit if down else self._buttons & ~bit

    def _events(self) -> Iterator[tuple[int, int, int]]:
        with suppress(BlockingIOError):
            while data := os.read(self._file, 64 * EVENT.size):
                for at in range(0, len(data) - EVENT.size + 1, EVENT.size):
                    _, _, kind, code, value = EVENT.unpack_from(data, at)
                    yield kind, code, value


class Mouse(EventDevice):
    """A mouse (``mouse``): it moves left, right, away and near; its wheel moves up and down; it renders no force.

    The left button closes the gripper, the right button is the clutch, the middle button the camera pedal.
    """

    handler = "mouse"
    _COUNT, _NOTCH = 1e-4, 1e-3  # m per count of the motion and per notch of the wheel
    _BUTTONS: ClassVar = {0x111: CLUTCH, 0x112: CAMERA}

    def take(self, kind: int, code: int, value: int) -> None:
        """Counts of motion and wheel, and three buttons."""
        if kind == _REL and code in (0, 1, 8):
            axis, step = {0: (0, self._COUNT), 1: (1, -self._COUNT), 8: (2, self._NOTCH)}[code]
            self._p[axis] += step * value
        elif kind == KEY and code == 0x110:
            self._gripper = 0.0 if value else OPENING
        elif kind == KEY and code in self._BUTTONS:
            self._set(self._BUTTONS[code], value != 0)


class Gamepad(EventDevice):
    """A gamepad (``gamepad``): its sticks set the velocity, at most 50 mm/s; it renders no force.

    The left stick moves left, right, away and near; the right stick moves up and down; the right trigger closes the
    gripper; the left shoulder button is the clutch, the right one the camera pedal, the lower button coagulation.
    """

    handler = "js"
    SPEED, DEAD = 0.05, 0.12  # m/s at full deflection; deflection that counts as none
    _BUTTONS: ClassVar = {0x136: CLUTCH, 0x137: CAMERA, 0x130: COAG}
    _AXES: ClassVar = {0: (0, 1.0), 1: (1, -1.0), 4: (2, -1.0)}  # code: axis of the base, sign

    def __init__(self, path: str = "") -> None:
        super().__init__(path)
        self._deflection = np.zeros(3)
        self._ranges: dict[int, tuple[int, int]] = {}

    def take(self, kind: int, code: int, value: int) -> None:
        """Deflections of sticks and trigger, and three buttons."""
        if kind == _ABS and code in self._AXES:
            axis, sign = self._AXES[code]
            low, high = self._range(code)
            share = float(np.clip(2.0 * (value - low) / (high - low) - 1.0, -1.0, 1.0))
            beyond = max(0.0, abs(share) - self.DEAD) / (1.0 - self.DEAD)
            self._deflection[axis] = sign * np.sign(share) * beyond
        elif kind == _ABS and code == 5:
            low, high = self._range(code, (0, 255))
            self._gripper = OPENING * float(np.clip(1.0 - (value - low) / (high - low), 0.0, 1.0))
        elif kind == KEY and code in self._BUTTONS:
            self._set(self._BUTTONS[code], value != 0)

    def velocity(self) -> Array:
        """Velocity (3,) by the sticks [m/s]."""
        return np.asarray(self.SPEED * self._deflection)

    def _range(self, code: int, default: tuple[int, int] = _DEFAULT_RANGE) -> tuple[int, int]:
        """Smallest and largest value of an axis, as the kernel reports them."""
        if code not in self._ranges:
            self._ranges[code] = default
            with suppress(OSError):
                _, low, high, *_ = struct.unpack("6i", fcntl.ioctl(self._file, _GET_RANGE + code, bytes(24)))
                self._ranges[code] = (low, high) if high > low else default
        return self._ranges[code]


def find(handler: str, listed: str | None = None) -> str:
    """The first file of events with a handler, e.g. ``/dev/input/event5`` for ``mouse``.

    Args:
        handler: start of the handler's name, ``mouse`` or ``js``.
        listed: text of /proc/bus/input/devices; read when left out.

    Raises:
        DeviceError: there is none.
    """
    if listed is None:
        listed = _LISTED.read_text() if _LISTED.exists() else ""
    for line in re.findall(r"^H: Handlers=(.*)$", listed, re.M):
        names = line.split()
        events = [name for name in names if name.startswith("event")]
        if events and any(re.fullmatch(rf"{handler}\d+", name) for name in names):
            return f"/dev/input/{events[0]}"
    what = {"mouse": "mouse", "js": "gamepad"}.get(handler, handler)
    raise DeviceError(
        f"no {what} is connected", where=str(_LISTED), mend=f"connect one, or name it: {what}:/dev/input/eventN"
    )
