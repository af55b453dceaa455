"""Devices of the user: drivers and their loops, measurements of a device, and its certificate."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from palpate.devices.driver import Driver, Reading
    from palpate.devices.open import open_driver

__all__ = ["Driver", "Reading", "open_driver"]
_HOME = {
    "Driver": "driver",
    "Reading": "driver",
    "open_driver": "open",
}


def __getattr__(name: str) -> Any:
    """Import drivers at first use: a certificate needs neither."""
    if name in _HOME:
        return getattr(import_module(f"palpate.devices.{_HOME[name]}"), name)
    raise AttributeError(f"module 'palpate.devices' has no attribute {name!r}")
