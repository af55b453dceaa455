"""Turns the frames of a session's sources into the surfaces of its objects, while the loop runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from palpate import _core
from palpate.base.arrays import Array
from palpate.base.errors import SceneError
from palpate.record import live
from palpate.record.ticks import Ticks, as_tick
from palpate.scene import materials, placing, surface
from palpate.scene.live_targets import SharedTargets, Target
from palpate.scene.rig import Rig
from palpate.sensing.instrument import Instrument
from palpate.sensing.source import CloudFrame, CloudSource, Hearing
from palpate.sensing.stream import Stream

if TYPE_CHECKING:
    from palpate import _tissue

PERIOD = 0.002
"""Period at which sources are asked in real time [s]."""
_EARLY = 0.5  # silence that is told at the end of a run [s]


class _Loop(Protocol):
    def set_live(self, targets: _core.LiveTargets, /) -> None:
        """Set the poses that live objects shall reach."""
        ...

    def set_snapshot(self, snapshot: _core.Snapshot, /) -> None:
        """Replace the scene as a whole."""
        ...

    def latest(self) -> Any:
        """The newest row."""
        ...


class Sensing:
    """The objects of a rig that are clouds of a sensor.

    Every frame becomes a new surface in this thread; the core builds it with the interpreter lock released. The loop
    takes it as a whole at its next tick. Between two frames the surface moves on with its estimated velocity
    (`_core.Approach`). Without a frame for longer than the section's `patience` it stops, and its force fades.

    Args:
        rig: the rig of the scene.
        loop: the loop that renders the objects.
        sources: sources by the name that the scene's `cloud: {sensor: NAME}` gives, or by the name of the object.
        extrapolate: False: surfaces rest between two frames, for comparison.
        targets: targets of all live objects of the loop, which trackers share; own ones when None.

    Raises:
        SceneError: an object has no source, or a source belongs to no object.
    """

    def __init__(
        self,
        rig: Rig,
        loop: _Loop,
        sources: Mapping[str, CloudSource],
        *,
        extrapolate: bool = True,
        targets: SharedTargets | None = None,
    ) -> None:
        import scipy.spatial  # noqa: F401 - here, because an import would delay the first frame

        self._rig, self._loop = rig, loop
        self._sources = _by_object(rig, sources)
        instrument = Instrument(rig)
        self.streams = {
            name: Stream(section, instrument, extrapolate)
            for name, section in ((o.name, o.cloud) for o in rig.scene.objects)
            if name in self._sources and section is not None
        }
        self._shared = targets or SharedTargets(rig, loop)
        self._targets = {name: (0.0, np.zeros(3), np.zeros(3)) for name in self.streams}  # t, X, V
        self._objects = list(rig.snapshot.objects)
        self._rendered: dict[str, tuple[_tissue.PointSurface, float]] = {}
        self.frames: dict[str, CloudFrame] = {}  #: newest frame of each object, for drawings
        self.keep: Callable[[str, CloudFrame, float], None] | None = None
        """Called with the object, each of its frames, and the session's time [s], for the record."""

    def step(self, t: float) -> int:
        """Ask the sources at the session's time t [s] and hand over the new surfaces; returns their number."""
        frames = {name: source.latest(t) for name, source in self._sources.items()}
        self.frames.update({name: frame for name, frame in frames.items() if frame is not None})
        built, known = 0, len(self._rendered)
        for name, stream in self.streams.items():
            frame = frames[name]
            if frame is None:
                continue
            if self.keep is not None:
                self.keep(name, frame, t)
            tick = self._tick()
            found = stream.build(frame, t, tick, self._position(tick, name))
            if found is None:
                continue
            tick = self._tick()  # the surface has moved on while the new one was built
            now, X = float(tick["t"]), self._position(tick, name)
            found.core.translate(stream.rebase(X, found.V, now))
            self._targets[name] = (frame.t, X - found.V * (now - frame.t), found.V)
            self._replace(name, found.core)
            self._rendered[name] = (found.core, stream.spacing)
            built += 1
        if built:
            if len(self._rendered) > known:
                self._place_tracked()
            self._loop.set_snapshot(_core.Snapshot(self._objects))
            self._set_targets()
        return built

    @property
    def surfaces(self) -> dict[str, _tissue.PointSurface]:
        """The surface of each object that the loop renders now, in O; an object without a frame yet has none."""
        return {name: core for name, (core, _) in dict(self._rendered).items()}  # a copy: frames come in another thread

    def hold(self) -> None:
        """Stop all surfaces; their force fades as after a lost camera."""
        self._set_targets(lost=True)

    def status(self, t: float) -> dict[str, str]:
        """State of each stream in words, at the session's time t [s]."""
        return {name: _state(stream, t, self._sources[name]) for name, stream in self.streams.items()}

    def silent(self, t: float) -> list[str]:
        """Objects of which no surface was made until the time `t` [s], in words."""
        if t < _EARLY:
            return []
        found = []
        for name, stream in self.streams.items():
            if stream.surface is not None:
                continue
            source = self._sources[name]
            heard = source.heard() if isinstance(source, Hearing) else ""
            words = "; ".join(filter(None, (stream.gate.counts.refused(), heard))) or "no frame came"
            found.append(f"cloud {name}: no surface was made: {words}; no force from it")
        return found

    def clouds(self) -> dict[str, tuple[_tissue.PointSurface, float]]:
        """The newest surface of each object that has one, as handed to the loop, and its spacing [m]; any thread."""
        return dict(self._rendered)

    def close(self) -> None:
        """Close all sources."""
        for source in self._sources.values():
            source.close()

    def _tick(self) -> Ticks:
        return as_tick(self._loop.latest())

    def _position(self, tick: Ticks, name: str) -> Array:
        """p_WO as the loop renders it; before its first tick as the scene places it."""
        X_WO = live.object_pose(tick, self._shared.slot(name))
        rest = next(o.X_WO for o in self._rig.snapshot.objects if o.name == name)
        return np.asarray(rest[:3, 3] if X_WO is None else X_WO[:3, 3])

    def _replace(self, name: str, core: _tissue.PointSurface) -> None:
        i = next(i for i, o in enumerate(self._objects) if o.name == name)
        obj, section = self._rig.scene.objects[i], self._rig.scene.objects[i].cloud
        assert section is not None
        X_WO = np.eye(4)
        X_WO[:3, 3] = self._targets[name][1]
        self._objects[i] = _core.Object(
            name, core, X_WO, materials.material(obj), materials.regions(obj),
            is_virtual=obj.presence != "real", is_real=obj.presence != "virtual", live=surface.cloud_options(section),
        )  # fmt: skip

    def _place_tracked(self) -> None:
        """Move tracked objects in the snapshot to where they are: they go on there after a cloud's first surface."""
        tick, scene = self._tick(), self._rig.scene
        for name, tracker in placing.tracked(scene, placing.graph(scene)).items() if scene.trackers else ():
            X_WO = live.object_pose(tick, self._shared.slot(name))
            i = next(i for i, one in enumerate(scene.objects) if one.name == name)
            placed = self._rig.surfaces[i]
            if X_WO is not None:
                options = surface.live_options(scene.trackers[tracker], placed)
                there = replace(placed, X_WO=X_WO)
                self._objects[i] = surface.core_object(scene.objects[i], there, _core.Motion(), options)

    def _set_targets(self, lost: bool = False) -> None:
        targets = {}
        for name, (t, p, V) in self._targets.items():
            X_WO = np.eye(4)
            X_WO[:3, 3] = p
            targets[name] = Target(t, X_WO, np.r_[V, np.zeros(3)], lost)
        self._shared.set(targets)


