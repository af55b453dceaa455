"""The controls of a loop, with values of Python: lists are accepted, and messages name the control."""

from __future__ import annotations

import difflib
from typing import Any

import numpy as np

from palpate import _core
from palpate.base.errors import PalpateError

NAMES = tuple(name for name, member in vars(_core.Controls).items() if isinstance(member, property))
"""Names of all controls."""


class Controls(_core.Controls):
    """Clutch, pause, stiffness and damping scales, drag of the hand: a copy, which takes effect when it is assigned.

    controls = session.controls
    controls.p_hand_offset_W = [0, 0, -0.01]  # [m]
    session.controls = controls

    Raises:
        PalpateError: on assignment to an unknown name, or of a value of another type.
    """

    def __init__(self, values: _core.Controls | None = None) -> None:
        super().__init__()
        for name in NAMES if values is not None else ():
            super().__setattr__(name, getattr(values, name))

    def __setattr__(self, name: str, value: Any) -> None:
        if name not in NAMES:
            near = difflib.get_close_matches(name, NAMES, n=1)
            mend = f"did you mean {near[0]!r}?" if near else f"controls: {', '.join(NAMES)}"
            raise PalpateError(f"there is no control {name!r}", mend=mend)
        present = getattr(self, name)
        try:
            if isinstance(present, np.ndarray):
                value = np.asarray(value, dtype=np.float64)
            super().__setattr__(name, value)
        except (TypeError, ValueError):
            array = isinstance(present, np.ndarray)
            numbers = "three numbers [m]" if np.size(present) == 3 else "four numbers w, x, y, z"
            kind = numbers if array else type(present).__name__
            what = f"controls.{name} must be {kind}. Got: {value!r:.60}"
            raise PalpateError(what, mend=f"assign e.g. {present.tolist() if array else present}") from None
