"""The graph of frames: arm bases, cameras, trackers, markers and anatomy, with poses, covariances, sources and ages."""

from palpate.frames.edge import Edge
from palpate.frames.graph import Disagreement, FrameGraph, FramePose
from palpate.frames.section import FrameSection

__all__ = ["Disagreement", "Edge", "FrameGraph", "FramePose", "FrameSection"]
