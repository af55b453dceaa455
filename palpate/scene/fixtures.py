"""Converts the list ``guidance`` of a scene to the core's fixtures; resolves names of frames, places and files."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from palpate import _core
from palpate.base.arrays import Array
from palpate.base.arrays.plain import Content
from palpate.base.errors import MeshError, PalpateError, SceneError, SurfaceError
from palpate.scene import arms, materials, placing, surface
from palpate.scene.guidance.context import FixtureContext
from palpate.scene.guidance.fixture import Fixture
from palpate.scene.guidance.geometry import as_guidance_error
from palpate.scene.scene import Scene

if TYPE_CHECKING:
    from palpate import _guidance

#: Frames whose poses are set while a session runs; until then, fixtures attached to them have no effect.
LIVE = ("tool", "camera")


def fixture_context(scene: Scene, placed: list[surface.PlacedSurface], both: arms.Arms) -> FixtureContext:
    """Context that resolves the names in the scene's fixtures."""
    frames: dict[str, _core.Frame] = {"world": _core.MotionFrame()}
    frames |= {"leader": _core.MotionFrame(both.X_WL), "follower": _core.MotionFrame(both.X_WB)}
    frames |= {name: _core.LiveFrame() for name in LIVE}
    found = placing.graph(scene)
    follow = placing.tracked(scene, found)
    for name in found.frames[1:]:
        X_WF = found.pose(name).X
        frames[name] = _live(X_WF) if found.is_live(name) else _core.MotionFrame(X_WF)
    for obj, body in zip(scene.objects, placed, strict=True):
        moving = materials.motion(obj, body.bounds.mean(axis=0))
        frames[obj.name] = _live(body.X_WO) if obj.name in follow else _core.MotionFrame(body.X_WO, moving)
    places: dict[str, ArrayLike] = dict(scene.places)
    if both.follower.has_remote_centre:
        places.setdefault("rcm", both.X_WB[:3, 3])
    places.setdefault("start", (both.X_WB @ both.follower.fk(both.q_follower0))[:3, 3])
    bodies = {obj.name: body.body for obj, body in zip(scene.objects, placed, strict=True)}
    return FixtureContext(lambda name: scene.path_to(name, scene.where("guidance")), frames, places, bodies)


def _live(X_WF: Array) -> _core.LiveFrame:
    frame = _core.LiveFrame()
    frame.set(X_WF, np.zeros(6))
    return frame


def fixtures(scene: Scene, context: FixtureContext) -> _core.FixtureList:
    """The fixtures for the core, in the order of the scene. A scene without fixtures does not import `_guidance`.

    Raises:
        SceneError: a fixture is invalid; the message states the place in the file, the reason and the correction.
    """
    if not scene.guidance:
        return _core.FixtureList(context.tool)
    from palpate import _guidance

    made = [_made(scene, i, fixture, context) for i, fixture in enumerate(scene.guidance)]
    try:
        return _guidance.Fixtures(made, context.tool)
    except ValueError as error:
        found = as_guidance_error(error, "")
        raise SceneError(found.what, where=scene.where("guidance"), mend=found.mend) from None


def each(fixtures: _core.FixtureList) -> list[_guidance.Fixture]:
    """The fixtures of a list."""
    if len(fixtures) == 0:
        return []
    from palpate import _guidance

    assert isinstance(fixtures, _guidance.Fixtures)
    return fixtures.list()


def _made(scene: Scene, index: int, fixture: Fixture, context: FixtureContext) -> _guidance.Fixture:
    try:
        return fixture.make(context)
    except SceneError:
        raise
    except (MeshError, SurfaceError, PalpateError) as error:
        why = "; ".join(part for part in (error.where, error.why) if part)
        what = f"fixture {fixture.name!r}: {error.what}"
        raise SceneError(what, where=scene.where("guidance", index), why=why, mend=error.mend) from None


def files(data: Any) -> Iterator[Content]:
    """Yield every section with a key `file` in the plain values of fixtures."""
    if isinstance(data, dict):
        if isinstance(data.get("file"), str):
            yield data
        for value in data.values():
            yield from files(value)
    elif isinstance(data, list):
        for value in data:
            yield from files(value)
