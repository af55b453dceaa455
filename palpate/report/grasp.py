"""What the jaws held: squeeze of both jaws, pull along the jaws, and the friction that could hold it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from html import escape

import numpy as np
from numpy.typing import NDArray

from palpate.record.ticks import SIGNALS
from palpate.report.run import Run

_HOLDS = 0.02  # force of a jaw below which it does not hold [N]
_SLIPS = 0.95  # share of the friction limit from which a grasp slips [-]

Row = NDArray[np.float64]


@dataclass(frozen=True)
class Grasp:
    """The jaws of a run that held an object."""

    run: Run
    name: str  #: of the object
    friction: float  #: coefficient of friction [-]

    @cached_property
    def jaws(self) -> tuple[Row, Row]:
        """Normal force of each jaw on the object (n,) [N], as far as the record has it."""
        first, second = (self._of(f"jaw_{k}") for k in (1, 2))
        return first, second

    @cached_property
    def pull(self) -> Row:
        """Force of the object on the tool along the jaws, towards their tips (n,) [N]."""
        w, x, y, z = self.run.ticks["quat_WT"].T
        along = np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], axis=1)  # z of T in W
        return np.asarray(np.einsum("ij,ij->i", self.run.ticks["F_T_W"], along))

    @cached_property
    def limit(self) -> Row:
        """Largest friction of both jaws together (n,) [N]."""
        return self.friction * (self.jaws[0] + self.jaws[1])

    @cached_property
    def held(self) -> NDArray[np.bool_]:
        """Ticks in which both jaws press (n,)."""
        return np.asarray(np.minimum(*self.jaws) > _HOLDS)

    def words(self) -> str:
        """The text above the figure."""
        t, rows = self.run.t, np.flatnonzero(self.held)
        squeeze = float(np.minimum(*self.jaws).max())
        text = (
            f"Both jaws held {escape(self.name)} from {t[rows[0]]:.2f} to {t[rows[-1]]:.2f} s, with up to "
            f"{squeeze:.2f} N on each side. Friction holds a pull of {self.friction:g} times both forces."
        )
        slips = rows[self.pull[rows] >= _SLIPS * self.limit[rows]]
        if not len(slips):
            return f"{text} It did not slip."
        return f"{text} It began to slip at {t[slips[0]]:.2f} s, at {self.pull[slips[0]]:.2f} N."

    def _of(self, jaw: str) -> Row:
        ticks = self.run.ticks
        spheres = [i for i, name in enumerate(self.run.sphere_names) if name.split(" ")[0] == jaw]
        valid = np.arange(SIGNALS["touch_sphere"].size) < ticks["contacts"][:, None]
        ours = valid & np.isin(ticks["touch_sphere"], spheres)
        return np.asarray(np.where(ours, ticks["touch_force"], 0.0).sum(axis=1))


def grasp_of(run: Run) -> Grasp | None:
    """The grasp of a run; None if the jaws never held anything from both sides."""
    objects = [obj for obj in run.setting("objects") or () if isinstance(obj, dict)]
    touched = run.ticks["touch_object"][run.ticks["contacts"] > 0, 0].astype(np.int64)
    if not len(touched) or not 0 <= (most := int(np.bincount(touched).argmax())) < len(objects):
        return None
    found = Grasp(run, str(objects[most].get("name")), float(objects[most].get("friction") or 0.0))
    return found if found.held.any() else None
