"""Builds all pairs of a scene: they share the objects, and their arms must not stand in each other."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from typing import Protocol

import numpy as np

from palpate import _core
from palpate.base.errors import SceneError
from palpate.scene import soft
from palpate.scene.rig import Rig, build
from palpate.scene.scene import Scene
from palpate.scene.surface import Bodies
from palpate.scene.tool import ToolSphereSection, tool_sphere

Rigs = dict[str, Rig]
"""The rigs of a scene's pairs, by name."""

_SAME = 0.005  # distance below which two bases of followers are the same place [m]
_LEADERS = 0.05  # smallest distance between the bases of two leaders [m]


class Joined(Protocol):
    """A loop whose tool meets the instruments of other loops, and rigid bodies."""

    def join(
        self, board: _core.Board, index: int, capsules: list[_core.ToolCapsule], stiffness: float, damping: float, /
    ) -> None:
        """Put the instrument among others, as the one of this number; stiffness [N/m] and damping [N s/m]."""
        ...

    def join_bodies(self, bodies: _core.Bodies, tool: int, /) -> None:
        """Put the tool among rigid bodies, as the tool of this number."""
        ...


def build_pairs(
    scene: Scene,
    bodies: Bodies | None = None,
    until: float | None = None,
    made_by: Mapping[str, Callable[[Scene, Bodies], Rig]] | None = None,
) -> Rigs:
    """Set up every pair of a scene; surfaces, snapshot of the objects and soft bodies are shared.

    Args:
        scene: a scene with the section `pairs`.
        bodies, until: as for `rig.build`.
        made_by: what builds the rig of a pair from its scene, for pairs that are felt on a device.

    Raises:
        SceneError, MeshError, SurfaceError: a pair is invalid, or two pairs have arms in the same place.
    """
    shared: Bodies = {} if bodies is None else bodies
    rigs: Rigs = {}
    for name, one in scene.each_pair().items():
        make = (made_by or {}).get(name)
        rig = build(one, shared, until) if make is None else make(one, shared)
        first = next(iter(rigs.values()), replace(rig, snapshot=soft.shared(rig.snapshot)))
        rigs[name] = replace(rig, snapshot=first.snapshot, surfaces=first.surfaces)
    check_apart(scene, rigs)
    return _with_one_camera(scene, rigs)


def _with_one_camera(scene: Scene, rigs: Rigs) -> Rigs:
    """The rigs with one endoscope arm; placed automatically, its camera sees the middle between the paths' starts."""
    ecm = next(iter(rigs.values())).ecm
    if ecm is None or scene.ecm is None:
        return rigs
    X_WB = ecm.X_WB.copy()
    if scene.ecm.base is None:  # the cameras of all pairs look in one direction, each at its own path
        X_WB[:3, 3] = np.mean([rig.ecm.X_WB[:3, 3] for rig in rigs.values() if rig.ecm is not None], axis=0)
    return {name: replace(rig, ecm=replace(ecm, X_WB=X_WB)) for name, rig in rigs.items()}


def check_apart(scene: Scene, rigs: Mapping[str, Rig]) -> None:
    """Refuse pairs whose arms stand in each other at the start.

    Raises:
        SceneError: two followers share their base, two leaders stand in each other, or two instruments overlap.
    """
    for (one, a), (other, b) in combinations(rigs.items(), 2):
        for side, X_a, X_b, least in (
            ("follower", a.arms.X_WB, b.arms.X_WB, _SAME),
            ("leader", a.arms.X_WL, b.arms.X_WL, _LEADERS),
        ):
            apart = float(np.linalg.norm(X_a[:3, 3] - X_b[:3, 3]))
            if apart < least and not (side == "leader" and (_stands_anywhere(a) or _stands_anywhere(b))):
                _refuse(scene, one, other, side, f"their bases are {1e3 * apart:.1f} mm apart")
        gap = gap_at_start(a, b)
        if scene.instruments.stiffness > 0.0 and gap < 0.0:
            _refuse(scene, one, other, "follower", f"their instruments overlap by {-1e3 * gap:.1f} mm at the start")


def _stands_anywhere(rig: Rig) -> bool:
    """True for a leader that is a device whose place nobody states."""
    leader = rig.scene.arms.leader
    return leader.driver is not None and leader.base is None and leader.frame == "world"


def _refuse(scene: Scene, one: str, other: str, side: str, why: str) -> None:
    what = f"the {side}s of the pairs {one} and {other} are in each other's place"
    raise SceneError(
        what,
        where=scene.where("pairs", other, "arms", side, "base"),
        why=why,
        mend=f"move one of them: pairs.{other}.arms.{side}.base, or the start of its operator's path",
    )


def join_instruments(
    loops: Sequence[Joined],
    tools: Sequence[list[_core.ToolCapsule]],
    stiffness: float,
    damping: float,
    rod: _core.RodOptions | None = None,
) -> None:
    """Put the instruments of several loops into one world, in which they push each other apart.

    Args:
        loops: the loops, none of which runs.
        tools: the capsules of each instrument.
        stiffness, damping: of the contact between two instruments [N/m], [N s/m].
        rod: what their jaws can hold and hand over.
    """
    board = _core.Board(len(loops), rod or _core.RodOptions())
    for i, (loop, tool) in enumerate(zip(loops, tools, strict=True)):
        loop.join(board, i, tool, stiffness, damping)


def capsules(rig: Rig) -> list[_core.ToolCapsule]:
    """The instrument of a rig as others touch it: the capsules of the arm's model, or the sphere at the tip.

    Raises:
        SceneError: a capsule lies on a link that the arm does not have.
    """
    follower, radius = rig.arms.follower, rig.scene.contact.radius
    if not follower.capsules:
        tip = tool_sphere(follower, ToolSphereSection(radius=radius)).core
        return [_core.ToolCapsule(tip, tip, radius)]
    made = []
    for entry in follower.capsules[: _core.MAX_CAPSULES]:
        ends = [
            tool_sphere(follower, ToolSphereSection(link=entry["link"], at=tuple(entry[key]), radius=entry["radius"]))
            for key in ("from", "to")
        ]
        made.append(_core.ToolCapsule(ends[0].core, ends[1].core, entry["radius"]))
    return made


def gap_at_start(a: Rig, b: Rig) -> float:
    """Smallest distance between the instruments of two rigs at the start, negative if they overlap [m]."""
    return min(
        float(np.linalg.norm(np.subtract(*_core.nearest_points(*p, *q)))) - r - s
        for p, r in _placed(a)
        for q, s in _placed(b)
    )


def _placed(rig: Rig) -> list[tuple[list[np.ndarray], float]]:
    """Ends (3,) in W [m] and radius [m] of each capsule at the start, with closed jaws."""
    arms = rig.arms
    links = arms.follower.link_poses(arms.q_follower0, 0.0)
    X_WT = arms.X_WB @ arms.follower.fk(arms.q_follower0)
    found = []
    entries = arms.follower.capsules or [{"link": None, "from": (0, 0, 0), "to": (0, 0, 0), "radius": 0.002}]
    for entry in entries:
        X = X_WT if entry["link"] is None else arms.X_WB @ links[entry["link"]]
        ends = [X[:3, :3] @ np.array(entry[key], dtype=float) + X[:3, 3] for key in ("from", "to")]
        found.append((ends, float(entry["radius"])))
    return found
