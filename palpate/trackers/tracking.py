"""Moves the live frames of a rig by its trackers, and the objects in them without a step in the force."""

from __future__ import annotations

import math
import time
import warnings
from collections.abc import Callable, Mapping
from typing import Protocol

import numpy as np

from palpate import _core
from palpate.arrays import Array
from palpate.errors import PalpateWarning, SceneError
from palpate.scene import materials, placing, surface
from palpate.scene.model import ObjectSection
from palpate.scene.rig import Rig
from palpate.scene.trackers import TrackerSection
from palpate.trackers.approach import Approach, RateLimits
from palpate.trackers.gate import Gate, Limits
from palpate.trackers.simulated import Fault, SimulatedTracker
from palpate.trackers.tracker import Tracker

PERIOD = 0.01
"""Period at which trackers are read and objects change their velocity [s]."""


class _Loop(Protocol):
    def set_snapshot(self, snapshot: _core.Snapshot, /) -> None:
        """Replace all objects before the next cycle."""
        ...


class Tracking:
    """The live frames of a rig and the objects that follow them.

    At every step the gate of each tracked frame judges the new poses; good ones enter the graph. Every object in a
    tracked frame moves towards its pose in the graph with limited speed and acceleration, and contact knows its
    velocity. When the tool of a frame is lost, its objects stop at the last good pose and their stiffness and damping
    fade to zero.

    Args:
        rig: the rig, whose `frames` and live frames of fixtures are updated.
        loop: the loop that renders the objects.
        trackers: sources by the name of the scene's section; made from the scene when None.
    """

    def __init__(self, rig: Rig, loop: _Loop, trackers: Mapping[str, Tracker] | None = None) -> None:
        import scipy.spatial.transform  # noqa: F401 - here, because an import would delay the first steps of a session

        self._rig, self._loop = rig, loop
        self._trackers = dict(trackers) if trackers is not None else make(rig)
        self._epoch = time.time()
        self._t, self._interval = math.inf, PERIOD  # time of the last step, estimated interval [s]
        sections, graph = rig.scene.trackers, rig.frames
        self._edges = {s.child: s for s in rig.scene.frames if s.tracker is not None}
        self.gates = {
            child: Gate(s.tool or child, graph.edge(child).X, _limits(sections[s.tracker or ""]))
            for child, s in self._edges.items()
        }
        follow = placing.tracked(rig.scene, placing.graph(rig.scene))
        self._followers = [
            _Follower(rig, i, sections[follow[obj.name]], self._above(obj.frame))
            for i, obj in enumerate(rig.scene.objects)
            if obj.name in follow
        ]
        for one in self._followers:
            one.warn_of_friction(rig)

    def step(self, t: float, interval: float | None = None) -> None:
        """Read the trackers at the session's time `t` [s], and choose the objects' motion for the next interval [s].

        The interval is estimated from the latest ones when left out: on a busy machine objects then move more slowly.
        """
        self._interval = max(t - self._t, 0.9 * self._interval, PERIOD)
        interval, self._t = interval or self._interval, t
        self._read(t)
        graph, context = self._rig.frames, self._rig.context.frames
        changed = False
        for one in self._followers:
            lost = any(self.gates[child].is_lost(t) for child in one.edges)
            changed |= one.step(graph.pose(one.name).X, lost, t, interval)
            _set(context[one.name], one.approach.X, one.approach.V_WO)
        if changed:
            self._publish()

    def hold(self, t: float) -> None:
        """Stop all objects at their pose at the time `t` [s]."""
        moving = [one for one in self._followers if one.approach.moves]
        for one in moving:
            one.approach.advance(t)
            one.approach.hold()
            _set(self._rig.context.frames[one.name], one.approach.X, one.approach.V_WO)
        if moving:
            self._publish()

    @property
    def needs_realtime(self) -> str:
        """Name of a tracker on a network, whose poses arrive in real time; empty if all are simulated."""
        sections = self._rig.scene.trackers
        return next((name for name in self._trackers if name in sections and not sections[name].simulated), "")

    def status(self, t: float) -> dict[str, str]:
        """State of each tracked frame in words, at the session's time `t` [s]."""
        return {child: gate.status(t) for child, gate in self.gates.items()}

    def close(self) -> None:
        """Close the connections to all trackers."""
        for tracker in self._trackers.values():
            tracker.close()

    def _above(self, frame: str) -> list[str]:
        """Tracked frames between a frame and the world."""
        found, graph = [], self._rig.frames
        while frame != graph.root:
            found += [frame] if frame in self._edges else []
            frame = graph.edge(frame).parent
        return found

    def _read(self, t: float) -> None:
        seen = {name: tracker.poll(t) for name, tracker in self._trackers.items()}
        taken = False
        for child, gate in self.gates.items():
            section = self._edges[child]
            good = [s for s in seen.get(section.tracker or "", ()) if s.tool == gate.tool and gate.take(s, t)]
            if good:
                self._rig.frames.update(child, gate.X, self._epoch + t)
                taken = True
        for name in self._rig.frames.frames if taken else ():
            frame = self._rig.context.frames.get(name)
            if self._rig.frames.is_live(name) and name not in {one.name for one in self._followers}:
                _set(frame, self._rig.frames.pose(name).X)

    def _publish(self) -> None:
        objects = list(self._rig.snapshot.objects)
        for one in self._followers:
            objects[one.index] = one.core()
        self._loop.set_snapshot(_core.Snapshot(objects))


