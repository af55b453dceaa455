"""Options of an export."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class Options:
    """Options of an export; each format uses those that it needs."""

    names: Literal["openh", "dvrk"] = "openh"
    """LeRobot: names of Open-H-Embodiment, or those of the dVRK's data collection."""
    version: Literal["3.0", "2.1"] = "3.0"
    """LeRobot: version of the format."""
    fps: int = 30
    """LeRobot, Minari, and the tool of Rerun: frames per second."""
    task: str = ""
    """LeRobot and Minari: the instruction of every episode; named after the scene when left out."""
    video: bool = False
    """LeRobot: also render the surgeon's view of each frame."""
    keep_records: bool = False
    """LeRobot: also copy the records, which hold every tick, into the data set."""
    mixed: bool = False
    """LeRobot and Minari: allow records of different scenes in one data set."""
    forces: str | os.PathLike[str] | None = None
    """Bags: a record of Palpate's node that ran meanwhile, whose forces are exported with them."""
    signals: tuple[str, ...] = ()
    """Tables: names of the signals; all that were recorded when left out."""
    every: int = 1
    """Tables: keep each n-th tick."""
