"""The 3-D viewer in the browser: looks at a session or a record, and lets a person take the hand (extra `viewer`)."""

from palpate.viewer.live import LiveViewer
from palpate.viewer.replay import ReplayViewer

__all__ = ["LiveViewer", "ReplayViewer"]
