"""Force Dimension devices (Omega, Delta, Sigma, Lambda) and the Falcon, by the Python binding `forcedimension-core`.

The binding (PyPI, LGPL-3.0) loads the vendor's SDK, which has a licence of its own; both are installed by the user.
This driver was judged with a stand-in that has the functions of version 1.0.0, not with a device.
"""

from __future__ import annotations

import re
from contextlib import suppress
from ctypes import c_double
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np

from palpate.base.arrays import Array
from palpate.base.errors import DeviceError
from palpate.devices.buttons import TABLE, bits
from palpate.devices.driver import Driver, Reading
from palpate.devices.evdev import OPENING

_MEND = "pip install forcedimension-core, and install the SDK of Force Dimension"
_SERIAL = re.compile("[0-9]{1,9}")  # the SDK takes a C int
_MOMENT_MAX = 0.1  # of a wrist with motors [N m]


class ForceDimension(Driver):
    """A device of Force Dimension, or a Falcon (``force-dimension``), by the vendor's SDK.

    ``force-dimension:SERIAL`` opens the one with that serial number, for two of them at one computer. The base has x
    towards the user, y to the right and z up. Buttons 0, 1 and 2 are clutch, camera pedal and coagulation; button 3
    closes the jaws if the device has no gripper. The SDK compensates the weight.
    """

    rate = 1000.0
    force_max = 8.0  # the weakest device, a Falcon; a scene's cap is usually lower
    workspace = (0.10, 0.10, 0.10)

    def __init__(self, serial: str = "") -> None:
        if serial and not _SERIAL.fullmatch(serial):
            what = f"{serial!r} is no serial number of a device of Force Dimension"
            raise DeviceError(what, mend="write force-dimension:NUMBER, as the vendor's program `HapticDesk` shows it")
        self._serial = serial
        self._dhd: Any = None
        self._id = -1
        self._p, self._R = [0.0] * 3, [[0.0] * 3 for _ in range(3)]
        self._angle = c_double()
        self._wrist = self._gripper = False
        self._turns: bool | None = None  # motors turn the wrist; None: no device was asked

    @property
    def moment_max(self) -> float:  # type: ignore[override]
        """Largest moment [N m]; 0 for a device whose wrist has no motors, which is asked the first time."""
        if self._turns is None:
            with suppress(DeviceError):  # open() says what is wrong
                self._connect()
                self._dhd.close(self._id)
                self._id = -1
        return _MOMENT_MAX if self._turns in (None, True) else 0.0

    @classmethod
    def missing(cls) -> str:
        """Empty if the binding is installed."""
        return "" if find_spec("forcedimension_core") else "the Python package forcedimension-core and the vendor's SDK"

    def open(self) -> None:
        """Open the first device, or that with the serial number, and switch its forces on."""
        self._connect()
        self._check(self._dhd.setGravityCompensation(True, self._id))
        self._check(self._dhd.enableForce(True, self._id))

    def _connect(self) -> None:
        """Open the device, at zero force, and ask what it has.

        Raises:
            DeviceError: the binding cannot be loaded, or no device opens.
        """
        try:
            self._dhd = import_module("forcedimension_core.dhd")
        except Exception as error:  # the binding raises its own errors if the SDK is missing
            raise DeviceError("the binding of Force Dimension cannot be loaded", why=str(error), mend=_MEND) from None
        self._id = self._dhd.openSerial(int(self._serial)) if self._serial else self._dhd.open()
        if self._id < 0:
            mend = "check power and cable, and the udev rules of the SDK; calibrate the device by its own program first"
            what = f"no device of Force Dimension opens{f' with the number {self._serial}' if self._serial else ''}"
            raise DeviceError(what, why=str(self._dhd.errorGetLastStr()), mend=mend)
        self._wrist, self._gripper = bool(self._dhd.hasWrist(self._id)), bool(self._dhd.hasGripper(self._id))
        self._turns = bool(self._dhd.hasActiveWrist(self._id))

    def read(self) -> Reading:
        """Pose, angle of the gripper, and buttons."""
        X = np.eye(4)
        if self._wrist:
            self._check(self._dhd.getPositionAndOrientationFrame(self._p, self._R, self._id))
            X[:3, :3] = self._R
        else:
            self._check(self._dhd.getPosition(self._p, self._id))
        X[:3, 3] = self._p
        if self._gripper:
            self._check(self._dhd.getGripperAngleRad(self._angle, self._id))
        pressed = {name: self._dhd.getButton(int(name), self._id) > 0 for name in TABLE["force-dimension"]}
        closed = 0.0 if pressed["3"] else OPENING
        gripper = abs(self._angle.value) if self._gripper else closed
        return Reading(X, None, gripper, bits(pressed, "force-dimension"))

    def write(self, wrench: Array) -> None:
        """Command force and moment."""
        if self._id >= 0:
            force, moment = wrench[:3].tolist(), wrench[3:].tolist()
            self._check(self._dhd.setForceAndTorque(force, moment, self._id))

    def close(self) -> None:
        """Zero force, brakes off, close."""
        if self._id >= 0:
            self._dhd.enableForce(False, self._id)
            self._dhd.close(self._id)
        self._id = -1

    def _check(self, code: int) -> None:
        """Raise OSError for a negative code; positive codes are remarks, such as a reading that is not new."""
        if code < 0:
            raise OSError(str(self._dhd.errorGetLastStr()))
