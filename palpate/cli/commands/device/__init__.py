"""Devices: list the drivers, test a driver, measure a device, stand in for one. See docs/device.md."""

FIRST = ("list", "test", "bench", "wrist", "stand-in")
