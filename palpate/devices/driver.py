"""What a driver is: a class with four functions and the facts of its device, in about ten lines."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array
from palpate.base.errors import DeviceError
from palpate.devices.handle import MASS, AtHandle

MOST_RATE = 1000.0
"""Largest rate of a driver in Python [Hz]; a driver in C (a shared object) may be faster."""


class Reading(NamedTuple):
    """One measurement of a device, in the axes of its base."""

    X: npt.ArrayLike
    """X_LH (4, 4): pose of the handle [m]. A device without rotation gives the identity in [:3, :3]."""
    V: npt.ArrayLike | None = None
    """V_LH (6,): velocity of the handle [m/s, rad/s]; None: estimated from the poses."""
    gripper: float = 0.0
    """Angle of the gripper, 0: closed [rad]."""
    buttons: int = 0
    """Bit 0: clutch, the hand moves and the tool stays; bit 8 + i: the device's own button i is pressed."""


class Driver:
    """Base class of drivers; deriving from it is optional. All values are in SI units, in the axes of the base.

        class Omega(Driver):
            rate, force_max, workspace = 1000.0, 12.0, (0.16, 0.16, 0.11)

            def open(self): self.device = vendor.open()
            def read(self): return self.device.pose()
            def write(self, wrench): self.device.set_force(wrench[:3])
            def close(self): self.device.close()

    Palpate calls ``read`` and ``write`` in turn from one thread. If one of them does not return within 12 ms, a second
    thread calls ``write`` with zeros. An exception of any of them ends the session, after a ``write`` with zeros.
    """

    rate: float = MOST_RATE
    """Rate at which Palpate calls read and write, 50 to 1000 [Hz]."""
    force_max: float = 0.0
    """Largest force that the device may be commanded [N]; 0: it renders no force."""
    moment_max: float = 0.0
    """Largest moment that the device may be commanded [N m]; 0: forces only."""
    gripper_max: float = 0.0
    """Largest torque of the gripper on the fingers [N m]; above 0, Palpate calls ``grip(torque)`` after ``write``."""
    workspace: tuple[float, float, float] = (0.1, 0.1, 0.1)
    """Lengths of the workspace along the axes of the base [m]."""
    resolution: float = 0.0
    """Resolution of the measured position, 0: unknown [m]."""
    mass: float = MASS
    """Moving mass at the handle; `palpate device bench` measures it [kg]."""
    delay: float | None = None
    """Time from a measurement to the force on the hand, which `palpate device bench` measures; None: unknown [s]."""
    friction: float = 0.0
    """Dry friction that certainly resists the handle, at the lower end of what `palpate device bench` measures [N]."""
    damping: float = 0.0
    """Viscous friction, likewise; both need `resolution` [N s/m]."""

    own_buttons: tuple[str, ...] = ()
    """Names of the device's own buttons, in the order of bits 8, 9, ... of `Reading.buttons`: topics on ROS 2."""

    force_cap: float = 0.0
    """Force cap of the scene, which Palpate sets before ``open``: for devices that show the force otherwise [N]."""

    @classmethod
    def missing(cls) -> str:
        """What this machine lacks for the device, in words; empty if nothing is known to be missing."""
        return ""

    def open(self) -> None:
        """Connect to the device and switch its motors on, at zero force."""

    def read(self) -> Reading | npt.ArrayLike:
        """Measure: a `Reading`, or the pose X_LH (4, 4) alone [m]."""
        raise NotImplementedError

    def write(self, wrench: Array) -> None:
        """Command the wrench (6,) on the hand: force [N], moment [N m]; must also work while `read` hangs."""

    def grip(self, torque: float) -> None:
        """Command the torque of the gripper on the fingers, positive when it opens them [N m]."""

    def close(self) -> None:
        """Switch the motors off and disconnect. The last wrench that was written is zero."""


