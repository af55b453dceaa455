"""Pedals of the console that are devices: foot switches, keyboards, gamepads, and buttons on what the hand holds.

Any event device of Linux is read in a thread of its own:

    with PedalDevice(session.console, "footswitch:/dev/input/event7"):
        session.run(60.0, realtime=True)

A device is named KIND:FILE, with other keys as KIND:FILE:KEY=PEDAL,KEY=PEDAL (key codes of linux/input-event-codes.h).
"""

from __future__ import annotations

import os
import select
import threading
from types import TracebackType
from typing import Self

from palpate.base.errors import DeviceError
from palpate.devices import buttons
from palpate.devices.evdev import EVENT, KEY, find
from palpate.session.console import PEDALS, Console

KINDS = {
    "footswitch": ("kbd", {30: "clutch", 48: "camera", 46: "coag"}),  # keys A, B, C, as most foot switches send
    "keyboard": ("kbd", {46: "clutch", 47: "camera", 45: "coag", 24: "operator"}),  # keys C, V, X, O
    "gamepad": ("js", {0x136: "clutch", 0x137: "camera", 0x130: "coag"}),  # shoulder buttons and the lower button
}
"""Kinds of devices: their handler in /proc/bus/input/devices, and the pedal of each key code."""
_PATIENCE = 0.05  # [s] between two looks at whether the reading shall end


def press(console: Console, before: int, now: int, source: str) -> int:
    """Tell the console the pedals whose bits have changed (`devices.buttons`), but the clutch; returns `now`."""
    for pedal, bit in buttons.PEDALS.items():
        if bit != buttons.CLUTCH and (before ^ now) & bit:
            console.set(pedal, bool(now & bit), source)
    return now


def parse(spec: str) -> tuple[str, str, dict[int, str]]:
    """Kind, file and keys of a device named as in the text of this module; an empty file: the first that is found.

    Raises:
        DeviceError: the kind, a key or a pedal is unknown.
    """
    kind, _, rest = spec.partition(":")
    path, _, keys = rest.partition(":")
    if kind not in KINDS:
        mend = f"name one of {', '.join(KINDS)}, e.g. footswitch:/dev/input/event7"
        raise DeviceError(f"there are no pedals {kind!r}", mend=mend)
    table = dict(KINDS[kind][1])
    if keys:
        table = {}
        for part in keys.split(","):
            key, equals, pedal = part.partition("=")
            if not (equals and key.isdecimal()):
                raise DeviceError(f"{part!r} is no key with its pedal", where=spec, mend="write e.g. 30=clutch")
            if pedal not in PEDALS:
                raise DeviceError(f"there is no pedal {pedal!r}", where=spec, mend=f"pedals: {', '.join(PEDALS)}")
            table[int(key)] = pedal
    return kind, path, table


class PedalDevice:
    """Reads key events and presses and releases the pedals of a console, until `close`.

    Args:
        console: the console to which the pedals belong.
        spec: the device.

    Raises:
        DeviceError: the device is unknown, missing, or cannot be opened.
    """

    def __init__(self, console: Console, spec: str) -> None:
        self.kind, path, self._keys = parse(spec)
        self._console, self.source = console, spec
        self._path = path or find(KINDS[self.kind][0])
        try:
            self._file = os.open(self._path, os.O_RDONLY | os.O_NONBLOCK)
        except OSError as error:
            allow = f"sudo usermod -aG input {os.environ.get('USER', 'YOU')}, then log in again"
            absent = isinstance(error, FileNotFoundError)
            mend = "plug it in; `palpate device list` names what is there" if absent else allow
            raise DeviceError(f"{self._path} cannot be opened", why=error.strerror or "", mend=mend) from None
        for pedal in set(self._keys.values()) & {"operator", "head"}:
            console.set(pedal, False, self.source)  # absent until the key is down
        self.lost = ""
        """Why the device is no longer read; empty while it is."""
        self._rest = b""
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="palpate-pedals", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop reading; the pedals of the device are released."""
        self._stop.set()
        self._thread.join(timeout=2.0)
        for pedal in set(self._keys.values()):
            self._console.set(pedal, False, self.source)
        if self._file >= 0:
            os.close(self._file)
        self._file = -1

    def __enter__(self) -> Self:
        """The device itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the device."""
        self.close()

    def _run(self) -> None:
        why = ""
        while not self._stop.is_set() and not why:
            try:
                if select.select([self._file], [], [], _PATIENCE)[0]:
                    data = os.read(self._file, 64 * EVENT.size)
                    self.take(data)
                    why = "" if data else "it was unplugged"
            except OSError as error:
                why = error.strerror or "it cannot be read"
        if why:
            self.lost = f"{self.source}: {why}"
            self._console.lose(self.source)

    def take(self, data: bytes) -> None:
        """Take bytes of the event stream; an incomplete event waits for its rest."""
        data = self._rest + data
        whole = len(data) - len(data) % EVENT.size
        self._rest = data[whole:]
        for at in range(0, whole, EVENT.size):
            _, _, kind, code, value = EVENT.unpack_from(data, at)
            pedal = self._keys.get(code) if kind == KEY else None
            if pedal is not None and value in (0, 1):  # 2: the kernel repeats a held key
                self._console.set(pedal, value == 1, self.source)
