"""Stage `force` in a scene file: virtual surfaces, what the follower really touches, or both."""

from __future__ import annotations

from typing import Literal

from palpate import _core
from palpate.values import NotNegative, Positive, Section

_E = _core.EstimateOptions()
Presence = Literal["both", "virtual", "real"]


class ForceSection(Section):
    """Where the force on the tool that the hand feels comes from."""

    source: Literal["contact", "estimate", "both"] = "contact"
    """contact: the virtual surfaces; estimate: the follower's drive torques, what its tool really touches (simulated:
    the objects push a follower with drives and weight); both: their sum"""
    bandwidth: Positive = _E.bandwidth
    """of the estimate's momentum observer [Hz]"""
    dead_band: NotNegative = _E.dead_band
    """estimated forces below it are not felt: friction that the model does not know [N]"""
    dynamics: str | None = None
    """the follower as `palpate calibrate dynamics` identified it, for the estimate: a file beside the scene;
    the arm's own model file when left out"""
