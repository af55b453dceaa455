"""Steps the cycle of a device along a prescribed motion of the tool."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import yaml

from palpate import _core
from palpate.base.arrays import Array
from palpate.base.arrays.plain import Content
from palpate.base.errors import InvalidSceneError
from palpate.devices.loop import device_options, device_port, device_scene
from palpate.scene import Scene
from palpate.scene.rig import Rig, build
from palpate_lab.verify.fuzz.loops.port import rotations


def scene_of(values: Content, folder: Path) -> Scene:
    """The scene of the values of a scene file.

    Raises:
        PalpateError: a value is invalid.
    """
    try:
        scene = Scene.model_validate(values, context={"folder": folder})
    except InvalidSceneError:
        return Scene.parse(yaml.safe_dump(values, sort_keys=False), str(folder / "loop.yaml"))  # says what is wrong
    return scene.with_origin(str(folder / "loop.yaml"), {})


class Device:
    """A scene on a device, of which each run starts anew.

    Args:
        scene: the values of a scene file.
        folder: folder of the files that the scene names.
        like: a device whose scene differs in the sections `stability` and `rates` alone, which saves time.

    Raises:
        PalpateError: the scene cannot run.
    """

    def __init__(self, scene: Content, folder: Path, like: Device | None = None) -> None:
        self._values, self._folder = scene, folder
        self.scene = device_scene(scene_of(scene, folder), "loop")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            self._rig: Rig = build(self.scene) if like is None else replace(like._rig, scene=self.scene)

    @property
    def period(self) -> float:
        """Period of the cycle [s]."""
        return 1.0 / self.scene.rates.haptic

    @property
    def fixtures(self) -> _core.FixtureList:
        """The fixtures of the scene."""
        return self._rig.fixtures

    @property
    def no_fixtures(self) -> _core.FixtureList:
        """An empty list of fixtures."""
        return _core.FixtureList(self._rig.context.tool)

    def alone(self) -> Iterator[Device]:
        """A device for each fixture of the scene, which has no other one and touches nothing that is felt."""
        first = self._values["objects"][0]
        felt = {"name": "body", "sphere": {"radius": 1e-4}, "pose": first["pose"], "stiffness": 1e-3, "damping": 0.0}
        for one in self._values.get("guidance", ()):
            yield Device(self._values | {"objects": [felt], "guidance": [one]}, self._folder)

    def cycle(self) -> _core.DeviceCycle:
        """A new cycle."""
        rig = self._rig
        cycle = _core.DeviceCycle(device_options(rig, device_port(rig.scene)), rig.arms.follower, rig.snapshot)
        cycle.set_fixtures(rig.fixtures)
        return cycle

    def handle(self, p: Array, theta: Array) -> Array:
        """Poses X_LH (n, 4, 4) of the handle for which the mapping gives the tool a motion.

        Args:
            p: positions of the tool (n, 3) in W; the first is where the scene starts [m].
            theta: rotation vectors of the tool (n, 3) relative to the start, in W [rad].
        """
        R_WL, scale = self._rig.arms.X_WL[:3, :3], self.scene.mapping.scale
        X = np.tile(np.eye(4), (len(p), 1, 1))
        X[:, :3, 3] = (p - p[0]) @ R_WL / scale
        X[:, :3, :3] = R_WL.T @ rotations(theta) @ R_WL
        return X

    def wrenches(self, X: Array, t: Array | None = None) -> Array:
        """Wrenches (n, 6) on the hand in L for poses of the handle (n, 4, 4), one tick each [N, N m].

        t: times (n,) of the ticks, by default a period apart [s].
        """
        F = np.zeros((len(X), 6))
        times = np.asarray(self.period * np.arange(len(X)) if t is None else t, dtype=np.float64)
        self.cycle().replay(times, np.ascontiguousarray(X), F)
        return F

    def at_rest(self) -> Callable[[Array], Array]:
        """The wrench (6,) on the hand in L at rest at a pose of the handle (4, 4), after all poses before it."""
        cycle, t = self.cycle(), [0.0]

        def wrench(X: Array) -> Array:
            F = np.zeros((2, 6))
            cycle.replay(t[0] + self.period * np.arange(1.0, 3.0), np.ascontiguousarray(np.stack([X, X])), F)
            t[0] += 2 * self.period
            return np.asarray(F[1])

        return wrench

    def force_in_world(self, F: Array) -> Array:
        """Forces on the tool (n, 3) in W of wrenches on the hand (n, 6) in L [N]."""
        return np.asarray(F[:, :3] @ self._rig.arms.X_WL[:3, :3].T / self.scene.mapping.force_scale)
