"""A driver in C (a shared object) with the functions of a driver in Python, for `palpate device test` and `bench`.

Sessions run such a driver in a thread of the core instead (`palpate.devices.native`), without the interpreter.
"""

from __future__ import annotations

import ctypes
import weakref
from pathlib import Path
from typing import Any

import numpy as np

from palpate.base.arrays import Array
from palpate.base.errors import DeviceError
from palpate.devices.driver import MOST_RATE, Driver, Reading
from palpate.devices.native import header_folder

_ABI = 1  # PALPATE_DRIVER_ABI of driver.h
_FUNCTIONS = ("open", "read", "write", "close")


class _Info(ctypes.Structure):
    """palpate_driver_info of driver.h."""

    _fields_ = [
        ("abi", ctypes.c_uint32),
        ("name", ctypes.c_char * 64),
        ("rate", ctypes.c_double),
        ("force_max", ctypes.c_double),
        ("moment_max", ctypes.c_double),
        ("workspace", ctypes.c_double * 3),
        ("resolution", ctypes.c_double),
        ("mass", ctypes.c_double),
        ("delay", ctypes.c_double),
        ("friction", ctypes.c_double),
        ("damping", ctypes.c_double),
    ]


class _State(ctypes.Structure):
    """palpate_driver_state of driver.h."""

    _fields_ = [
        ("X_LH", ctypes.c_double * 16),
        ("V_LH", ctypes.c_double * 6),
        ("has_velocity", ctypes.c_int32),
        ("buttons", ctypes.c_uint32),
        ("gripper", ctypes.c_double),
    ]


class SharedObject(Driver):
    """A driver in C. Its device is opened at once, since only the open device states its facts.

    Args:
        file: the shared object.
        argument: text that its open function takes.

    Raises:
        DeviceError: the file cannot be loaded, lacks a function, has another version, or its device cannot be opened.
    """

    def __init__(self, file: Path, argument: str = "") -> None:
        self._file, self._argument = file, argument
        try:
            library = ctypes.CDLL(str(file.resolve()))
            self._open, self._read, self._write, closed = (getattr(library, f"palpate_driver_{f}") for f in _FUNCTIONS)
        except (OSError, AttributeError) as error:
            mend = f"compile it with -shared -fPIC -I {header_folder()}; driver.h there says what each function does"
            raise DeviceError(f"driver {file} cannot be used", why=str(error), mend=mend) from None
        self._open.restype, closed.argtypes, closed.restype = ctypes.c_void_p, [ctypes.c_void_p], None
        self._open.argtypes = [ctypes.c_char_p, ctypes.POINTER(_Info), ctypes.c_char_p, ctypes.c_size_t]
        self._read.argtypes = [ctypes.c_void_p, ctypes.POINTER(_State)]
        self._write.argtypes = [ctypes.c_void_p, ctypes.POINTER(ctypes.c_double)]
        self._closed = closed
        self._begin()

    def _begin(self) -> None:
        info, why = _Info(), ctypes.create_string_buffer(256)
        device = self._open(self._argument.encode(), ctypes.byref(info), why, len(why))
        if not device:
            what = f"driver {self._file}: its device cannot be opened"
            raise DeviceError(what, why=why.value.decode(errors="replace"), mend="check cable, power and permissions")
        self._device, self._close = device, weakref.finalize(self, _end, self._write, self._closed, device)
        if info.abi != _ABI:
            self._close()
            what = f"driver {self._file} has version {info.abi} of the interface, not {_ABI}"
            raise DeviceError(what, mend="compile it again with the present driver.h, and set info->abi")
        self.rate = min(info.rate, MOST_RATE)  # measurements in Python are not faster
        self.force_max, self.moment_max = info.force_max, info.moment_max
        sizes = (info.workspace[0], info.workspace[1], info.workspace[2])
        self.workspace = sizes if min(sizes) > 0.0 else Driver.workspace
        self.resolution, self.friction, self.damping = info.resolution, info.friction, info.damping
        self.mass, self.delay = info.mass or Driver.mass, info.delay or None

    def open(self) -> None:
        """Open the device again if it was closed.

        Raises:
            DeviceError: as for the constructor.
        """
        if not self._close.alive:
            self._begin()

    def _require_open(self) -> None:
        """A closed device is freed memory: to hand it to the driver would corrupt this process."""
        if not self._close.alive:
            raise RuntimeError(f"driver {self._file}: its device is closed; call open() first")

    def read(self) -> Reading:
        """One measurement; a pose that the driver does not fill in is not a number, as in the core."""
        self._require_open()
        state = _State()
        state.X_LH[:] = [np.nan] * 16
        code = self._read(self._device, ctypes.byref(state))
        if code:
            raise RuntimeError(f"palpate_driver_read returned {code}")
        X = np.array(state.X_LH).reshape(4, 4)
        V = np.array(state.V_LH) if state.has_velocity == 1 else None
        return Reading(X, V, state.gripper, state.buttons)

    def write(self, wrench: Array) -> None:
        """Command a wrench."""
        self._require_open()
        code = self._write(self._device, (ctypes.c_double * 6)(*np.asarray(wrench, dtype=np.float64)))
        if code:
            raise RuntimeError(f"palpate_driver_write returned {code}")

    def close(self) -> None:
        """Zero force, and close the device."""
        self._close()


def _end(write: Any, close: Any, device: int) -> None:
    """Close a device whose last wrench is zero, as driver.h promises it."""
    write(device, (ctypes.c_double * 6)())
    close(device)
