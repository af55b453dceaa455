"""The graph of frames: arm bases, cameras, trackers, markers and anatomy, with poses, covariances, sources and ages."""

from palpate.world.frames.edge import Edge
from palpate.world.frames.graph import Disagreement, FrameGraph, FramePose
from palpate.world.frames.section import FrameSection

__all__ = ["Disagreement", "Edge", "FrameGraph", "FramePose", "FrameSection"]
