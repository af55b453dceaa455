"""The haptic node: damaged, forged and late messages between sound ones, into the cycle that the node feeds.

The wrench is finite and below its caps after every message, and grows no faster than its rate cap.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from scipy.spatial.transform import Rotation

from palpate import _core
from palpate.arm import Arm
from palpate.base.arrays import Array
from palpate.scene.rig import Rig, build
from palpate.scene.scene import Scene
from palpate_lab.verify.fuzz import FaultError
from palpate_lab.verify.fuzz.ports import values

_SCENE = """
objects: [{name: ball, sphere: {radius: 0.03}, stiffness: 500, friction: 0.4}]
"""
_STEPS = (1e-3, 1e-3, 1e-3, 1e-3, 5e-4, 4e-3, 0.03, 0.2)  # [s]
_WALL = 1.7e9  # system clock at the start [s]
_GATES = ("following", "operator_present", "clutch", "camera", "leader_enabled", "follower_enabled", "second_writer")


@cache
def _rig() -> tuple[Rig, Arm, Array]:
    """The rig, the model of the follower, and the pose of the leader's handle at the start."""
    rig = build(Scene.parse(_SCENE), until=0.0)
    return rig, Arm.psm("lnd"), np.asarray(rig.arms.leader.fk(rig.arms.q_leader0))


class _Node:
    """The cycle with a virtual follower, its clock, and the pose that a sound leader would send."""

    def __init__(self, rng: np.random.Generator) -> None:
        rig, follower, self.X = _rig()
        options = rig.options()
        self.stability = options.stability
        made = _core.CrtkOptions(options, rig.arms.q_follower0)
        made.virtual_follower = True
        made.tip_frame = bool(rng.integers(2))
        self.cycle = _core.CrtkCycle(made, follower)
        self.cycle.set_scene(rig.snapshot)
        self.quat = Rotation.from_matrix(self.X[:3, :3]).as_quat()
        self.down = rig.arms.X_WL[:3, :3].T @ np.array([0.0, 0.0, -1.0])
        self.t, self.force, self.pressed = 0.0, 0.0, 0.0
        self.gates = _core.CrtkGates()
        for name in ("following", "operator_present", "leader_enabled", "follower_enabled"):
            setattr(self.gates, name, True)

    def sound(self) -> None:
        """A pose as of a hand that presses by up to 60 mm."""
        self.pressed = min(self.pressed + 0.002, 0.06)
        p = self.X[:3, 3] + self.pressed * self.down
        self.cycle.leader_pose(_WALL + self.t, p, self.quat, self.t, _WALL + self.t)

    def step(self, dt: float) -> None:
        self.t += dt
        self.cycle.set_gates(self.gates)
        _, wrench, goal, jaw = self.cycle.step(self.t, _WALL + self.t)
        self._judge(np.zeros(6) if wrench is None else np.asarray(wrench), dt)
        if goal is not None and not (np.isfinite(goal).all() and np.isfinite(jaw)):
            raise FaultError(f"a goal that is not finite: {np.asarray(goal).tolist()}, jaw {jaw}")

    def _judge(self, wrench: Array, dt: float) -> None:
        force, s = math.hypot(*wrench[:3]), self.stability
        if not all(map(math.isfinite, wrench)) or force > s.force_cap * (1.0 + 1e-9):
            raise FaultError(f"a wrench of {wrench.tolist()} with a cap of {s.force_cap:g} N")
        most = s.rate_cap * max(dt, 1e-3) * (1.0 + 1e-6) + 1e-6
        if force - self.force > most:
            raise FaultError(f"the force grew by {force - self.force:.4g} N in {1e3 * dt:g} ms; at most {most:.4g} N")
        self.force = force


def case(rng: np.random.Generator, messages: int, by_socket: bool) -> int:
    """Send messages; returns their number. Raises FaultError."""
    node = _Node(rng)
    for _ in range(int(rng.integers(messages))):  # some nodes push when the first forged message comes
        node.sound()
        node.step(1e-3)
    for _ in range(messages):
        _forge(rng, node)
        if rng.random() < 0.7:
            node.sound()
        node.step(values.pick(rng, _STEPS))
    return messages


def _forge(rng: np.random.Generator, node: _Node) -> None:
    """One message with wrong stamps, numbers or sizes."""
    cycle, kind = node.cycle, int(rng.integers(9))
    wall = _WALL + node.t
    stamp = values.pick(rng, (wall, wall, 0.0, wall - 10.0, wall + 10.0, wall + 0.02, math.nan, math.inf, -1e18, 1e18))
    if kind < 3:
        p, quat = node.X[:3, 3] + node.pressed * node.down, node.quat
        change = int(rng.integers(6))
        p = values.array(rng, 3) if change == 0 else 1e3 * p if change == 1 else p + 0.01 * rng.normal(size=3)
        quat = (
            values.array(rng, 4) if change == 2 else np.zeros(4) if change == 3 else 1e3 * quat if change == 4 else quat
        )
        send = cycle.leader_pose if kind < 2 else cycle.follower_pose
        send(stamp, np.ascontiguousarray(p), np.ascontiguousarray(quat), node.t, wall)
    elif kind == 3:
        cycle.leader_twist(stamp, values.array(rng, 3), values.array(rng, 3), node.t, wall)
    elif kind == 4:
        cycle.leader_joints(stamp, values.array(rng, values.pick(rng, (0, 1, 6, 7, 8, 40))))
    elif kind == 5:
        cycle.follower_joints(stamp, values.array(rng, values.pick(rng, (0, 1, 6, 7, 40))), node.t, wall)
    elif kind == 6:
        (cycle.gripper if rng.random() < 0.5 else cycle.jaw)(stamp, values.array(rng, int(rng.integers(3))))
    elif kind == 7:
        cycle.set_scale(values.number(rng))
    else:
        name = values.pick(rng, _GATES)
        setattr(node.gates, name, not getattr(node.gates, name))
