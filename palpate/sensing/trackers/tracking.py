"""Moves the live frames of a rig by its trackers, and tells the loop which poses the objects in them shall reach."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from palpate import _core
from palpate.base.arrays import Array, rigid
from palpate.base.errors import SceneError
from palpate.record import live
from palpate.record.ticks import as_tick
from palpate.scene import materials, placing
from palpate.scene.live_targets import FrameState, SharedTargets, Target
from palpate.scene.rig import Rig
from palpate.scene.trackers import TrackerSection
from palpate.sensing.trackers.clock import MeasurementClock
from palpate.sensing.trackers.gate import Gate, Limits
from palpate.sensing.trackers.prediction import Predictor
from palpate.sensing.trackers.simulated import Fault, SimulatedTracker
from palpate.sensing.trackers.tracker import Hearing, Sighting, Tracker

_EARLY = 0.5  # silence that is told at the end of a run [s]
_STEP = 1e-3  # interval from which the velocity of a predicted pose is taken [s]


class _Loop(Protocol):
    def set_live(self, targets: _core.LiveTargets, /) -> None:
        """Set the poses that live objects shall reach."""
        ...

    def latest(self) -> Any:
        """The newest row."""
        ...


class Tracking:
    """The live frames of a rig and the objects that follow them.

    At every step the gate of each tracked frame judges the new poses; good ones enter the graph and a `Predictor`. The
    loop moves every object in a tracked frame towards its predicted pose at the present time, of which it is given the
    velocity too, with limited speed and acceleration (`_core.Approach`).
    When the tool of a frame is lost, or steps are missing for longer than the tracker's `max_age`, its objects stop
    and their stiffness and damping fade to zero.

    Args:
        rig: the rig, whose `frames` and live frames of fixtures are updated.
        loop: the loop that renders the objects.
        trackers: sources by the name of the scene's section; made from the scene when None.
        targets: targets of all live objects of the loop, which sensors share; own ones when None.
    """

    def __init__(
        self,
        rig: Rig,
        loop: _Loop,
        trackers: Mapping[str, Tracker] | None = None,
        targets: SharedTargets | None = None,
    ) -> None:
        import scipy.spatial.transform  # noqa: F401 - here, because an import would delay the first steps of a session

        self._rig, self._loop, self._targets = rig, loop, targets or SharedTargets(rig, loop)
        self._trackers = dict(trackers) if trackers is not None else make(rig)
        self._epoch = time.time()
        sections, graph = rig.scene.trackers, rig.frames
        self._edges = {s.child: s for s in placing.tracked_frames(rig.scene)}
        self.gates = {
            child: Gate(s.tool or child, graph.edge(child).X, _limits(sections[s.tracker or ""]))
            for child, s in self._edges.items()
        }
        self._clocks = {
            child: MeasurementClock(1e-3 * section.delay_ms, section.max_age)
            for child, section in ((child, sections[s.tracker or ""]) for child, s in self._edges.items())
        }
        self._predictors: dict[str, Predictor] = {}  # by frame, from its first good pose on
        follow = placing.tracked(rig.scene, placing.graph(rig.scene))
        self._followers = [
            _Follower(obj.name, self._above(obj.frame)) for obj in rig.scene.objects if obj.name in follow
        ]

    def step(self, t: float) -> None:
        """Read the trackers at the session's time `t` [s], and set the objects' targets."""
        self._read(t)
        self._show_objects()
        self._set_targets(t, stop=False)

    def hold(self, t: float) -> None:
        """Stop all objects, at the session's time `t` [s]."""
        self._set_targets(t, stop=True)

    @property
    def needs_realtime(self) -> str:
        """Name of a tracker on a network, whose poses arrive in real time; empty if all are simulated."""
        sections = self._rig.scene.trackers
        return next((name for name in self._trackers if name in sections and not sections[name].simulated), "")

    def status(self, t: float) -> dict[str, str]:
        """State of each tracked frame in words, at the session's time `t` [s]."""
        return {child: self._words(child, gate, t) for child, gate in self.gates.items()}

    def accept_jumps(self) -> list[str]:
        """Trust the new places of tools that are refused for a jump, e.g. of a marker that was moved on purpose.

        The objects in their frames move there with limited speed. Returns the names of the frames.
        """
        moved = [child for child, gate in self.gates.items() if gate.jumped]
        for child in moved:
            self.gates[child].accept_jump()
        return moved

    def silent(self, t: float) -> list[str]:
        """Frames whose tool was never seen until the time `t` [s], or was not seen at last, in words."""
        if t < _EARLY:
            return []
        found = []
        for child, gate in self.gates.items():
            section = self._rig.scene.trackers.get(self._edges[child].tracker or "")
            last = gate.is_lost(t - _EARLY) and section is not None and section.simulated is None
            if gate.taken and not last:
                continue
            held = [one.name for one in self._followers if child in one.edges]
            force = f"; no force from {', '.join(held)}" if held else ""
            name = "" if gate.tool == child else f" (tool {gate.tool} of {self._edges[child].tracker})"
            found.append(f"tracked frame {child}{name}: {self._words(child, gate, t)}{force}")
        return found

    def close(self) -> None:
        """Close the connections to all trackers."""
        for tracker in self._trackers.values():
            tracker.close()

    def _words(self, child: str, gate: Gate, t: float) -> str:
        """State of a tracked frame, with what its tracker knows where the tool is not seen."""
        words = gate.status(t)
        if gate.jumped:
            words += "; if it was moved on purpose, press coag while the clutch is down"
        tracker = self._trackers.get(self._edges[child].tracker or "")
        more = tracker.heard(gate.tool) if isinstance(tracker, Hearing) else ""
        if not gate.is_lost(t) or not more:
            return words
        return f"{words}: {more}" if words == "not seen yet" else f"{words}; {more}"

    def _above(self, frame: str) -> list[str]:
        """Tracked frames between a frame and the world."""
        found, graph = [], self._rig.frames
        while frame != graph.root:
            found += [frame] if frame in self._edges else []
            frame = graph.edge(frame).parent
        return found

    def _read(self, t: float) -> None:
        seen, wall = {name: tracker.poll(t) for name, tracker in self._trackers.items()}, time.time()
        taken = False
        for child, gate in self.gates.items():
            section = self._edges[child]
            good = [
                s for s in seen.get(section.tracker or "", ()) if s.tool == gate.tool and self._take(child, s, t, wall)
            ]
            if good:
                self._rig.frames.update(child, gate.X, self._epoch + t)
                taken = True
        moving = any(one.moving for one in self._predictors.values())
        for name in self._rig.frames.frames if taken or moving else ():
            if self._rig.frames.is_live(name) and name not in {one.name for one in self._followers}:
                self._set_frame(name, self._pose(name, t))

    def _take(self, child: str, seen: Sighting, t: float, wall: float) -> bool:
        """Take in a sighting that was read at the session's time `t` [s]; True if it is good."""
        gate = self.gates[child]
        if not gate.take(seen, t):
            return False
        measured = self._clocks[child].time(seen.t, t, wall)
        if gate.began:
            self._predictors[child] = Predictor(gate.X, measured)
        else:
            self._predictors[child].take(gate.X, measured)
        return True

    def _pose(self, name: str, t: float) -> Array:
        """Pose (4, 4) in the world of a frame at the time `t` [s], with that of tracked frames as predicted."""
        X = np.eye(4)
        for edge in self._rig.frames.path(name):
            one = self._predictors.get(edge.child)
            X = X @ (edge.X if one is None else one.at(t, self._clocks[edge.child].delay))
        return X

    def _target(self, follower: _Follower, t: float) -> tuple[Array, Array]:
        """Predicted pose (4, 4) of an object at the time `t` [s], and its velocity (6,) [m/s, rad/s]."""
        X = self._pose(follower.name, t)
        if not any(one.moving for child, one in self._predictors.items() if child in follower.edges):
            return X, np.zeros(6)
        return X, rigid.displacement(self._pose(follower.name, t - _STEP), X) / _STEP

    def _set_targets(self, t: float, stop: bool) -> None:
        targets, frames = {}, []
        for one in self._followers:
            lost = stop or any(self.gates[child].is_lost(t) for child in one.edges)
            targets[one.name] = Target(t, *self._target(one, t), lost)
        for child, gate in self.gates.items():
            frames.append(FrameState(self._rig.frames.pose(child).X, gate.seen_at, gate.is_lost(t)))
        self._targets.set(targets, frames)

    def _show_objects(self) -> None:
        """Move the frames of the objects, to which fixtures may be attached, to the poses that the loop renders."""
        tick = as_tick(self._loop.latest())
        for one in self._followers:
            X_WO = live.object_pose(tick, self._targets.slot(one.name))
            if X_WO is not None:
                self._set_frame(one.name, X_WO)

    def _set_frame(self, name: str, X_WF: Array) -> None:
        frame = self._rig.context.frames.get(name)
        if isinstance(frame, _core.LiveFrame):
            frame.set(X_WF)


