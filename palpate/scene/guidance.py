"""The list ``guidance`` of a scene as the core's fixtures: names of frames, places, objects and files are looked up."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from palpate import _core
from palpate.errors import MeshError, PalpateError, SceneError, SurfaceError
from palpate.guidance.fixture import Fixture
from palpate.guidance.geometry import refused
from palpate.guidance.here import Here
from palpate.scene import arms, materials, surface
from palpate.scene.scene import Scene

#: Frames that are told where they are while a session runs; until then what is attached to them counts for nothing.
LIVE = ("tool", "camera")


def here(scene: Scene, placed: list[surface.Surface], both: arms.Arms) -> Here:
    """What the names in the scene's fixtures stand for."""
    frames: dict[str, _core.Frame] = {"world": _core.MotionFrame()}
    frames |= {"leader": _core.MotionFrame(both.X_WL), "follower": _core.MotionFrame(both.X_WB)}
    frames |= {name: _core.LiveFrame() for name in LIVE}
    for thing, body in zip(scene.objects, placed, strict=True):
        frames[thing.name] = _core.MotionFrame(body.X_WO, materials.motion(thing, body.bounds.mean(axis=0)))
    places: dict[str, Any] = dict(scene.places)
    if both.follower.has_remote_centre:
        places.setdefault("rcm", both.X_WB[:3, 3])
    places.setdefault("start", (both.X_WB @ both.follower.fk(both.q_follower0))[:3, 3])
    bodies = {thing.name: body.body for thing, body in zip(scene.objects, placed, strict=True)}
    return Here(lambda name: scene.path_to(name, scene.where("guidance")), frames, places, bodies)


def fixtures(scene: Scene, around: Here) -> _core.Fixtures:
    """As the core knows them, in the scene's order.

    Raises:
        SceneError: one of them cannot be; says where in the file, why, and how to mend it.
    """
    made = [_made(scene, i, fixture, around) for i, fixture in enumerate(scene.guidance)]
    try:
        return _core.Fixtures(made, around.tool)
    except ValueError as error:
        told = refused(error, "")
        raise SceneError(told.what, where=scene.where("guidance"), mend=told.mend) from None


def _made(scene: Scene, index: int, fixture: Fixture, around: Here) -> _core.Fixture:
    try:
        return fixture.make(around)
    except SceneError:
        raise
    except (MeshError, SurfaceError, PalpateError) as error:
        why = "; ".join(part for part in (error.where, error.why) if part)
        what = f"fixture {fixture.name!r}: {error.what}"
        raise SceneError(what, where=scene.where("guidance", index), why=why, mend=error.mend) from None


def files(data: Any) -> Iterator[dict[str, Any]]:
    """Every section below plain values of a fixture that names a file."""
    if isinstance(data, dict):
        if isinstance(data.get("file"), str):
            yield data
        for value in data.values():
            yield from files(value)
    elif isinstance(data, list):
        for value in data:
            yield from files(value)
