"""The stable rotational stiffness of a wrist axis, from a recording of its angle and its commanded torque.

The axis is identified by `identify.fit_axis` as ``inertia a'' + damping a' + friction sign(a') = torque(t - delay)``
and certified as the linear device that fingers feel at the lever L from the axis: mass = inertia / L^2,
damping / L^2, friction / L, encoder step * L, and K_rot = K L^2. L only says which taps and presses are tried.

A recording does not show everything. A free decay (no torque) holds only the ratios damping / inertia and
friction / inertia, and no delay: it allows no stiffness. Friction and damping are separated by motions of different
speed only. The delay is found in whole periods of the recording, so that another half period is added.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from palpate import _core
from palpate.arm.hands import Hand
from palpate.base import limits
from palpate.base.arrays import Array
from palpate.base.errors import RecordingError
from palpate.devices.certificate import DeviceModel, certify
from palpate.devices.identify import AxisFit, fit_axis, resolution

COLUMNS = ("time_s", "angle_rad", "torque_Nm")
LEVER = 0.05
"""Distance of the fingers from the axis [m]."""
_PARTS = 4  # of a recording; the axis is identified in each
_WIDTH = 0.6  # width of the fit's test functions over the shortest time between two signs of the torque
_KNOWN = 0.5  # relative spread of the parts from which a value counts as not identifiable
_FREE = Hand("free", 1e-4, 1e-3, 1e-2)


@dataclass(frozen=True)
class Wrist:
    """A wrist axis as identified, in each part of the recording, and its limits."""

    rate_Hz: float
    resolution_rad: float
    """Step of the measured angle; 0: none seen."""
    fits: tuple[AxisFit, ...]
    """By part: mass is the inertia [kg m^2], damping [N m s/rad], friction, bias and residual [N m], delay [s]."""
    k_max: float
    """Stable limit of the part in which it is smallest, for a free and a held handle [N m/rad]."""
    k_linear: float
    """The same without friction and encoder steps [N m/rad]."""
    frequency: float
    """Of the oscillation at the limit [Hz]."""
    verdict: str | None
    """On the stiffness to judge: stable, marginal or unstable."""

    def spread(self, key: str) -> tuple[float, float]:
        """Smallest and largest value of a field of `AxisFit` in all parts."""
        values = [float(getattr(fit, key)) for fit in self.fits]
        return min(values), max(values)

    def uncertain(self) -> list[str]:
        """Names of the values that the parts do not agree on."""
        names = {"mass": "inertia", "damping": "damping", "friction": "friction"}
        spread = {name: self.spread(key) for key, name in names.items()}
        return [name for name, (low, high) in spread.items() if high - low > _KNOWN * abs(high + low)]


def load(path: str | Path) -> tuple[Array, Array, Array]:
    """Times (n,) [s], angles (n,) [rad] and commanded torques (n,) [N m] of a CSV with `COLUMNS`.

    Raises:
        RecordingError: the file cannot be read, lacks a column, or its rows are not evenly spaced, finite numbers.
    """
    path, mend = Path(path), f"write a CSV with the columns {', '.join(COLUMNS)}"
    try:
        header, _, rows = limits.read_text(path, limits.MOST_TABLE).partition("\n")
        names = [name.strip() for name in header.split(",")]
        lacking = [name for name in COLUMNS if name not in names]
        if lacking:
            raise RecordingError(f"no column {lacking[0]}", where=str(path), mend=mend)
        columns = [names.index(name) for name in COLUMNS]
        t, angle, torque = np.loadtxt(rows.splitlines(), delimiter=",", usecols=columns, ndmin=2).reshape(-1, 3).T
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or str(error).partition("\n")[0]
        raise RecordingError("the recording cannot be read", where=str(path), why=why, mend=mend) from None
    if not (np.isfinite(t) & np.isfinite(angle) & np.isfinite(torque)).all():
        raise RecordingError("a value is no finite number", where=str(path), mend="delete its row")
    gaps = np.diff(t)
    if len(t) < 200 or gaps.min() < 0.5 * np.median(gaps) or gaps.max() > 1.5 * np.median(gaps):
        what = f"{len(t)} rows, not evenly spaced in time" if len(t) >= 200 else f"{len(t)} rows are too few"
        raise RecordingError(what, where=str(path), mend="record some seconds at the rate of the haptic cycle")
    return t, angle, torque


def certify_wrist(t: Array, angle: Array, torque: Array, K: float | None = None, B: float = 0.0) -> Wrist:
    """Identify a wrist axis and certify a rotational spring and damper on it.

    Args:
        t, angle, torque: recording (n,) [s, rad, N m]; the torque alternates and nobody holds the handle.
        K: stiffness to judge [N m/rad]; None: only the limit.
        B: damping [N m s/rad].

    Raises:
        RecordingError: the recording does not determine the limit; the message says why.
    """
    rate, step = 1.0 / float(np.median(np.diff(t))), resolution(angle)
    fits = _fits(t, angle, torque)
    devices = [_device(fit, rate, step) for fit in fits]
    b = B / LEVER**2
    least = min(devices, key=lambda one: min(one.loop(hand, lubricated=False).K_max(b)[0] for hand in one.hands))
    found = certify(least, None if K is None else K / LEVER**2, b)
    return Wrist(rate, step, fits, LEVER**2 * found.k_max, LEVER**2 * found.k_linear, found.frequency, found.verdict)


def _fits(t: Array, angle: Array, torque: Array) -> tuple[AxisFit, ...]:
    changes = np.flatnonzero(np.diff(np.signbit(torque)))
    if float(np.ptp(torque)) == 0.0 or len(changes) < 2 * _PARTS:
        why = "without a changing torque only damping / inertia and friction / inertia show, and no delay"
        mend = "command a torque that alternates, with periods of different length"
        raise RecordingError(f"the torque changes its sign {len(changes)} times", why=why, mend=mend)
    width = _WIDTH * float(np.diff(t[changes]).min())
    parts = np.array_split(np.arange(len(t)), _PARTS)
    fits = [fit_axis(t[rows], angle[rows], torque[rows], width) for rows in parts]
    if any(fit is None for fit in fits):
        why = f"the axis hardly moved under {float(np.abs(torque).max()):.3g} N m"
        raise RecordingError("the inertia is not identifiable", why=why, mend="use a torque well above the friction")
    known = tuple(fit for fit in fits if fit is not None)
    if min(fit.mass for fit in known) <= 0.0:
        why = "the fit of a part of the recording is not positive: noise exceeds what the torque moves"
        raise RecordingError("the inertia is not identifiable", why=why, mend="record longer, or with more torque")
    return known


def _device(fit: AxisFit, rate: float, step: float) -> DeviceModel:
    """The linear device that fingers feel at the lever, free or held."""
    o = _core.HandOptions()
    held = Hand("held", o.inertia / LEVER**2, o.rotational_damping / LEVER**2, o.rotational_stiffness / LEVER**2)
    return DeviceModel(
        mass=fit.mass / LEVER**2,
        damping=max(fit.damping, 0.0) / LEVER**2,
        friction=max(fit.friction, 0.0) / LEVER,
        quantum=step * LEVER,
        rate=rate,
        delay=fit.delay + 0.5 / rate,
        hand=(_FREE, held),
    )
