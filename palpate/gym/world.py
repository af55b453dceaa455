"""A scene prepared for the instruments that a policy moves: their options, their start, the limits of their motion."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from palpate import _core
from palpate.base.arrays import Array
from palpate.base.arrays.checks import positive
from palpate.base.errors import PalpateError, SceneError
from palpate.devices.handle import AtHandle
from palpate.devices.loop import device_options, device_port, device_scene
from palpate.scene import held
from palpate.scene.overrides import override
from palpate.scene.rig import MATERIALS, Rig, build, with_materials
from palpate.scene.scene import Scene
from palpate.scene.surface import Bodies
from palpate.session.tasks import drawn

RATE = 1000.0
"""Ticks of the haptic cycle per second [Hz]."""


@dataclass(frozen=True)
class Motion:
    """Limits of the motion that actions can ask for.

    Raises:
        ValueError: one is not positive and finite.
    """

    speed: float = 0.05
    """Largest speed of the goal along each axis of W [m/s]."""
    turn: float = 1.0
    """Largest rotation speed of the goal about each axis of W [rad/s]."""
    reach: float = 0.06
    """Largest distance of the goal from the start along each axis of W [m]."""
    tilt: float = 0.8
    """Largest rotation of the goal from the start about each axis of W [rad]."""
    pinch: float = 3.0
    """Largest speed of the pinch that opens and closes the jaws [rad/s]."""

    def __post_init__(self) -> None:
        """Check the limits."""
        for limit in fields(self):
            positive(limit.name, getattr(self, limit.name), "m, rad and s")


class World:
    """A scene for any number of worlds, each with the instruments of all its pairs. The worlds do not meet.

    Args:
        scene: a scene, its values, its file, or the name of a shipped one; its leaders have no effect.
        vary: ranges from which a value of the scene is drawn at each reset, by its path: ``{"objects.0.stiffness":
            (200, 600)}``. Surfaces are made once. What the scene's task leaves to the seed is drawn as well.

    Raises:
        SceneError, MeshError: the scene cannot run. PalpateError: a range is not two finite, rising numbers, or the
        force of the scene is estimated, which needs the drives of a real or simulated follower.
    """

    def __init__(
        self, scene: Scene | dict[str, Any] | str | os.PathLike[str], vary: Mapping[str, tuple[float, float]]
    ) -> None:
        for name, limits in vary.items():
            if len(limits) != 2 or not -np.inf < limits[0] <= limits[1] < np.inf:
                raise PalpateError(
                    f"vary {name} = {limits}: must be two rising numbers", mend="give (low, high), both finite"
                )
        self.scene = Scene.of(scene)
        self.vary = {name: (float(low), float(high)) for name, (low, high) in sorted(vary.items())}
        self._only_materials = all(_is_material(name) for name in self.vary)
        self._bodies: Bodies = {}
        self.rigs = self._prepared(self.scene)
        """The rigs of all pairs without variation."""
        self.names = tuple(self.scene.each_pair())
        """Names of the pairs; of one without a name, the empty word."""

    @property
    def plain(self) -> Rig:
        """The first rig without variation."""
        return self.rigs[0]

    @property
    def pinches(self) -> bool:
        """True if the jaws are moved, too: the scene has rigid bodies, several pairs, or a task."""
        return bool(self.scene.bodies) or len(self.rigs) > 1 or self.scene.task is not None

    def drawn(self, rng: np.random.Generator) -> tuple[Rig, ...]:
        """The rigs of all pairs with values drawn from the ranges."""
        hidden = self.scene.task is not None and self.scene.task.find is not None
        if not self.vary and not hidden:
            return self.rigs
        values = {name: float(rng.uniform(low, high)) for name, (low, high) in self.vary.items()}
        scene = override(self.scene, values)
        if hidden:
            return self._prepared(drawn(scene, int(rng.integers(2**31))))
        if self._only_materials and len(self.rigs) == 1:
            return (with_materials(self.plain, _device_scene(scene)),)
        return self._prepared(scene)

    def _prepared(self, scene: Scene) -> tuple[Rig, ...]:
        held.refuse_graspable(scene)
        rigs: list[Rig] = []
        for one in scene.each_pair().values():
            if one.force.source != "contact":
                what = f"force.source is {one.force.source!r}, which needs the torques of a follower's drives"
                mend = "force: {source: contact}: a policy moves a tool without drives"
                raise SceneError(what, where=scene.where("force", "source"), mend=mend)
            rig = build(_device_scene(one), self._bodies, until=0.0)
            rigs.append(replace(rig, snapshot=rigs[0].snapshot, surfaces=rigs[0].surfaces) if rigs else rig)
        return tuple(rigs)


def _is_material(name: str) -> bool:
    """True for the path of a value of which only the materials of an object depend."""
    first, _, key, *_ = [*name.split("."), "", ""]
    return first == "objects" and key in MATERIALS


def _device_scene(scene: Scene) -> Scene:
    return device_scene(for_policies(scene), "loop", RATE)


def for_policies(scene: Scene) -> Scene:
    """The scene with the axes of W as those of the handle, which moves as far as the tool."""
    leader = scene.arms.leader.model_copy(update={"base": None})
    mapping = scene.mapping.model_copy(update={"law": "indexed", "scale": 1.0})
    arms = scene.arms.model_copy(update={"leader": leader})
    return scene.model_copy(update={"arms": arms, "mapping": mapping}).with_file_of(scene)


def cycle_at(rig: Rig, X_WT: Array | None = None) -> tuple[_core.DeviceCycle, Array]:
    """A fresh cycle whose tool starts at a pose X_WT (4, 4), or where the scene has it; and the pose at which it is.

    The nearest pose that the arm reaches is taken.
    """
    arms = rig.arms
    if X_WT is not None:
        q, _ = arms.follower.ik_nearest(np.linalg.inv(arms.X_WB) @ X_WT, arms.q_follower0, restarts=0)
        arms = replace(arms, q_follower0=q)
    options = device_options(replace(rig, arms=arms), device_port(rig.scene, AtHandle(delay=0.0)))
    cycle = _core.DeviceCycle(options, arms.follower, rig.snapshot)
    cycle.set_fixtures(rig.fixtures)
    return cycle, np.asarray(arms.X_WB @ arms.follower.fk(arms.q_follower0))
