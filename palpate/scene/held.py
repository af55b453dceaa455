"""The rigid bodies of a scene among the tools of its rigs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from palpate import _core
from palpate.base.arrays import Array
from palpate.base.arrays.plain import Content
from palpate.base.errors import SceneError
from palpate.scene.rig import Rig
from palpate.scene.scene import Scene
from palpate.scene.tool import ToolSphereSection, tool_sphere
from palpate.world.bodies import shapes
from palpate.world.bodies.engine import JawShape, LinkShape, ToolShape, World
from palpate.world.bodies.shapes import Solid

if TYPE_CHECKING:
    from palpate.scene.together import Joined


def join(
    rigs: Mapping[str, Rig], loops: Sequence[Joined], delay: float = 0.0, rate: float | None = None
) -> World | None:
    """Put the tools of all loops among the bodies of their scene; None for a scene without bodies.

    Args:
        rigs, delay, rate: as for `world`.
        loops: the loops of the rigs, none of which runs.

    Raises:
        MissingExtraError, SceneError, MeshError: as `World`.
    """
    made = world(rigs, delay, rate)
    if made is not None:
        bodies = made.core(next(iter(rigs.values())).snapshot)
        for tool, loop in enumerate(loops):
            loop.join_bodies(bodies, tool)
    return made


def world(rigs: Mapping[str, Rig], delay: float = 0.0, rate: float | None = None) -> World | None:
    """The bodies of a scene in an engine, with a virtual tool for each rig; None for a scene without bodies.

    Args:
        rigs: the rigs by name.
        delay: time by which force and motion wait beyond the loop and its arms, as on a network [s].
        rate: of the slowest loop [Hz]; the scene's when left out.

    Raises:
        MissingExtraError, SceneError, MeshError: as `World`.
    """
    first = next(iter(rigs.values()))
    scene = first.scene
    if not scene.bodies:
        return None
    where = scene.where("bodies")
    tools = [tool_shape(name or "tool", rig) for name, rig in rigs.items()]
    lag = delay + max(lag_of(rig) for rig in rigs.values())
    rate = scene.rates.haptic if rate is None else rate
    return World(scene.bodies, scene.engine, tools, lambda name: scene.path_to(name, where), where, lag, rate)


def solids(scene: Scene) -> list[Solid]:
    """The bodies of a scene and the links of their threads, for pictures and records.

    Raises:
        SceneError, MeshError: a mesh cannot be read.
    """
    where = scene.where("bodies")
    return shapes.solids(scene.bodies, lambda name: scene.path_to(name, where))


def lag_of(rig: Rig) -> float:
    """Time by which the follower's joints follow their goals, and the force its command [s]."""
    o = rig.options()
    servo = 2.0 * np.pi * o.follower.bandwidth
    follower = 2.0 * o.follower.damping_ratio / servo if servo > 0.0 else 0.0
    return float(follower + o.loop_delay + 0.5 * o.loop_jitter + o.leader.drive_lag)


def tool_shape(name: str, rig: Rig) -> ToolShape:
    """The jaws of a rig's tool, from the capsules of its model, in T."""
    arms, follower = rig.arms, rig.arms.follower
    X_WT = arms.X_WB @ follower.fk(arms.q_follower0)
    links = follower.link_poses(arms.q_follower0, 0.0)
    jaws = []
    for entry in follower.capsules:
        if not str(entry["link"]).startswith("jaw"):
            continue
        a, b = (
            tool_sphere(follower, ToolSphereSection(link=entry["link"], at=tuple(entry[key]), radius=entry["radius"]))
            for key in ("from", "to")
        )
        joint = follower.drawn_joint(entry["link"])
        assert a.link is not None
        assert joint is not None
        X_TL = np.linalg.inv(X_WT) @ arms.X_WB @ links[a.link]
        turn = X_TL[:3, :3] @ (joint.multiplier * joint.X_parent[:3, :3] @ joint.axis)
        ratio = float(np.linalg.norm(turn))
        ends = [X_TL[:3, :3] @ end.core.centre(0.0) + X_TL[:3, 3] for end in (a, b)]
        hinge = X_TL[:3, :3] @ joint.X_parent[:3, 3] + X_TL[:3, 3]
        jaws.append(JawShape(hinge, turn / ratio, ratio, ends[0], ends[1], float(entry["radius"])))
    outer = _links(rig) if rig.scene.engine.shafts else ()
    return ToolShape(name, X_WT, tuple(jaws[:2]), rig.scene.contact.radius, outer)


def _links(rig: Rig) -> tuple[LinkShape, ...]:
    """Shaft and wrist of a rig's instrument: the longest capsules of its model that are no jaws."""
    others = [entry for entry in rig.arms.follower.capsules if not str(entry["link"]).startswith("jaw")]
    others.sort(key=lambda one: -float(np.linalg.norm(np.subtract(one["to"], one["from"]))))
    found = (_link(rig, entry) for entry in others[: _core.MAX_BODY_LINKS])
    return tuple(one for one in found if one is not None)


def _link(rig: Rig, entry: Content) -> LinkShape | None:
    """The link of a capsule; None if it is not one of the arm's."""
    arms, follower = rig.arms, rig.arms.follower
    a, b = (
        tool_sphere(follower, ToolSphereSection(link=entry["link"], at=tuple(entry[key]), radius=entry["radius"]))
        for key in ("from", "to")
    )
    link = a.link
    if link is None:
        return None

    def place(q: Array) -> Array:
        return np.asarray(follower.link_poses(q, 0.0)[link])

    q = arms.q_follower0
    moves = tuple(not np.allclose(place(q + step), place(q), atol=1e-9) for step in 1e-3 * np.eye(len(q)))
    ends = (a.core.centre(0.0), b.core.centre(0.0))
    return LinkShape(link, a.core.link, moves, arms.X_WB @ place(q), *ends, float(entry["radius"]))


def refuse(scene: Scene, where: str) -> None:
    """Refuse a scene with bodies where no engine moves them; `where` says it in words.

    Raises:
        SceneError: the scene has bodies.
    """
    if scene.bodies:
        mend = "run it with simulated arms on this machine (palpate run), or leave bodies out"
        raise SceneError(f"bodies are not moved {where}", where=scene.where("bodies"), mend=mend)


def refuse_graspable(scene: Scene) -> None:
    """Refuse an object that hands carry, for tools that are led by devices or policies.

    Raises:
        SceneError: the scene has one.
    """
    if scene.graspable is not None:
        what = f"the object {scene.graspable.name!r} is not carried by tools that devices or policies lead"
        raise SceneError(what, where=scene.where("graspable"), mend="leave it out, or simulate both hands")
