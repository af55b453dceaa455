"""Streams of point clouds: sources of frames, and what turns a frame into a surface beside the running loop."""

from palpate.sensing.source import CloudFrame, CloudSource

__all__ = ["CloudFrame", "CloudSource"]
