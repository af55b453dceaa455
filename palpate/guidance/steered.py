"""The fixtures of a session while it runs: switched, weighed, moved. The core fades over: never a step in the force."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from palpate import _core
from palpate.arrays import Array
from palpate.guidance.fixture import Fixture
from palpate.guidance.here import Here
from palpate.values import Pose


@dataclass(frozen=True)
class Now:
    """How one fixture is now."""

    given: Fixture
    """as it was given, with what was switched and weighed since."""
    geometry: _core.Geometry
    """where it was given, in W."""
    X_WF: Array
    """(4, 4) of the frame that it is attached to, at the start."""
    X_W: Array = field(default_factory=lambda: np.eye(4))
    """(4, 4): how it was moved since, in W [m]."""

    @property
    def section(self) -> Fixture:
        """As a scene file would have it now."""
        if np.array_equal(self.X_W, np.eye(4)):
            return self.given
        from scipy.spatial.transform import Rotation

        frame = self.given.frame
        X_FG = np.linalg.inv(self.X_WF) @ self.X_W @ self.X_WF @ frame.pose.matrix()
        rpy = Rotation.from_matrix(X_FG[:3, :3]).as_euler("xyz", degrees=True)
        pose = Pose(xyz=tuple(X_FG[:3, 3].tolist()), rpy_deg=tuple(rpy.tolist()))
        return self.given.model_copy(update={"frame": frame.model_copy(update={"pose": pose})})

    def core(self) -> _core.Fixture:
        """For the core."""
        still = np.array_equal(self.X_W, np.eye(4))
        return self.given.made_of(self.geometry if still else _core.PlacedGeometry(self.geometry, self.X_W))


class SteeredFixtures:
    """Fixtures by name, handed over whole after every change; what is heavy to make of them is made once.

    Args:
        sections: their names differ.
        here: what the names in them stand for.
        give: takes the new list, as sections and for the core; any thread may call.
    """

    def __init__(
        self,
        sections: Sequence[Fixture],
        here: Here,
        give: Callable[[tuple[Fixture, ...], _core.Fixtures], None],
    ) -> None:
        self._give, self._lock, self._tool = give, threading.Lock(), here.tool
        self._now = {
            (one.name or one.role.name): Now(one, one.make_geometry(here), here.frame(one.frame.of).at(0.0)[0])
            for one in sections
        }

    @property
    def names(self) -> tuple[str, ...]:
        """In order, which is that of the signal `guidance_fixture`."""
        return tuple(self._now)

    def __getitem__(self, name: str) -> Now:
        """How it is now; KeyError names those there are."""
        if name not in self._now:
            raise KeyError(f"no fixture {name!r}; there are: {', '.join(self._now) or 'none'}")
        return self._now[name]

    def change(
        self,
        name: str,
        *,
        enabled: bool | None = None,
        authority: float | None = None,
        X_W: npt.ArrayLike | None = None,
    ) -> None:
        """Switch one on or off, weigh it anew (0 to 1), move it from where it was given by X_W (4, 4).

        Raises:
            KeyError: no fixture of that name.
            ValueError: an authority outside of 0 to 1, no pose.
        """
        if authority is not None and not 0.0 <= authority <= 1.0:
            raise ValueError(f"authority must lie in 0 .. 1. Got: {authority}")
        with self._lock:
            now = self[name]
            update = {"enabled": enabled, "authority": authority}
            given = now.given.model_copy(update={k: v for k, v in update.items() if v is not None})
            moved = now.X_W if X_W is None else np.array(X_W, dtype=np.float64)
            changed = {**self._now, name: replace(now, given=given, X_W=moved)}
            core = _core.Fixtures([one.core() for one in changed.values()], self._tool)
            self._give(tuple(one.section for one in changed.values()), core)
            self._now = changed