class Facts(NamedTuple):
    """Checked facts of a driver."""

    name: str
    rate: float  # [Hz]
    force_max: float  # [N]; 0: no force
    moment_max: float  # [N m]
    workspace: tuple[float, float, float]  # [m]
    resolution: float  # [m]; 0: unknown
    mass: float  # [kg]
    gripper_max: float = 0.0  # [N m]; 0: its gripper has no motor
    delay: float | None = None  # [s]; None: unknown
    friction: float = 0.0  # [N]
    damping: float = 0.0  # [N s/m]

    @property
    def at_handle(self) -> AtHandle:
        """What the passivity layer may assume.

        Raises:
            DeviceError: friction or damping without resolution.
        """
        return AtHandle(self.resolution, self.mass, self.delay, self.friction, self.damping)


def facts(driver: object, name: str) -> Facts:
    """The facts of a driver, checked.

    Raises:
        DeviceError: a function is missing, or an attribute is missing or not a number within its range.
    """
    missing = [f for f in ("open", "read", "write", "close") if not callable(getattr(driver, f, None))]
    if missing:
        what = f"driver {name} has no function {', '.join(missing)}"
        raise DeviceError(what, mend="a driver has open(), read(), write(wrench) and close(); see docs/device.md")
    rate = _number(driver, name, "rate", 50.0, MOST_RATE, "Hz")
    sizes = getattr(driver, "workspace", Driver.workspace)
    if np.shape(sizes) != (3,) or not all(isinstance(x, (int, float)) and 0.0 < x <= 10.0 for x in sizes):
        what = f"driver {name}: workspace = {sizes!r} must be three lengths of 0 to 10 m"
        raise DeviceError(what, mend="give the lengths along the axes of the base in metres, e.g. (0.16, 0.16, 0.11)")
    return Facts(
        name,
        rate,
        _number(driver, name, "force_max", 0.0, 100.0, "N"),
        _number(driver, name, "moment_max", 0.0, 10.0, "N m", 0.0),
        (float(sizes[0]), float(sizes[1]), float(sizes[2])),
        _number(driver, name, "resolution", 0.0, 0.01, "m", 0.0),
        _number(driver, name, "mass", 0.001, 100.0, "kg", MASS),
        _gripper_max(driver, name),
        None if getattr(driver, "delay", None) is None else _number(driver, name, "delay", 0.0, 1.0, "s"),
        _number(driver, name, "friction", 0.0, 100.0, "N", 0.0),
        _number(driver, name, "damping", 0.0, 1000.0, "N s/m", 0.0),
    )


def limited(wrench: Array, known: Facts) -> Array:
    """The wrench with its force and its moment scaled to the caps of the device; directions are kept."""
    out = wrench.copy()
    for part, most in ((slice(0, 3), known.force_max), (slice(3, 6), known.moment_max)):
        size = float(np.linalg.norm(out[part]))
        if size > most:
            out[part] *= most / size
    return out


def _gripper_max(driver: object, name: str) -> float:
    most = _number(driver, name, "gripper_max", 0.0, 2.0, "N m", 0.0)
    if most > 0.0 and not callable(getattr(driver, "grip", None)):
        what = f"driver {name} has gripper_max = {most:g} N m, and no function grip"
        raise DeviceError(what, mend="add grip(torque), or leave gripper_max out; see docs/device.md")
    return most


def as_reading(given: Any) -> Reading:
    """A `Reading`, from what a driver's ``read`` returned: a `Reading`, a tuple of its fields, or a pose.

    Raises:
        DeviceError: it is none of them.
    """
    if isinstance(given, Reading):
        return given
    given = tuple(given) if isinstance(given, tuple) else (given,)
    if 1 <= len(given) <= 4 and _shape(given[0]) == (4, 4):
        return Reading(*given)
    what = f"read() returned {type(given[0]).__name__} of shape {_shape(given[0])}" if given else "read() returned ()"
    raise DeviceError(what, mend="return a pose (4, 4) in metres, or palpate.devices.Reading(X, V, gripper, buttons)")


def _shape(value: Any) -> tuple[int, ...]:
    try:
        return tuple(np.shape(value))
    except ValueError:  # rows of different lengths
        return ()


def _number(
    driver: object, name: str, key: str, low: float, high: float, unit: str, default: float | None = None
) -> float:
    value = getattr(driver, key, default)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not low <= value <= high:
        what = f"driver {name}: {key} = {value!r} must be {low:g} to {high:g} {unit}"
        raise DeviceError(what, mend=f"set the attribute {key} of the class")
    return float(value)
