"""Devices: list the drivers, test a driver, and measure a device for its certificate. See docs/device.md."""

FIRST = ("list", "test", "bench")
