"""What the names in a fixture stand for: files, places, frames and objects of the scene around it."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from palpate import _core
from palpate.arrays import Array
from palpate.errors import GuidanceError

if TYPE_CHECKING:
    from palpate.mesh import Mesh
    from palpate.surfaces import Surface

Body = "Mesh | Surface"


def _still() -> dict[str, _core.Frame]:
    return {"world": _core.MotionFrame()}


@dataclass(frozen=True)
class Here:
    """Where a fixture is used. Without a scene: files from the working folder, and the world."""

    file: Callable[[str], Path] = Path
    """a file by the name that the scene gives it"""
    frames: Mapping[str, _core.Frame] = field(default_factory=_still)
    """by name: world, leader, follower, tool, camera, and the scene's objects"""
    places: Mapping[str, npt.ArrayLike] = field(default_factory=dict)
    """named places, (3,) in W [m]"""
    bodies: Mapping[str, Mesh | Surface] = field(default_factory=dict)
    """the scene's objects, each in its own frame"""

    def frame(self, name: str) -> _core.Frame:
        """The frame of that name.

        Raises:
            GuidanceError: there is none; names those there are.
        """
        return self.frames[self._known(name, self.frames, "frame")]

    @property
    def tool(self) -> _core.LiveFrame | None:
        """The frame that a run tells where its tool is; None without a scene."""
        frame = self.frames.get("tool")
        return frame if isinstance(frame, _core.LiveFrame) else None

    def body(self, name: str) -> Mesh | Surface:
        """The object of that name.

        Raises:
            GuidanceError: there is none; names those there are.
        """
        return self.bodies[self._known(name, self.bodies, "object")]

    def place(self, at: str | tuple[float, float, float], X_WF: Array) -> Array:
        """(3,) in F: numbers are in F already, a named place or an object's origin is in W.

        Raises:
            GuidanceError: no place and no object has that name.
        """
        if not isinstance(at, str):
            return np.array(at, dtype=np.float64)
        still = {name: frame for name, frame in self.frames.items() if not isinstance(frame, _core.LiveFrame)}
        origins = {name: frame.at(0.0)[0][:3, 3] for name, frame in still.items() if name != "world"}
        known = {**origins, **self.places}
        p_W = np.asarray(known[self._known(at, known, "place")], dtype=np.float64)
        return np.asarray(X_WF[:3, :3].T @ (p_W - X_WF[:3, 3]))

    def _known(self, name: str, names: Mapping[str, object], kind: str) -> str:
        if name in names:
            return name
        near = difflib.get_close_matches(name, names, n=1)
        there = ", ".join(names) or "none"
        raise GuidanceError(
            f"there is no {kind} {name!r}", mend=f"did you mean {near[0]!r}?" if near else f"{kind}s: {there}"
        )
