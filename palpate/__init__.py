"""Palpate: feel virtual and scanned anatomy through a surgical robot's master arm."""

from importlib.metadata import version

__version__ = version("palpate")