class _Follower:
    """One object that follows a tracked frame."""

    def __init__(self, rig: Rig, index: int, limits: TrackerSection, edges: list[str]) -> None:
        self.index, self.edges = index, edges
        self._section, self._placed = rig.scene.objects[index], rig.surfaces[index]
        self.name = self._section.name
        vertices = self._placed.body.vertices
        centre_O = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
        rates = RateLimits(limits.speed, math.radians(limits.turn_deg), limits.acceleration)
        self.approach = Approach(self._placed.X_WO, centre_O, 0.0, rates)
        self._fade, self._share = limits.fade, 1.0  # time of a full fade [s], present share of the force [-]

    def warn_of_friction(self, rig: Rig) -> None:
        """Warn if the object has friction: a replaced scene forgets the point at which the tool sticks."""
        if self._section.friction > 0.0:
            what = f"object {self.name!r} follows a tracker, so its friction is felt only while it rests"
            where = rig.scene.where("objects", self.index, "friction")
            warnings.warn(PalpateWarning(what, where=where, mend="give friction: 0"), stacklevel=4)

    def step(self, goal: Array, lost: bool, t: float, interval: float) -> bool:
        """Move to the time t, and choose velocity and force for the next interval; True if the object has changed."""
        before = (self.approach.moves, self._share)
        self.approach.advance(t)
        self.approach.aim(self.approach.X if lost else goal, interval)
        if self._fade > 0.0:
            step = interval / self._fade
            self._share = max(self._share - step, 0.0) if lost else min(self._share + step, 1.0)
        return before[0] or self.approach.moves or before[1] != self._share

    def core(self) -> _core.Object:
        """The object for the core, with its present velocity and share of the force."""
        rest, motion = self.approach.motion()
        return surface.core_object(faded(self._section, self._share), self._placed.body, rest, motion)


def faded(obj: ObjectSection, share: float) -> ObjectSection:
    """The object with a share (0 to 1) of its stiffness and damping, its regions included."""
    if share == 1.0:
        return obj
    regions = tuple(region.model_copy(update=_scaled(region, share)) for region in obj.regions)
    return obj.model_copy(update={**_scaled(obj, share), "regions": regions})


def _scaled(section: object, share: float) -> dict[str, tuple[float, ...]]:
    given = {key: getattr(section, key) for key in ("stiffness", "damping")}
    return {key: tuple(share * x for x in value) for key, value in given.items() if value is not None}


def _limits(section: TrackerSection) -> Limits:
    return Limits(section.max_age, 1e-3 * section.max_error_mm, section.max_speed, math.radians(section.max_turn_deg))


def _set(frame: _core.Frame | None, X_WF: Array, V_WF: Array | None = None) -> None:
    if isinstance(frame, _core.LiveFrame):
        if V_WF is None:
            frame.set(X_WF)
        else:
            frame.set(X_WF, V_WF)


def make(rig: Rig) -> dict[str, Tracker]:
    """The trackers of a scene, by name.

    Raises:
        MissingExtraError: a part that a tracker needs is not installed.
    """
    return {name: _made(rig, name, section) for name, section in rig.scene.trackers.items()}


def _made(rig: Rig, name: str, section: TrackerSection) -> Tracker:
    if section.openigtlink is not None:
        from palpate.trackers.openigtlink import OpenIGTLinkTracker

        return OpenIGTLinkTracker(section.openigtlink)
    return simulated(rig, name)


def simulated(rig: Rig, name: str) -> SimulatedTracker:
    """The simulated tracker `name` of a scene; its tools start at the poses of their frames.

    Raises:
        SceneError: a motion names a tool that no frame has.
    """
    section = rig.scene.trackers[name].simulated
    if section is None:
        raise SceneError(
            f"tracker {name!r} is not simulated", where=rig.scene.where("trackers", name), mend="give simulated: {}"
        )
    own = {s.tool or s.child: rig.frames.edge(s.child).X for s in rig.scene.frames if s.tracker == name}
    for tool in (*section.motion, *(fault.tool for fault in section.faults if fault.tool)):
        if tool not in own:
            raise SceneError(
                f"tracker {name!r} has no tool {tool!r}",
                where=rig.scene.where("trackers", name),
                mend=f"tools of its frames: {', '.join(own) or 'none'}",
            )
    tools = {tool: _moving(X, materials.summed(section.motion.get(tool, ()), X[:3, 3])) for tool, X in own.items()}
    faults = [Fault(f.kind, f.start, f.end, f.tool) for f in section.faults]
    return SimulatedTracker(tools, section.rate, 1e-3 * section.noise_mm, section.dropout, faults, rig.scene.seed)


def _moving(X: Array, motion: _core.Motion) -> Callable[[float], Array]:
    frame = _core.MotionFrame(X, motion)
    return lambda t: np.asarray(frame.at(t)[0])
