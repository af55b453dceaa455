"""A scene as a planning problem: the instrument, its world, its named states."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from palpate.arm import NAMES, Arm, models_folder
from palpate.base.arrays import Array, rigid
from palpate.base.errors import ArmError, PlanningError, SceneError
from palpate.planning import clearance as clearances
from palpate.planning import geometry, goals, planners, refusals, shorten
from palpate.planning.checker import Checker
from palpate.planning.curves import Curve
from palpate.planning.result import Plan
from palpate.planning.robot import Attached, Robot
from palpate.planning.timing import Limits, Trajectory
from palpate.planning.world import World, instrument, obstacle
from palpate.world.surfaces import LiveCloud

if TYPE_CHECKING:
    from palpate.scene import Scene
    from palpate.scene.rig import Rig

_SHARE = 0.8  # of the timeout that the search for a path may use; the rest shortens it


@dataclass(frozen=True)
class Problem:
    """One instrument in one world."""

    robot: Robot
    world: World
    states: dict[str, Array]  # named joint positions, with home and current
    limits: Limits
    clearance: float  # default clearance [m]
    scene: str = ""  # file of the scene; empty if it has none

    @classmethod
    def of(cls, scene: Scene, arm: str | None = None, rig: Rig | None = None) -> Problem:
        """The problem of a scene.

        Args:
            scene: the scene, with its section `planning`.
            arm: name of the arm; the scene's when left out. In a scene with several pairs, the name of a pair.
            rig: the scene as it was built, if it was.

        Raises:
            SceneError: no arm has this name, or the scene is invalid. MissingExtraError: a package is missing.
        """
        from palpate.scene.rig import build

        geometry.require()
        if scene.pairs:
            from palpate.scene.together import build_pairs

            if arm not in scene.pairs:
                what = "the scene has several pairs" if arm is None else f"there is no pair {arm!r}"
                mend = f"name one of {', '.join(scene.pairs)}: palpate plan --arm NAME"
                raise SceneError(what, where=scene.where("pairs"), mend=mend)
            return cls.of_pair(build_pairs(scene), arm)
        section = scene.planning
        if arm is not None and arm not in (section.arm, "follower"):
            others = ", ".join(one.name for one in section.instruments)
            why = f"{others} only stand in the scene" if others else ""
            raise SceneError(f"no arm named {arm!r} can be planned", where=scene.where("planning"), why=why,
                             mend=f"the scene's arm is {section.arm}")  # fmt: skip
        rig = rig or build(scene)
        follower, X_WB, q = rig.arms.follower, rig.arms.X_WB, rig.arms.q_follower0
        jaw = scene.arms.follower.jaw.start if section.jaw is None else section.jaw
        robot = Robot(section.arm, follower, X_WB).with_jaws(*(jaw if isinstance(jaw, tuple) else (jaw, jaw)))
        held = [_attached(scene, rig, robot, q, i) for i in range(len(section.attached))]
        robot = replace(robot, attached=tuple(held))
        names = {one.name for one in held}
        obstacles = [
            obstacle(obj.name, placed.body, placed.X_WO)
            for obj, placed in zip(scene.objects, rig.surfaces, strict=True)
            if obj.name not in names and not isinstance(placed.body, LiveCloud)  # which is empty before its first frame
        ]  # fmt: skip
        for i in range(len(section.instruments)):
            obstacles += _instrument(scene, i)
        allowed = frozenset(frozenset(pair) for pair in section.allowed)
        states = {"home": follower.home, "current": q}
        for name, joints in section.states.items():
            states[name] = goals.read(joints, follower, {}, f"state {name!r} of the scene")
        limits = Limits.of(follower, section.speed)
        file = str(Path(scene.file).resolve()) if scene.file else ""
        return cls(robot, World(tuple(obstacles), allowed), states, limits, section.clearance, file)

    @classmethod
    def of_pair(cls, rigs: Mapping[str, Rig], name: str) -> Problem:
        """The problem of one of several pairs; the instruments of the others are obstacles where they start.

        Args:
            rigs: the pairs as they were built.
            name: name of the pair, which the arm of the plan has as well.
        """
        alone = cls.of(rigs[name].scene, rig=rigs[name])
        others = [neighbour(other, rig) for other, rig in rigs.items() if other != name]
        stand = [body for one in others for body in instrument(one, rigs[one.name].arms.q_follower0)]
        return replace(alone, robot=replace(alone.robot, name=name), world=alone.world.with_added(stand))

    def with_world(self, world: World) -> Problem:
        """The same problem in a changed world."""
        return replace(self, world=world)

    def plan(
        self,
        start: Any = "current",
        goal: Any = "home",
        clearance: float | None = None,
        seed: int = 0,
        timeout: float = 5.0,
        planner: str = planners.PLANNERS[0],
        checker: Checker | None = None,
    ) -> Plan:
        """A motion from `start` to `goal` (see `goals.read`) that keeps the clearance [m] from everything.

        The same seed gives the same plan, unless the timeout [s] ends the search.

        Raises:
            PlanningError: start or goal cannot be understood, or is in collision; the message names the pair and the
                depth, and for a start the nearest free joint positions.
        """
        begin = time.monotonic()
        clearance = refusals.require_number(self.clearance if clearance is None else clearance, "clearance", 0.0)
        timeout = refusals.require_number(timeout, "timeout", 1e-3)
        deadline = begin + timeout
        arm = self.robot.arm
        checker = checker or Checker(self.robot, self.world)
        scale = planners.levers(arm)
        base = self.empty_plan(clearance, seed, planner)
        q0 = self._start(start, checker, clearance, seed)
        targets = self._targets(goal, q0, checker, clearance, seed)
        if isinstance(targets, goals.Unreachable):
            return self.failed(base, targets.reason, begin=begin)
        search_end = begin + _SHARE * timeout
        found = planners.search(checker, q0, targets, clearance, seed, search_end, planner)
        if found.waypoints is None:
            names = " and ".join(found.blocker)
            reason = f"no path found within {timeout:g} s; {names} block most motions"
            return self.failed(base, reason, found.blocker, begin)
        waypoints = found.waypoints
        if found.planner != planners.STRAIGHT:
            waypoints = shorten.shortened(checker, waypoints, scale, clearance, seed, deadline)
        curves = shorten.rounded(checker, waypoints, scale, clearance, deadline)
        return self.finished(replace(base, planner=found.planner), checker, curves, begin)

    def through(
        self, places: Sequence[Any], clearance: float | None = None, seed: int = 0, timeout: float = 5.0
    ) -> Plan:
        """A motion from the first of `places` through all others, with a stop at each; see `plan`.

        Where one leg has no motion, that leg's plan without success is returned.

        Raises:
            PlanningError: fewer than two places, or as for `plan`.
        """
        if len(places) < 2:
            raise PlanningError(
                f"a sequence needs two places or more. Got: {len(places)}", mend="add a start or a goal"
            )
        begin, checker = time.monotonic(), Checker(self.robot, self.world)
        here: Any = places[0]
        curves: list[Curve] = []
        for place in places[1:]:
            leg = self.plan(here, place, clearance, seed, timeout, checker=checker)
            if not leg.success:
                return leg
            curves += leg.curves
            here = leg.curves[-1].controls[-1]
        return self.finished(replace(leg, success=False), checker, curves, begin)

    def retreat(self, start: Any = "current", depth: float = 0.03) -> Array:
        """Joint positions (n,) after a retreat along the trocar by `depth` [m], or until the joint's limit.

        Raises:
            PlanningError: the start cannot be understood, or the arm has no remote centre.
        """
        q = goals.read(start, self.robot.arm, self.states, "start")
        slides = planners.retreat_joint(self.robot)
        if slides is None or q.shape != (self.robot.arm.n,):
            raise PlanningError(f"{self.robot.arm.name} has no trocar to retreat along, or the start is a pose",
                                mend="give joint positions of an arm with a remote centre")  # fmt: skip
        q = q.copy()
        q[slides] = np.clip(q[slides] - depth, self.robot.arm.q_min[slides], self.robot.arm.q_max[slides])
        return q

    def with_trocar_motions(
        self, places: Sequence[Any], retreat: float = 0.0, approach: float = 0.0, seed: int = 0
    ) -> list[Array]:
        """Places of a sequence that retreats along the trocar first and reaches its goal by an insertion.

        Args:
            places: start, way points and goal.
            retreat: distance of the retreat from the start [m]; 0: none.
            approach: distance of the final insertion [m]; 0: none.
            seed: of the inverse kinematics of poses.

        Raises:
            PlanningError: a place cannot be understood or reached, or the arm has no trocar.
        """
        rows: list[Array] = []
        for k, place in enumerate(places):
            q = goals.read(place, self.robot.arm, self.states, "start" if k == 0 else "goal")
            if q.shape == (4, 4):
                near = rows[-1] if rows else self.states["current"]
                found = goals.solutions(self.robot.arm, rigid.inverse(self.robot.X_WB) @ q, near, seed)
                if isinstance(found, goals.Unreachable):
                    raise PlanningError(f"place {k + 1} is {found.reason}", mend="choose another place")
                q = found[0]
            rows.append(q)
        first = [self.retreat(rows[0], retreat)] if retreat > 0.0 else []
        last = [self.retreat(rows[-1], approach)] if approach > 0.0 else []
        return [rows[0], *first, *rows[1:-1], *last, rows[-1]]

    def empty_plan(self, clearance: float, seed: int, planner: str) -> Plan:
        """A plan without a motion, with the values of this problem."""
        robot = self.robot
        return Plan(False, "", robot.name, 0.0, clearance, seed, planner, self.world.version,
                    tuple(robot.arm.joint_names), scale=planners.levers(robot.arm), limits=self.limits,
                    geometry=robot.geometry, notes=(*robot.notes, *self.world.notes), X_WB=robot.X_WB,
                    scene=self.scene, jaw=robot.span)  # fmt: skip

    def failed(self, base: Plan, reason: str, blocker: tuple[str, str] = ("", ""), begin: float = 0.0) -> Plan:
        """A plan without success: its reason, and the pair that blocks. begin: time.monotonic() of the start [s]."""
        return replace(base, reason=reason, blocker=blocker, time_s=time.monotonic() - begin)

    def finished(self, base: Plan, checker: Checker, curves: list[Curve], begin: float) -> Plan:
        """A plan along proved curves, with its times and its smallest clearance."""
        trajectory = Trajectory(curves, base.scale, self.limits)
        found = clearances.along(checker, trajectory)
        time_s = time.monotonic() - begin
        return replace(base, success=True, curves=tuple(curves), clearance=found, time_s=time_s)

    def _start(self, start: Any, checker: Checker, clearance: float, seed: int) -> Array:
        q = goals.read(start, self.robot.arm, self.states, "start")
        if q.shape == (4, 4):
            found = goals.solutions(self.robot.arm, rigid.inverse(self.robot.X_WB) @ q, self.states["current"], seed)
            if isinstance(found, goals.Unreachable):
                raise PlanningError(f"the start is {found.reason}", mend="choose another start")
            q = found[0]
        refusal = checker.refusal(q, clearance)
        if refusal is not None:
            raise PlanningError(
                f"the start is {refusals.words(refusal, clearance)}",
                mend=refusals.free_words(refusals.nearest_free(checker, q, clearance)) + refusals.less(refusal),
            )
        return q

    def _targets(
        self, goal: Any, q0: Array, checker: Checker, clearance: float, seed: int
    ) -> list[Array] | goals.Unreachable:
        q = goals.read(goal, self.robot.arm, self.states, "goal")
        candidates = [q]
        if q.shape == (4, 4):
            found = goals.solutions(self.robot.arm, rigid.inverse(self.robot.X_WB) @ q, q0, seed)
            if isinstance(found, goals.Unreachable):
                return found
            candidates = found
        refused = [checker.refusal(one, clearance) for one in candidates]
        free = [one for one, refusal in zip(candidates, refused, strict=True) if refusal is None]
        if not free:
            assert refused[0] is not None
            worst = max((r for r in refused if r is not None), key=lambda r: r.distance)
            mend = f"move the goal away from {worst.pair[1]}" + refusals.less(worst)
            raise PlanningError(f"the goal is {refusals.words(worst, clearance)}", mend=mend)
        return free


def _attached(scene: Scene, rig: Rig, robot: Robot, q: Array, index: int) -> Attached:
    section = scene.planning.attached[index]
    where = scene.where("planning", "attached", index)
    names = [obj.name for obj in scene.objects]
    if section.object not in names:
        raise SceneError(f"there is no object {section.object!r}", where=where, mend=f"name one of {', '.join(names)}")
    links = robot.kinematics.mount
    if section.link not in links:
        raise SceneError(
            f"{robot.arm.name} has no link {section.link!r}", where=where, mend=f"one of {', '.join(links)}"
        )
    placed = rig.surfaces[names.index(section.object)]
    X_WLink = robot.X_WB @ robot.arm.link_poses(q, robot.jaw)[section.link]
    X = rigid.inverse(X_WLink) @ placed.X_WO
    vertices = np.asarray(placed.body.vertices) @ X[:3, :3].T + X[:3, 3]
    return Attached(section.object, section.link, vertices, np.asarray(placed.body.triangles))


def neighbour(name: str, rig: Rig) -> Robot:
    """The instrument of a pair as others meet it: with its jaws at any angle that its hand can give them."""
    jaw = rig.scene.arms.follower.jaw
    angles = (jaw.start, jaw.closed, jaw.open)
    return Robot(name, rig.arms.follower, rig.arms.X_WB).with_jaws(min(angles), max(angles))


def _instrument(scene: Scene, index: int) -> list[Any]:
    section = scene.planning.instruments[index]
    where = scene.where("planning", "instruments", index)
    shipped = models_folder() / f"{section.model}.yaml"
    try:
        path: Path = shipped if section.model in NAMES or shipped.is_file() else scene.path_to(section.model, where)
        arm = Arm.load(path)
    except ArmError as error:
        raise SceneError(error.what, where=where, why=error.why or error.where, mend=error.mend) from None
    q = arm.home if section.joints is None else goals.read(section.joints, arm, {}, f"instrument {section.name}")
    return instrument(Robot(section.name, arm, section.base.matrix(), section.jaw), q)
