"""Live sensing: point clouds that become surfaces beside the loop, and trackers of poses."""

from palpate.sensing.source import CloudFrame, CloudSource

__all__ = ["CloudFrame", "CloudSource"]
