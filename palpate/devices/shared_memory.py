"""A device in another process, which exchanges states and wrenches with Palpate through shared memory.

The other process holds the vendor's library; it may crash or be killed, and the force is then zero here. The file is
``/dev/shm/palpate-NAME``, 256 bytes, little-endian, made by the device's process. Two blocks, each with a counter in
front, are written by one process and read by the other:

    offset  bytes  content
         0      8  magic: the text "PALPATE1"
         8      8  float64: rate of the device [Hz]
        16      8  float64: largest force [N]
        24      8  float64: largest moment [N m]
        32     24  float64 x 3: workspace along x, y, z [m]
        56      8  reserved
        64      8  uint64: counter of the state block, even: complete, odd: being written
        72     96  float64 x 12: the first three rows of X_LH, row by row [m]
       168      8  float64: angle of the gripper [rad]
       176      8  uint64: buttons, bit 0: clutch
       184      8  reserved
       192      8  uint64: counter of the wrench block
       200     48  float64 x 6: wrench on the hand [N, N m]
       248      8  reserved

A writer makes the counter odd, writes the block, and makes the counter even again, so that each new value raises it by
two. A reader copies the block between two equal, even readings of the counter (sequence lock; Lamport 1977). On
processors that reorder writes (ARM) a writer in C needs a release fence before each change of the counter.

A device's process commands zero force when the counter of the wrench block stands still for 20 ms.
"""

from __future__ import annotations

import mmap
import struct
import time
from pathlib import Path
from typing import Self

import numpy as np

from palpate.base.arrays import Array
from palpate.base.errors import DeviceError
from palpate.devices.driver import Driver, Reading

MAGIC = b"PALPATE1"
SIZE = 256
SILENT = 0.015
"""Age of the newest state after which the device counts as silent [s]."""
_HEAD, _STATE, _WRENCH = struct.Struct("<8s6d"), struct.Struct("<13dQ"), struct.Struct("<6d")
_AT_STATE, _AT_WRENCH = 64, 192
_COUNTER = struct.Struct("<Q")
_TRIES = 100


def path_of(name: str) -> Path:
    """The file of a device."""
    return Path("/dev/shm") / f"palpate-{name}"


class _Block:
    """A block of the memory with its counter."""

    def __init__(self, memory: mmap.mmap, at: int, values: struct.Struct) -> None:
        self._memory, self._at, self._values = memory, at, values

    @property
    def counter(self) -> int:
        return int(_COUNTER.unpack_from(self._memory, self._at)[0])

    def write(self, *values: float) -> None:
        counter = self.counter & ~1
        _COUNTER.pack_into(self._memory, self._at, counter + 1)
        self._values.pack_into(self._memory, self._at + 8, *values)
        _COUNTER.pack_into(self._memory, self._at, counter + 2)

    def read(self) -> tuple[int, tuple[float, ...]] | None:
        """Counter and values; None if the writer stopped while it wrote."""
        for _ in range(_TRIES):
            before = self.counter
            values = self._values.unpack_from(self._memory, self._at + 8)
            if before % 2 == 0 and self.counter == before:
                return before, values
        return None


class SharedMemoryDevice(Driver):
    """A device in another process, by shared memory (``shared-memory:NAME``)."""

    force_max = 100.0  # until open() reads the device's own

    def __init__(self, name: str = "device") -> None:
        self._path = path_of(name)
        try:
            with self._path.open("r+b") as file:
                self._memory = mmap.mmap(file.fileno(), SIZE)
        except (OSError, ValueError) as error:
            mend = "start the device's process first (palpate.devices.shared_memory.Server)"
            raise DeviceError(f"no device at {self._path}", why=str(error), mend=mend) from None
        magic, self.rate, self.force_max, self.moment_max, *size = _HEAD.unpack_from(self._memory, 0)
        if magic != MAGIC:
            raise DeviceError(f"{self._path} is no device of Palpate", mend="the file begins with PALPATE1")
        self.workspace = (size[0], size[1], size[2])
        self._state = _Block(self._memory, _AT_STATE, _STATE)
        self._wrench = _Block(self._memory, _AT_WRENCH, _WRENCH)
        self._counter, self._changed = -1, 0.0

    @classmethod
    def missing(cls) -> str:
        """Empty if a device's process has made its file."""
        return "" if list(path_of("x").parent.glob("palpate-*")) else "no process of a device runs"

    def open(self) -> None:
        """Start to watch the counter."""
        self._counter, self._changed = -1, time.monotonic()

    def read(self) -> Reading:
        """The newest state; not a number while the device is silent, so that the force is zero."""
        found, now = self._state.read(), time.monotonic()
        if found is not None and found[0] != self._counter:
            self._counter, self._changed = found[0], now
        if found is None or now - self._changed > SILENT or found[0] == 0:
            return Reading(np.full((4, 4), np.nan))
        *rows, gripper, buttons = found[1]
        return Reading(np.vstack([np.reshape(rows, (3, 4)), [0.0, 0.0, 0.0, 1.0]]), None, gripper, int(buttons))

    def write(self, wrench: Array) -> None:
        """Hand the wrench over."""
        self._wrench.write(*wrench.tolist())

    def close(self) -> None:
        """Leave zero force behind."""
        self.write(np.zeros(6))


class Server:
    """The device's side: run it in the process of the vendor's library, or write its like in C.

        with Server("omega", rate=1000.0, force_max=12.0) as server:
            while True:
                server.send(pose)  # (4, 4), at the device's rate
                device.command(server.wrench())

    Args:
        name: name of the device.
        rate: rate of `send` [Hz].
        force_max: largest force [N]. moment_max: largest moment [N m]. workspace: lengths along the axes [m].
    """

    def __init__(
        self,
        name: str,
        rate: float,
        force_max: float,
        moment_max: float = 0.0,
        workspace: tuple[float, float, float] = (0.1, 0.1, 0.1),
    ) -> None:
        self._path = path_of(name)
        with self._path.open("w+b") as file:
            file.truncate(SIZE)
            self._memory = mmap.mmap(file.fileno(), SIZE)
        _HEAD.pack_into(self._memory, 0, MAGIC, rate, force_max, moment_max, *workspace)
        self._state = _Block(self._memory, _AT_STATE, _STATE)
        self._wrench = _Block(self._memory, _AT_WRENCH, _WRENCH)
        self._counter, self._changed = 0, 0.0

    def send(self, X: Array, gripper: float = 0.0, buttons: int = 0) -> None:
        """Hand over a pose X_LH (4, 4) [m]."""
        self._state.write(*np.asarray(X, dtype=np.float64)[:3].ravel().tolist(), gripper, buttons)

    def wrench(self) -> Array:
        """The newest wrench (6,) [N, N m]; zeros if it is older than 20 ms."""
        found, now = self._wrench.read(), time.monotonic()
        if found is not None and found[0] != self._counter:
            self._counter, self._changed = found[0], now
        return np.array(found[1]) if found is not None and now - self._changed < 0.02 else np.zeros(6)

    def __enter__(self) -> Self:
        """The server itself."""
        return self

    def __exit__(self, *error: object) -> None:
        """Remove the file."""
        self._path.unlink(missing_ok=True)
