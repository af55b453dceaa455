"""Changes to the fixtures of a running session: enabled, authority, pose. The core avoids force steps."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array
from palpate.base.values import Pose
from palpate.scene.guidance.context import FixtureContext
from palpate.scene.guidance.fixture import Fixture

if TYPE_CHECKING:
    from palpate import _guidance


@dataclass(frozen=True)
class FixtureState:
    """Present state of one fixture."""

    given: Fixture
    """the section as given, with changes of `enabled` and `authority` applied."""
    geometry: _guidance.Geometry
    """the geometry as given, in W."""
    X_WF: Array
    """(4, 4) pose of the fixture's frame at the start."""
    X_W: Array = field(default_factory=lambda: np.eye(4))
    """(4, 4) displacement in W since the fixture was given."""

    @property
    def section(self) -> Fixture:
        """The present state as a section of a scene file."""
        if np.array_equal(self.X_W, np.eye(4)):
            return self.given
        from scipy.spatial.transform import Rotation

        frame = self.given.frame
        X_FG = np.linalg.inv(self.X_WF) @ self.X_W @ self.X_WF @ frame.pose.matrix()
        rpy = Rotation.from_matrix(X_FG[:3, :3]).as_euler("xyz", degrees=True)
        pose = Pose(xyz=tuple(X_FG[:3, 3].tolist()), rpy_deg=tuple(rpy.tolist()))
        return self.given.model_copy(update={"frame": frame.model_copy(update={"pose": pose})})

    def core(self) -> _guidance.Fixture:
        """The present state for the core."""
        from palpate import _guidance

        still = np.array_equal(self.X_W, np.eye(4))
        return self.given.make_with(self.geometry if still else _guidance.PlacedGeometry(self.geometry, self.X_W))


class SteeredFixtures:
    """Fixtures by name. Every change passes the complete list on; the geometries are made only once.

    Args:
        sections: fixtures with unique names.
        context: files, frames, places and objects that the fixtures name.
        publish: receives the new list, as sections and for the core, in the calling thread.
    """

    def __init__(
        self,
        sections: Sequence[Fixture],
        context: FixtureContext,
        publish: Callable[[tuple[Fixture, ...], _guidance.Fixtures], None],
    ) -> None:
        self._publish, self._lock, self._tool = publish, threading.Lock(), context.tool
        self._now = {
            (f.name or f.role.name): FixtureState(f, f.make_geometry(context), context.frame(f.frame.of).at(0.0)[0])
            for f in sections
        }

    @property
    def names(self) -> tuple[str, ...]:
        """Names in the order that the signal `guidance_fixture` indexes."""
        return tuple(self._now)

    def __getitem__(self, name: str) -> FixtureState:
        """Present state of the fixture `name`; a KeyError lists the known names."""
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
        """Change one fixture: switch it, set its authority (0 to 1), or displace it from its given pose by X_W (4, 4).

        Raises:
            KeyError: no fixture has this name.
            ValueError: the authority is outside 0 to 1, or X_W is not a pose.
        """
        from palpate import _guidance

        if authority is not None and not 0.0 <= authority <= 1.0:
            raise ValueError(f"authority must lie in 0 .. 1. Got: {authority}")
        with self._lock:
            now = self[name]
            update = {"enabled": enabled, "authority": authority}
            given = now.given.model_copy(update={k: v for k, v in update.items() if v is not None})
            moved = now.X_W if X_W is None else np.array(X_W, dtype=np.float64)
            changed = {**self._now, name: replace(now, given=given, X_W=moved)}
            core = _guidance.Fixtures([one.core() for one in changed.values()], self._tool)
            self._publish(tuple(one.section for one in changed.values()), core)
            self._now = changed
