"""Tasks of the environments: where they begin, what they reward, and when they are done."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from palpate.base.arrays import Array
from palpate.base.arrays.checks import positive
from palpate.base.errors import PalpateError
from palpate.gym.world import World
from palpate.record.ticks import Ticks
from palpate.scene.rig import Rig


class Task(Protocol):
    """A task for n instruments. The arrays of an instrument are drawn anew at each of its resets."""

    goals: Array
    """(n, 3) what the observation `goal` shows, in W [m]; NaN-free, zeros if there is nothing to show."""

    def begin(self, n: int, dt: float, world: World) -> None:
        """Prepare for n instruments that act every dt [s]."""
        ...

    def reset(self, i: int, rig: Rig, rng: np.random.Generator) -> Array | None:
        """Draw a new task for instrument i in its scene; of several pairs, the first one.

        Returns:
            The start pose X_WT (4, 4) [m], or None for that of the scene.
        """
        ...

    def evaluate(self, ticks: Ticks, felt: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Reward (n,) and success (n,) after a step, by the newest ticks and the largest forces felt (n,) [N].

        With h pairs, ticks and forces are (n, h).
        """
        ...


class Press:
    """Go to a place on the surface and hold a force there.

    The place is the one that the scene's operator palpates, moved by up to `spread` along the surface. The reward of a
    step is minus the distance in centimetres, minus the relative error of the force; a success adds 10.

    Args:
        force: force to hold [N]; the scene's `operator.palpate.force` when left out.
        within: relative error of the force that counts as held.
        hold: time for which it must be held [s].
        near: distance from the place that counts as there [m].
        spread: largest distance of the place from the one of the scene, along x and y of W [m].

    Raises:
        ValueError: the force is not positive.
    """

    def __init__(
        self,
        force: float | None = None,
        within: float = 0.2,
        hold: float = 0.3,
        near: float = 0.006,
        spread: float = 0.008,
    ) -> None:
        self.force = None if force is None else positive("force", force, "N")
        self.within, self.hold, self.near, self.spread = within, hold, near, spread
        self.goals = np.zeros((0, 3))

    def begin(self, n: int, dt: float, world: World) -> None:
        """Prepare for n instruments.

        Raises:
            PalpateError: the scene has several pairs.
        """
        _require_one_pair("press", world)
        self.goals, self._held, self._dt = np.zeros((n, 3)), np.zeros(n), dt
        self._wanted = world.scene.operator.palpate.force if self.force is None else self.force

    def reset(self, i: int, rig: Rig, rng: np.random.Generator) -> Array | None:
        """Draw the place."""
        about = rig.path.positions_W[min(1, len(rig.path.positions_W) - 1)]
        place = about + np.append(rng.uniform(-self.spread, self.spread, 2), 0.0)
        self.goals[i], _ = on_surface(rig, place)
        self._held[i] = 0.0
        return None

    def evaluate(self, ticks: Ticks, felt: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Distance, force, and the time for which both are right."""
        away = np.linalg.norm(ticks["p_WT"] - self.goals, axis=1)
        force = np.linalg.norm(ticks["F_T_W"], axis=1)
        error = np.abs(force - self._wanted) / self._wanted
        right = (away < self.near) & (error < self.within)
        self._held = np.where(right, self._held + self._dt, 0.0)
        done = self._held >= self.hold - 1e-9
        return np.asarray(-100.0 * away - error + 10.0 * done), done


class Find:
    """Find a hard region under the surface, by pressing.

    The start is drawn around the region, and the observation `goal` does not tell where it is: it shows zeros. The
    reward of a step is minus the distance in centimetres along the surface; success is a press of at least `force`
    within `near` of the region, which adds 10.

    Args:
        region: name of the region; the first of the first object that has one when left out.
        spread: largest distance of the start from the region along x and y of W [m].
        near: distance along the surface that counts as found [m].
        force: force of a press [N].
    """

    def __init__(self, region: str = "", spread: float = 0.02, near: float = 0.004, force: float = 0.5) -> None:
        self.region, self.spread, self.near, self.force = region, spread, near, force
        self.goals = np.zeros((0, 3))

    def begin(self, n: int, dt: float, world: World) -> None:
        """Prepare for n instruments.

        Raises:
            PalpateError: the scene has no such region, or several pairs.
        """
        _require_one_pair("find", world)
        self.goals, self._centres = np.zeros((n, 3)), np.zeros((n, 3))
        names = [one.name for obj in world.scene.objects for one in obj.regions]
        if self.region not in (names if self.region else ["", *names]) or not names:
            what = f"the scene has no region {self.region!r}" if self.region else "the scene has no region to find"
            raise PalpateError(what, mend=f"name one of {', '.join(names)}" if names else "take the scene nodule")
        self.region = self.region or names[0]

    def reset(self, i: int, rig: Rig, rng: np.random.Generator) -> Array | None:
        """Draw the start, above the surface beside the region."""
        index, at = next(
            (k, one.at) for k, obj in enumerate(rig.scene.objects) for one in obj.regions if one.name == self.region
        )
        X_WO = rig.surfaces[index].X_WO
        self._centres[i] = X_WO[:3, :3] @ np.asarray(at) + X_WO[:3, 3]
        beside = self._centres[i] + np.append(rng.uniform(-self.spread, self.spread, 2), 0.0)
        place, normal = on_surface(rig, beside, index)
        X_WT = np.asarray(rig.arms.X_WB @ rig.arms.follower.fk(rig.arms.q_follower0))
        X_WT[:3, 3] = place + 0.005 * normal
        return X_WT

    def evaluate(self, ticks: Ticks, felt: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Distance along the surface, and the press."""
        away = np.linalg.norm((ticks["p_WT"] - self._centres)[:, :2], axis=1)
        done = (away < self.near) & (np.linalg.norm(ticks["F_T_W"], axis=1) >= self.force)
        return np.asarray(-100.0 * away + 10.0 * done), done


TASKS = {"press": Press, "find": Find}
"""Tasks by name."""


def _require_one_pair(task: str, world: World) -> None:
    if len(world.names) > 1:
        what = f"the task {task} is for one instrument, and the scene has the pairs {', '.join(world.names)}"
        raise PalpateError(what, mend="take the scene's own task, an object of your own, or scene.pair(NAME)")


def on_surface(rig: Rig, p_W: Array, index: int | None = None) -> tuple[Array, Array]:
    """Place of the tip's sphere (3,) touching an object near a point, and the outward normal (3,), in W [m].

    The nearest object is taken without an index.
    """
    surfaces = rig.surfaces if index is None else [rig.surfaces[index]]
    found = [surface.nearest(p_W[None]) for surface in surfaces]
    q, n = min(found, key=lambda one: float(np.linalg.norm(one[0][0] - p_W)))
    return q[0] + rig.scene.contact.radius * n[0], n[0]
