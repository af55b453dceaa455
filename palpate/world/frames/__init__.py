"""The graph of frames: arm bases, cameras, trackers, markers and anatomy, with poses, covariances, sources and ages."""

from __future__ import annotations

from typing import TYPE_CHECKING

from palpate.base import lazy

if TYPE_CHECKING:
    from palpate.world.frames.edge import Edge
    from palpate.world.frames.graph import Disagreement, FrameGraph, FramePose
    from palpate.world.frames.section import FrameSection

__all__ = ["Disagreement", "Edge", "FrameGraph", "FramePose", "FrameSection"]

_HOMES = {
    "Edge": "edge",
    "Disagreement": "graph",
    "FrameGraph": "graph",
    "FramePose": "graph",
    "FrameSection": "section",
}

__getattr__ = lazy.names(__name__, _HOMES)
