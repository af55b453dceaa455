"""Devices of the user: `palpate.Haptics`, drivers, measurements of a device, and its certificate."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from palpate.devices.driver import Driver, Reading
    from palpate.devices.haptics import Haptics
    from palpate.devices.open import open_driver
    from palpate.devices.pairs import DrivenPairs
    from palpate.devices.session import DeviceSession, DrivenSession

__all__ = ["DeviceSession", "DrivenPairs", "DrivenSession", "Driver", "Haptics", "Reading", "open_driver"]
_HOME = {
    "DeviceSession": "session",
    "DrivenPairs": "pairs",
    "DrivenSession": "session",
    "Driver": "driver",
    "Haptics": "haptics",
    "Reading": "driver",
    "open_driver": "open",
}


def __getattr__(name: str) -> Any:
    """Import sessions and drivers at first use: a certificate needs neither."""
    if name in _HOME:
        return getattr(import_module(f"palpate.devices.{_HOME[name]}"), name)
    raise AttributeError(f"module 'palpate.devices' has no attribute {name!r}")
