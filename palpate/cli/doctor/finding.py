"""The result of one examination."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

State = Literal["ok", "optional", "problem"]


@dataclass(frozen=True)
class Finding:
    """One thing that was examined."""

    topic: str
    """Key of `examination.TOPICS`."""
    thing: str
    """What was examined, e.g. ``C++ compiler``."""
    state: State
    """``problem``: a session is worse or does not run; ``optional``: only what `needed_for` names lacks it."""
    found: str
    """Version, path or value, or what is missing."""
    needed_for: str = ""
    fix: str = ""
    """What to type or change; empty where nothing is wrong."""
