"""Section `force` of a scene file: force from virtual surfaces, from the estimated contact force, or both."""

from __future__ import annotations

from typing import Literal

from palpate import _core
from palpate.base.values import NotNegative, Positive, Section

_E = _core.EstimateOptions()
Presence = Literal["both", "virtual", "real"]


class ForceSection(Section):
    """Source of the tool force that is rendered to the hand."""

    source: Literal["contact", "estimate", "both"] = "contact"
    """contact: virtual surfaces; estimate: real contact force, estimated from the follower's drive torques (in
    simulation, the objects push a follower with drives and weight); both: the sum"""
    bandwidth: Positive = _E.bandwidth
    """bandwidth of the momentum observer that estimates the force [Hz]"""
    dead_band: NotNegative = _E.dead_band
    """estimated forces below this are not rendered, because unmodelled friction causes them [N]"""
    dynamics: str | None = None
    """identified dynamics of the follower for the estimate: a file of `palpate calibrate dynamics`, relative to the
    scene file; the arm's model file when left out"""
