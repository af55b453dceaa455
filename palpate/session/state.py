"""State of a session at its newest tick, for callbacks and progress lines."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from palpate.record.ticks import Ticks
from palpate.session import machine


@dataclass(frozen=True)
class State:
    """State of a session at its newest tick. `tick` contains every signal."""

    tick: Ticks  # one row of `TICK`
    phase: str  # phase of the operator's path: approach, press, slide, leave; empty if unknown

    @property
    def t(self) -> float:
        """Time of the tick [s]."""
        return float(self.tick["t"])

    @property
    def session(self) -> str:
        """State of the session: off, powered, homing, ..., following (docs/session.md)."""
        return machine.name_of(float(self.tick["session_state"]))

    @property
    def force(self) -> float:
        """Magnitude of the force commanded on the hand [N]."""
        return float(np.linalg.norm(self.tick["F_H_L"]))

    @property
    def F_T_W(self) -> np.ndarray[Any, np.dtype[np.float64]]:
        """Force of the environment on the tool (3,) [N]."""
        return np.asarray(self.tick["F_T_W"])

    @property
    def depth(self) -> float:
        """Penetration depth [m]."""
        return float(self.tick["depth"])

    @property
    def contacts(self) -> int:
        """Number of touched objects."""
        return int(self.tick["contacts"])

    @property
    def cycle_us(self) -> float:
        """Compute time of the haptic cycle [us]."""
        return float(self.tick["cycle_us"])
