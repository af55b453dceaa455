"""A haptic device with one axis: its parameters, its linear loop for the analysis, and its simulated loop."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import yaml

from palpate.arm.hands import PRESETS, Hand
from palpate.base.arrays import Array
from palpate.base.arrays.yaml_loader import read_yaml
from palpate.base.errors import OutputError, PalpateError, RecordingError
from palpate.devices.certificate.loop import SampledLoop, difference

if TYPE_CHECKING:
    from palpate import _verify

#: Speed of the fastest tap that a certificate considers [m/s]. Dry friction damps the fastest tap least.
TAP = 0.5


def as_viscous(friction: float | Array, speed: float | Array) -> Array:
    """Viscous friction that dissipates as much as dry friction in an oscillation of velocity amplitude `speed`.

    This is the describing function 4 Fc / (pi v) (Gelb and Vander Velde 1968, 2.3). Units: [N] and [m/s] give [N s/m];
    [N m] and [rad/s] give [N m s/rad].
    """
    return np.asarray(4.0 * friction / (np.pi * speed))


_KEYS = ("mass", "damping", "rate", "delay", "jitter", "filter", "quantum", "friction")


def is_device(path: Path) -> bool:
    """True for a file that says ``kind: device``; False also for a file that cannot be read."""
    try:
        data = read_yaml(path)
    except (OSError, UnicodeDecodeError, yaml.YAMLError):
        return False
    return isinstance(data, dict) and data.get("kind") == "device"


def _number(key: str, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ValueError(f"{key} = {value!r} is no number")
    return float(value)


@dataclass(frozen=True)
class DeviceModel:
    """A device along one direction, its haptic loop, and the hands that hold it. All values are in SI units.

    Raises:
        PalpateError: a value is outside its physical range; the error names the value.
    """

    mass: float
    """Moving mass [kg]."""
    damping: float
    """Viscous friction of the device itself [N s/m]."""
    rate: float = 1000.0
    """Rate of the haptic cycle [Hz]."""
    delay: float = 0.0
    """Time from the position measurement to the force on the hand [s]."""
    jitter: float = 0.0
    """Upper bound of the random delay that is added in each cycle, uniform from 0 [s]."""
    filter: float = 0.0
    """Cut-off of the velocity's low pass; 0: the unfiltered difference of two positions [Hz]."""
    quantum: float = 0.0
    """Resolution of the position measurement at the handle; 0: ideal [m]."""
    friction: float = 0.0
    """Dry friction of the device at the handle [N]."""
    hand: Hand | tuple[Hand, ...] = tuple(PRESETS.values())
    """One hand, or the range of hands for which the loop must be stable."""

    def __post_init__(self) -> None:
        """Refuse values outside their physical range."""
        from palpate import _verify  # compiled on first use

        try:
            _verify.Axis(self.axis(self.hands[0], 0.0, 0.0))
        except ValueError as error:
            what, _, mend = str(error).partition(": ")
            raise PalpateError(what.replace("axis", "device"), mend=mend) from None

    def save(self, path: str | Path, notes: Mapping[str, object] | None = None) -> None:
        """Write the device as YAML, which `load` and ``palpate certify`` read; the hands are not written.

        Raises:
            OutputError: the file cannot be written.
        """
        values = {key: float(getattr(self, key)) for key in _KEYS}
        text = yaml.safe_dump({"kind": "device", **values, "notes": dict(notes or {})}, sort_keys=False)
        try:
            Path(path).write_text(f"# A haptic device; judge it with: palpate certify {path} --stiffness 400\n{text}")
        except OSError as error:
            why = error.strerror or str(error)
            raise OutputError("the file cannot be written", where=str(path), why=why, mend="use --out") from None

    @classmethod
    def load(cls, path: str | Path) -> DeviceModel:
        """Read a device that `save` or ``palpate device bench`` wrote.

        Raises:
            RecordingError: the file cannot be read or does not describe a device; the message names the value.
        """
        try:
            data = read_yaml(Path(path))
            if not isinstance(data, dict) or data.get("kind") != "device":
                raise ValueError("it has no line kind: device")
            wrong = [key for key in data if key not in (*_KEYS, "kind", "notes")]
            if wrong:
                raise ValueError(f"unknown key {wrong[0]!r}; known: {', '.join(_KEYS)}")
            values: dict[str, Any] = {key: _number(key, data[key]) for key in _KEYS if key in data}
            return cls(**values)
        except (OSError, UnicodeDecodeError, yaml.YAMLError, ValueError, TypeError) as error:
            why = getattr(error, "strerror", None) or str(error).partition("\n")[0]
            mend = "write one with palpate device bench --out device.yaml"
            raise RecordingError("the file does not describe a device", where=str(path), why=why, mend=mend) from None

    @property
    def hands(self) -> tuple[Hand, ...]:
        """The range of hands."""
        return (self.hand,) if isinstance(self.hand, Hand) else self.hand

    def loop(self, hand: Hand, lubricated: bool = True) -> SampledLoop:
        """Device and hand as a linear loop; the full jitter is added to the delay.

        lubricated: leave dry friction out. Otherwise it is replaced by the viscous friction that dissipates as much in
        an oscillation of velocity amplitude `TAP` (`as_viscous`).
        """
        M = self.mass + hand.mass
        D = self.damping + hand.damping + (0.0 if lubricated else as_viscous(self.friction, TAP))
        A = np.array([[0.0, 1.0], [-hand.stiffness / M, -D / M]])
        T = 1.0 / self.rate
        return SampledLoop(A, np.array([0.0, 1.0 / M]), np.array([1.0, 0.0]), T, self.delay + self.jitter,
                    velocity=difference(T, self.filter))  # fmt: skip

    def axis(self, hand: Hand, K: float, B: float, bilateral: bool = False) -> _verify.AxisOptions:
        """Options of the simulated axis with all nonlinear effects, for a wall of K [N/m] and B [N s/m]."""
        from palpate import _verify

        o = _verify.AxisOptions()
        o.mass, o.damping, o.coulomb, o.rate = self.mass, self.damping, self.friction, self.rate
        o.delay, o.jitter, o.quantum, o.velocity_cutoff = self.delay, self.jitter, self.quantum, self.filter
        o.hand_mass, o.hand_damping, o.hand_stiffness = hand.mass, hand.damping, hand.stiffness
        o.K, o.B, o.bilateral = K, B, bilateral
        return o
