"""A simulated hand that touches places of an organ with the tool of a scene, through the whole haptic loop."""

from __future__ import annotations

from typing import Any

import numpy as np
import yaml

from palpate.base.arrays import Array, so3
from palpate.base.arrays.yaml_loader import OwnLoader
from palpate.base.errors import PalpateError
from palpate.record.ticks import Ticks, as_ticks
from palpate.scene.rig import Rig, build
from palpate.scene.scene import Scene

STANDOFF = 0.012  # height above a place at which the approach begins [m]
_LIFT = 0.02  # height above the organ at which the tool travels [m]
_TRAVEL, _APPROACH = 0.12, 0.01  # speeds of the tool [m/s]
_BATCH = 20  # ticks between two looks at the force
_FELT = (0.08, 0.4)  # forces between which the contact is extrapolated [N]
_ROWS = 10  # ticks between these forces that a line needs [-]
_STEEPEST = 0.5  # smallest vertical component of a normal that the hand can approach from above [-]
_BELOW, _MISSED = 3e-3, 1e-3  # depth that both arms must reach [m], error with which they reach it [m, rad]
_PAST = 0.02  # the approach ends this far behind the expected place [m]


class TouchingHand:
    """A hand that lowers the tip of the follower onto places, one after the other, in a simulation of its own.

    The place of first contact is measured as an operator's robot can: the tip's position at zero force, extrapolated
    from the force felt while it presses in, so that the tissue's stiffness need not be known. It has the error of the
    arm's kinematics: `noise`, independent from touch to touch, and a common error of the tip's calibrated offset.

    Args:
        rig: the scene with its objects at their true poses.
        noise: standard deviation of a touch on each axis [m].
        tip: error of the tip's calibrated offset (3,) in the tool's frame [m].
        seed: seed of the noise.
    """

    def __init__(self, rig: Rig, noise: float, tip: Array, seed: int) -> None:
        self._rig = _resting(rig)
        self._noise, self._tip, self._rng = noise, tip, np.random.default_rng([seed, 2])
        self._scale = rig.scene.mapping.scale
        self._offset = np.zeros(3)  # of the hand from its path, as tool motion [m]
        self._high = max(float(one.bounds[1, 2]) for one in rig.surfaces) + _LIFT
        self._sim = self._rig.simulation(seed)
        self._now: Ticks = as_ticks(self._sim.run(200))[-1]
        self.radius = rig.scene.contact.radius  #: of the tip's sphere [m]
        self.seconds = 0.2  #: simulated time so far [s]

    @property
    def pose(self) -> Array:
        """Pose X_WT (4, 4) of the tool [m]."""
        return so3.pose(self._now["p_WT"], self._now["quat_WT"])

    def reaches(self, p_W: Array, n_W: Array) -> bool:
        """True if the tool, in its present orientation, reaches a place p_W (3,) from outside along n_W (3,) [m]."""
        above = p_W + (self.radius + STANDOFF) * n_W
        places = (self._raised(above), above, p_W + (self.radius - _BELOW) * n_W)
        return bool(n_W[2] > _STEEPEST) and all(self._both_reach(p) for p in places)

    def _both_reach(self, p_W: Array) -> bool:
        """True if both arms reach a position p_W (3,) of the tool, with their orientation at the start [m]."""
        arms = self._rig.arms
        X_BT, X_LH = arms.follower.fk(arms.q_follower0), arms.leader.fk(arms.q_leader0)
        step = p_W - (arms.X_WB @ X_BT)[:3, 3]
        X_BT[:3, 3] += arms.X_WB[:3, :3].T @ step
        X_LH[:3, 3] += arms.X_WL[:3, :3].T @ step / self._scale
        return all(
            result.position_error < _MISSED and result.orientation_error < _MISSED
            for _, result in (
                arms.follower.ik_nearest(X_BT, arms.q_follower0, restarts=0),
                arms.leader.ik_nearest(X_LH, arms.q_leader0, restarts=0),
            )
        )

    def touch(self, p_W: Array, n_W: Array) -> Array | None:
        """Measured pose X_WT (4, 4) at the first contact near a place p_W (3,) with normal n_W (3,); None if none."""
        above = p_W + (self.radius + STANDOFF) * n_W
        for goal in (self._raised(self.pose[:3, 3]), self._raised(above), above, above):
            self._move(goal, _TRAVEL)
        rows = self._press(-n_W, STANDOFF + _PAST)
        self._move(above, _TRAVEL)
        if rows is None or len(rows) < _ROWS:
            return None
        force = np.linalg.norm(rows["F_T_W"], axis=1)
        slope = np.linalg.lstsq(np.column_stack([np.ones_like(force), force]), rows["p_WT"], rcond=None)[0]
        X = so3.pose(slope[0], rows[-1]["quat_WT"])
        X[:3, 3] += X[:3, :3] @ self._tip + self._noise * self._rng.normal(size=3)
        return X

    def _raised(self, p_W: Array) -> Array:
        return np.array([p_W[0], p_W[1], max(float(p_W[2]), self._high)])

    def _move(self, p_W: Array, speed: float) -> None:
        """Move the tool towards p_W (3,) [m] in a straight line."""
        step = p_W - self._now["p_WT"]
        seconds = float(np.linalg.norm(step)) / speed + 0.05
        self._lead(step, max(1, round(seconds * self._rig.scene.rates.haptic)))

    def _press(self, direction: Array, far: float) -> Ticks | None:
        """Rows of the first contact, while the tool moves along a direction (3,); None if nothing is felt."""
        rate = self._rig.scene.rates.haptic
        rows: list[Ticks] = []
        for _ in range(round(far / _APPROACH * rate / _BATCH)):
            rows.append(self._lead(direction * (_APPROACH * _BATCH / rate), _BATCH))
            if np.linalg.norm(self._now["F_T_W"]) > _FELT[1]:
                both: Ticks = np.concatenate(rows)
                force = np.linalg.norm(both["F_T_W"], axis=1)
                first: Ticks = both[(force > _FELT[0]) & (force <= _FELT[1])]
                return first
        return None

    def _lead(self, step: Array, n: int) -> Ticks:
        """Move the hand so that the tool moves by step (3,) [m] in n ticks; returns their rows."""
        share = (np.arange(1, n + 1) / n)[:, None]
        path = (self._offset + share * step) / self._scale
        rows = as_ticks(self._sim.run(n, path))
        self._offset = self._offset + step
        self._now, self.seconds = rows[-1], self.seconds + n / self._rig.scene.rates.haptic
        if fault := self._sim.fault():
            raise PalpateError(
                "the simulated hand cannot continue", why=fault, mend="move the arms nearer to the organ"
            )
        return rows


def _resting(rig: Rig) -> Rig:
    """The rig with a hand that rests above the highest point of the objects."""
    data: dict[str, Any] = yaml.load(rig.resolved_yaml(absolute=True), OwnLoader)
    first = rig.surfaces[0]
    top = first.nearest(first.top[None])[0][0]
    start = [float(top[0]), float(top[1]), max(float(one.bounds[1, 2]) for one in rig.surfaces) + _LIFT]
    path = [{"t": 0.0, "xyz": start}, {"t": 1.0, "xyz": start}]
    data["operator"] = {key: data["operator"][key] for key in ("mass", "damping", "stiffness")} | {"path": path}
    data |= {"preset": None, "guidance": [], "registration": None, "trackers": {}}
    return build(Scene.model_validate({key: value for key, value in data.items() if value is not None}))