def _state(stream: Stream, t: float, source: CloudSource) -> str:
    if stream.surface is None:
        heard = source.heard() if isinstance(source, Hearing) else ""
        return f"no frame yet: {heard}" if heard else "no frame yet"
    age = t - stream.gate.last
    note = f", {len(stream.remembered):,} points remembered" if len(stream.remembered) else ""
    if age > stream.section.patience:
        return f"stale: the newest frame is {age:.2f} s old; the surface stands still and its force fades{note}"
    return f"{len(stream.surface):,} points, {1e3 * age:.0f} ms old{note}"


def _by_object(rig: Rig, sources: Mapping[str, CloudSource]) -> dict[str, CloudSource]:
    """The source of each object that is the cloud of a sensor, in the order of the objects."""
    found, used = {}, set()
    for i, obj in enumerate(rig.scene.objects):
        if obj.cloud is None or obj.cloud.sensor is None:
            continue
        key = obj.name if obj.name in sources else obj.cloud.sensor
        if key not in sources:
            raise SceneError(
                f"object {obj.name!r} has no source: there is no sensor {obj.cloud.sensor!r}",
                where=rig.scene.where("objects", i, "cloud"),
                mend='give one: Session(scene, clouds={"NAME": source})',
            )
        found[obj.name] = sources[key]
        used.add(key)
    unused = [name for name in sources if name not in used]
    if unused:
        mend = f"objects with a sensor: {', '.join(found) or 'none'}"
        raise SceneError(f"no object is the cloud of source {unused[0]!r}", where=rig.scene.file, mend=mend)
    return found
