"""Devices of the user: the haptic cycle for anybody's loop, drivers, and measurements of a device (docs/device.md)."""

from __future__ import annotations

from palpate.devices.driver import Driver, Reading
from palpate.devices.haptics import Haptics
from palpate.devices.open import open_driver
from palpate.devices.pairs import DrivenPairs
from palpate.devices.session import DeviceSession, DrivenSession

__all__ = ["DeviceSession", "DrivenPairs", "DrivenSession", "Driver", "Haptics", "Reading", "open_driver"]
