"""The figures that a vendor publishes and a driver states, beside those that were measured."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.base.errors import DeviceError
from palpate.devices.bench import Bench
from palpate.devices.driver import Driver, facts


@dataclass(frozen=True)
class Published:
    """What a vendor publishes of a device; None: nothing."""

    device: str
    source: str
    force_max: float | None = None  # largest force [N]
    resolution: float | None = None  # of the position [m]
    mass: float | None = None  # apparent at the handle [kg]
    friction: float | None = None  # that resists a slow motion of the handle [N]


_QUOTED = "as commonly quoted, the sheet was not seen"
_CHAI = "CHAI3D 3.2.0 (github.com/chai3d/chai3d, src/devices)"
_FALCON = (
    "Novint's table in the wiki of H3DAPI (github.com/SenseGraphics/h3dapi/wiki/Novint_Falcon): over 400 dpi, 8.9 N"
)
_TOUCH = f"SensAble, 3D Systems: Touch, before PHANTOM Omni; force by {_CHAI}, the rest {_QUOTED}"
_TOUCH_X = f"SensAble, 3D Systems: Touch X, before PHANTOM Desktop; force by {_CHAI}, the rest {_QUOTED}"
_OMEGA = f"Force Dimension: omega.3, omega.6 and omega.7; force by {_CHAI}, steps {_QUOTED}"
_SIGMA = f"Force Dimension: sigma.7; {_QUOTED}; {_CHAI} has 12 N"
TABLE = (
    Published("touch", _TOUCH, 3.3, 55e-6, 0.045, 0.26),
    Published("touch-x", _TOUCH_X, 7.9, 23e-6, 0.045, 0.06),
    Published("omega.3", _OMEGA, 12.0, 10e-6),
    Published("sigma.7", _SIGMA, 20.0, 1.5e-6),
    Published("falcon", _FALCON, 8.9, 63.5e-6),
    Published("inverse3", "docs.haply.co/inverseSDK: a safe sphere of 0.1 m, no other figure"),
    Published("minverse", "docs.haply.co/inverseSDK: a safe sphere of 0.04 m, no other figure"),
)
"""One row per device. Vendors publish no damping and no delay. A row whose sheet was not seen may be wrong."""
_NOISE_STEPS = 6.0  # resolution over noise at rest, so that noise counts as no motion
NAMES = ", ".join(row.device for row in TABLE)
"""The devices of the table, in words."""


@dataclass(frozen=True)
class Stated:
    """A figure that a driver or a vendor states beside the measured one."""

    name: str
    unit: str
    stated: float
    measured: float
    source: str = ""  # of a published figure; empty: the driver states it

    @property
    def agrees(self) -> bool:
        """True if the device is as good as stated, within a tenth; a mass within a fifth either way."""
        if self.name == "mass":
            return abs(self.measured - self.stated) <= 0.2 * self.stated
        if self.name == "rate":
            return self.measured >= 0.9 * self.stated
        return self.measured <= 1.1 * self.stated + 1e-12

    def in_words(self) -> str:
        """Both figures in a sentence."""
        if self.source:
            verdict = "as published" if self.agrees else f"not as published ({self.source})"
            return f"{self.measured:.4g} {self.unit}, published {self.stated:.4g} {self.unit}: {verdict}"
        verdict = "as stated" if self.agrees else "not as stated: correct the attribute of the driver"
        return f"{self.measured:.4g} {self.unit}, stated {self.stated:.4g} {self.unit}: {verdict}"


def attributes_of(found: Bench) -> dict[str, float]:
    """What a driver may state of a device, by the names of its attributes; empty if the device was not pushed.

    Friction and damping are those that certainly resist, at the lower end of their 95 % intervals; the delay is at the
    upper end, and the resolution covers the noise. Zeros, which say nothing, are left out.
    """
    if not found.pushed:
        return {}
    model = found.model()
    resolution = max(max(axis.resolution_m or 0.0, _NOISE_STEPS * axis.noise_m) for axis in found.axes)
    values = {"resolution": resolution, "mass": found.model(0).mass, "delay": model.delay}
    if resolution > 0.0:
        values |= {"friction": model.friction, "damping": model.damping}
    return {name: float(f"{value:.3g}") for name, value in values.items() if value > 0.0}


def stated_by(driver: Driver, found: Bench) -> list[Stated]:
    """What the driver states of its device, beside what was measured; what it leaves out is not compared."""
    known = facts(driver, found.name)
    measured = _measured(found)
    rows = [Stated("rate", "Hz", known.rate, found.rate_Hz)]
    if known.resolution > 0.0 and "resolution" in measured:
        rows.append(Stated("resolution", "um", 1e6 * known.resolution, measured["resolution"]))
    if "mass" in measured and "mass" in {**vars(type(driver)), **vars(driver)}:
        rows.append(Stated("mass", "kg", known.mass, measured["mass"]))
    if "delay" in measured and known.delay is not None:
        rows.append(Stated("delay", "ms", 1e3 * known.delay, measured["delay"]))
    return rows


def published_of(name: str) -> Published:
    """The row of a device.

    Raises:
        DeviceError: the table has none of this name.
    """
    row = next((one for one in TABLE if one.device == name.strip().lower()), None)
    if row is None:
        raise DeviceError(f"no figures of a device {name!r} are known", mend=f"give one of {NAMES}")
    return row


def compare(row: Published, driver: Driver, found: Bench) -> list[Stated]:
    """The figures of a vendor beside the measured ones; the largest force beside the one that the driver commands."""
    measured, most = _measured(found), facts(driver, found.name).force_max
    if most > 0.0:
        measured["largest force"] = most
    stated = (
        ("resolution", "um", None if row.resolution is None else 1e6 * row.resolution),
        ("mass", "kg", row.mass),
        ("friction", "N", row.friction),
        ("largest force", "N", row.force_max),
    )
    return [
        Stated(name, unit, value, measured[name], row.source)
        for name, unit, value in stated
        if value is not None and name in measured
    ]


def _measured(found: Bench) -> dict[str, float]:
    """The worst axis of each figure, and the mean mass, in the units of `Stated`."""
    fits = [axis.fit for axis in found.axes if axis.fit is not None]
    steps = [axis.resolution_m for axis in found.axes if axis.resolution_m is not None]
    values = {"resolution": 1e6 * max(steps)} if steps else {}
    if fits:
        values["mass"] = float(np.mean([fit.mass for fit in fits]))
        values["friction"] = max(fit.friction for fit in fits)
        values["delay"] = 1e3 * max(fit.delay for fit in fits)
    return values