@dataclass(frozen=True)
class _Follower:
    """An object in tracked frames."""

    name: str
    edges: list[str]
    """tracked frames between the object and the world"""


def _limits(section: TrackerSection) -> Limits:
    return Limits(section.max_age, 1e-3 * section.max_error_mm, section.max_speed, math.radians(section.max_turn_deg))


def make(rig: Rig) -> dict[str, Tracker]:
    """The trackers of a scene, by name.

    Raises:
        MissingExtraError: a part that a tracker needs is not installed.
    """
    return {name: _made(rig, name, section) for name, section in rig.scene.trackers.items()}


def _tools(rig: Rig, name: str) -> list[str]:
    return [s.tool or s.child for s in placing.tracked_frames(rig.scene) if s.tracker == name]


def _made(rig: Rig, name: str, section: TrackerSection) -> Tracker:
    if section.openigtlink is not None:
        from palpate.sensing.trackers.openigtlink import OpenIGTLinkTracker

        return OpenIGTLinkTracker(section.openigtlink, _tools(rig, name))
    if section.topic is not None:
        from palpate.sensing.trackers.ros_topic import RosTopicTracker, topics

        return RosTopicTracker(topics(section.topic, _tools(rig, name)))
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
    noise, delay = 1e-3 * section.noise_mm, 1e-3 * section.delay_ms
    return SimulatedTracker(tools, section.rate, noise, section.dropout, faults, rig.scene.seed, delay)


def _moving(X: Array, motion: _core.Motion) -> Callable[[float], Array]:
    frame = _core.MotionFrame(X, motion)
    return lambda t: np.asarray(frame.at(t)[0])
