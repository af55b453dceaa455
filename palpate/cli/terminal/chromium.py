"""Where Chromium is, which shows the viewer without a person: for pictures and measurements."""

from __future__ import annotations

import shutil

NAMES = ("chromium", "chromium-browser", "google-chrome")


def find() -> str | None:
    """Path of Chromium or Chrome; None if it is not installed."""
    return next((path for name in NAMES if (path := shutil.which(name))), None)
