"""Resolves the names used in a fixture: files, places, frames and objects of the surrounding scene."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from palpate import _core
from palpate.base.arrays import Array
from palpate.base.errors import GuidanceError

if TYPE_CHECKING:
    from palpate.world.mesh import Mesh
    from palpate.world.surfaces import Surface

Body = "Mesh | Surface"


def _world_only() -> dict[str, _core.Frame]:
    return {"world": _core.MotionFrame()}


@dataclass(frozen=True)
class FixtureContext:
    """Context of a fixture. Without a scene it holds the world frame and finds files in the working folder."""

    file: Callable[[str], Path] = Path
    """returns the path of a file named in the scene"""
    frames: Mapping[str, _core.Frame] = field(default_factory=_world_only)
    """frames by name: world, leader, follower, tool, camera, and the scene's objects"""
    places: Mapping[str, npt.ArrayLike] = field(default_factory=dict)
    """named places, (3,) in W [m]"""
    bodies: Mapping[str, Mesh | Surface] = field(default_factory=dict)
    """surfaces of the scene's objects, each in its own frame"""

    def frame(self, name: str) -> _core.Frame:
        """The frame with this name.

        Raises:
            GuidanceError: the name is unknown; the message lists the known names.
        """
        return self.frames[self._known(name, self.frames, "frame")]

    @property
    def tool(self) -> _core.LiveFrame | None:
        """The live frame that a run sets to the measured tool pose; None without a scene."""
        frame = self.frames.get("tool")
        return frame if isinstance(frame, _core.LiveFrame) else None

    def body(self, name: str) -> Mesh | Surface:
        """The surface of the object with this name.

        Raises:
            GuidanceError: the name is unknown; the message lists the known names.
        """
        return self.bodies[self._known(name, self.bodies, "object")]

    def place(self, at: str | tuple[float, float, float], X_WF: Array) -> Array:
        """Position (3,) in F [m]. Numbers are given in F; a named place or an object's origin is converted from W.

        Raises:
            GuidanceError: neither a place nor an object has this name.
        """
        if not isinstance(at, str):
            return np.array(at, dtype=np.float64)
        fixed = {name: frame for name, frame in self.frames.items() if not isinstance(frame, _core.LiveFrame)}
        origins = {name: frame.at(0.0)[0][:3, 3] for name, frame in fixed.items() if name != "world"}
        known = {**origins, **self.places}
        p_W = np.asarray(known[self._known(at, known, "place")], dtype=np.float64)
        return np.asarray(X_WF[:3, :3].T @ (p_W - X_WF[:3, 3]))

    def _known(self, name: str, names: Mapping[str, object], kind: str) -> str:
        if name in names:
            return name
        near = difflib.get_close_matches(name, names, n=1)
        listed = ", ".join(names) or "none"
        raise GuidanceError(
            f"there is no {kind} {name!r}", mend=f"did you mean {near[0]!r}?" if near else f"{kind}s: {listed}"
        )
