"""Forward kinematics of many configurations at once, and how far a motion of the joints can move a point.

The checker needs the poses of an arm for whole batches of configurations, and for each joint the distance of a body
from its axis. Both come from the arm's URDF; `tests/planning` compares the poses with those of `palpate.Arm`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from xml.etree import ElementTree

import numpy as np

from palpate.arm import Arm
from palpate.base.arrays import Array
from palpate.base.errors import ArmError


@dataclass(frozen=True)
class Joint:
    """A joint that moves when the arm moves: one of the chain, or one that mimics it (bars of a parallelogram)."""

    name: str
    parent: int  # index of the moving link before it; -1: the base
    X_parent: Array  # (4, 4): its frame in that link
    axis: Array  # (3,) unit vector in its frame
    turns: bool  # True: revolute; False: prismatic
    source: int  # index of the arm's joint that drives it
    multiplier: float


class Kinematics:
    """Poses of the links of an arm in its base frame, for batches of configurations.

    Args:
        arm: an arm with a URDF.
        jaw: angle of the jaws, constant [rad].

    Raises:
        ArmError: the arm has no URDF.
    """

    def __init__(self, arm: Arm, jaw: float = 0.0) -> None:
        if not arm.urdf:
            what = f"{arm.name} has no URDF, so no motion of its links can be planned"
            raise ArmError(what, mend="use an arm that is described by a URDF (docs/arms.md)")
        self.arm, self.n = arm, arm.n
        self.joints: list[Joint] = []
        self.mount: dict[str, tuple[int, Array]] = {arm.frames[0]: (-1, np.eye(4))}
        """Moving link that carries each link (-1: the base), and the constant pose of the link in it."""
        self._read(ElementTree.fromstring(arm.urdf), jaw)
        m = len(self.joints)
        self.moves = np.zeros((m, m), dtype=bool)
        """moves[k, j]: joint j moves moving link k."""
        for k, joint in enumerate(self.joints):
            self.moves[k, k] = True
            if joint.parent >= 0:
                self.moves[k] |= self.moves[joint.parent]
        self.source = np.array([joint.source for joint in self.joints])
        self.multiplier = np.array([joint.multiplier for joint in self.joints])
        self.turns = np.array([joint.turns for joint in self.joints])

    def _read(self, robot: ElementTree.Element, jaw: float) -> None:
        index = {name: i for i, name in enumerate(self.arm.joint_names)}
        left = list(robot.findall("joint"))
        while left:
            ready = [j for j in left if _link(j, "parent") in self.mount]
            if not ready:
                return  # links outside of the arm's tree
            for element in ready:
                self._add(element, index, jaw)
            left = [j for j in left if j not in ready]

    def _add(self, element: ElementTree.Element, index: dict[str, int], jaw: float) -> None:
        """Add a joint: as a moving one, or as a constant pose if the arm does not move it."""
        parent, X_link = self.mount[_link(element, "parent")]
        X = X_link @ _origin(element)
        axis_element, mimic = element.find("axis"), element.find("mimic")
        axis = _numbers(None if axis_element is None else axis_element.get("xyz"), "1 0 0")
        axis = axis / max(float(np.linalg.norm(axis)), 1e-12)
        name, multiplier, offset = element.get("name", ""), 1.0, 0.0
        if mimic is not None:
            name = mimic.get("joint", "")
            multiplier, offset = float(mimic.get("multiplier", "1")), float(mimic.get("offset", "0"))
        turns = element.get("type") in ("revolute", "continuous")
        child = _link(element, "child")
        if element.get("type") == "fixed" or name not in index:
            turned = multiplier * jaw + offset if turns and element.get("type") != "fixed" else 0.0
            self.mount[child] = (parent, X @ _turn(axis, turned))
            return
        if offset:
            X = X @ (_turn(axis, offset) if turns else _shift(axis * offset))
        self.joints.append(Joint(element.get("name", ""), parent, X, axis, turns, index[name], multiplier))
        self.mount[child] = (len(self.joints) - 1, np.eye(4))

    def poses(self, q: Array) -> Array:
        """Poses X_Blink (K, m, 4, 4) in the base of the moving links at q (K, n) [rad, m]."""
        constant, sine, versine, slide = self._parts
        x = q[:, self.source] * self.multiplier
        turn = np.where(self.turns, x, 0.0)
        X = (
            constant
            + np.sin(turn)[:, :, None, None] * sine
            + (1.0 - np.cos(turn))[:, :, None, None] * versine
            + np.where(self.turns, 0.0, x)[:, :, None, None] * slide
        )
        for k, joint in enumerate(self.joints):
            if joint.parent >= 0:
                X[:, k] = X[:, joint.parent] @ X[:, k]
        return X

    @cached_property
    def _parts(self) -> tuple[Array, Array, Array, Array]:
        """Parts (m, 4, 4) of the pose of each link in its parent: constant, times sin x, 1 - cos x, and x."""
        parts = np.zeros((4, len(self.joints), 4, 4))
        for k, joint in enumerate(self.joints):
            S = np.zeros((4, 4))
            S[:3, :3] = _skew(joint.axis)
            parts[0, k] = joint.X_parent
            parts[1, k], parts[2, k] = joint.X_parent @ S, joint.X_parent @ S @ S
            parts[3, k, :3, 3] = joint.X_parent[:3, :3] @ joint.axis
        return parts[0], parts[1], parts[2], parts[3]

    @cached_property
    def own_axes(self) -> Array:
        """Unit axes (m, 3) of the moving joints, in the frames of their links."""
        return np.array([joint.axis for joint in self.joints])

    def rates(self, rate: Array) -> Array:
        """Bounds (m,) of the speeds of the moving joints for bounds (n,) of those of the arm's joints."""
        return np.asarray(np.abs(rate)[self.source] * np.abs(self.multiplier))


def _link(joint: ElementTree.Element, which: str) -> str:
    found = joint.find(which)
    return "" if found is None else found.get("link", "")


def _numbers(text: str | None, default: str) -> Array:
    return np.array([float(x) for x in (text or default).split()])


def _origin(element: ElementTree.Element) -> Array:
    origin = element.find("origin")
    if origin is None:
        return np.eye(4)
    return pose_of(_numbers(origin.get("xyz"), "0 0 0"), _numbers(origin.get("rpy"), "0 0 0"))


def pose_of(xyz: Array, rpy: Array) -> Array:
    """Pose (4, 4) with position xyz (3,) [m] and R = Rz(yaw) Ry(pitch) Rx(roll) of rpy (3,) [rad]."""
    X = _turn(np.array([0, 0, 1.0]), rpy[2]) @ _turn(np.array([0, 1.0, 0]), rpy[1])
    X = X @ _turn(np.array([1.0, 0, 0]), rpy[0])
    X[:3, 3] = xyz
    return X


def _skew(a: Array) -> Array:
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


def _turn(axis: Array, angle: float) -> Array:
    X, S = np.eye(4), _skew(axis)
    X[:3, :3] += np.sin(angle) * S + (1.0 - np.cos(angle)) * S @ S
    return X


def _shift(p: Array) -> Array:
    X = np.eye(4)
    X[:3, 3] = p
    return X
