"""Arms: the da Vinci master arm (MTM) and patient-side arm (PSM), or any serial arm of a URDF.

    arm = palpate.Arm.mtm("right")
    X_LH = arm.fk(arm.home)                 # pose of the handle in the arm's base, 4x4
    q = arm.ik(X_LH)                        # and back

Numbers of the arms (kinematics, limits, masses, encoders, friction) live in `models/`, each with its source.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self
from xml.etree import ElementTree

import numpy as np
import yaml
from numpy.typing import ArrayLike, NDArray

from palpate import _core
from palpate.errors import ArmError

Array = NDArray[np.float64]

SIDES = ("right", "left")
INSTRUMENTS = ("lnd",)


@dataclass(frozen=True)
class Visual:
    """One primitive of a link, to be drawn at `X_0link @ X_link_visual`."""

    link: str
    shape: str  # "box" | "cylinder" (along z) | "sphere"
    size: tuple[float, ...]  # box: x y z; cylinder: radius, length; sphere: radius [m]
    X_link_visual: Array  # (4, 4)
    colour: tuple[float, float, float, float]  # r g b a, 0..1


@dataclass(frozen=True)
class _DrawnJoint:
    """A joint outside the kinematic chain: a jaw, a grip, a parallelogram's bar. Drawn, without dynamics."""

    name: str
    parent: str
    child: str
    X_parent: Array
    axis: Array
    source: str  # the joint it follows: one of the chain, or a free one such as "jaw"
    multiplier: float


def models_folder() -> Path:
    """Where the arms' files are: beside the installed package, or in the repository's `models/`."""
    here = Path(__file__).resolve().parent
    for folder in (here / "models", here.parent / "models"):
        if (folder / "mtm_right.urdf").is_file():
            return folder
    raise ArmError(
        "the arm models are missing",
        where=str(here / "models"),
        why="neither the installed package nor a repository around it has the folder models/",
        mend="install palpate again (make setup)",
    )


class Arm(_core.Arm):
    """A serial arm in its base frame: kinematics, dynamics, limits, and what it looks like.

    Joint vectors have shape (n,) in rad (prismatic joints: m); poses are 4x4; X_0T is the tip in the base. Methods of
    the compiled class (`fk`, `jacobian`, `gravity`, `bias`, `inverse_dynamics`, `mass_matrix`, ...) raise ValueError
    naming the argument and both shapes. One object holds one workspace: do not share it between threads.
    """

    name: str
    home: Array
    visuals: list[Visual]
    jaw_range: tuple[float, float]

    def __init__(self, xml: str, base_frame: str, tip_frame: str, data: dict[str, Any] | None = None) -> None:
        """From a URDF's text. `data`: what a model's YAML says beyond the URDF (home, friction, encoders ...)."""
        super().__init__(xml, base_frame, tip_frame)
        self._data: dict[str, Any] = data or {}
        robot = ElementTree.fromstring(xml)
        self.name = str(self._data.get("name", robot.get("name", "arm")))
        middle = np.clip(np.zeros(self.n), self.q_min, self.q_max)
        self.home = np.asarray(self._data.get("home", middle), dtype=float)
        self.visuals = _visuals(robot)
        spring = self._data.get("counterbalance")
        if spring is not None:
            self.set_counterbalance(float(spring["torque"]), np.asarray(spring["along"], dtype=float))
        self._drawn = _drawn_joints(robot, set(self.joint_names))
        self.jaw_range = _jaw_range(robot, set(self.joint_names))

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """An arm from a model file (YAML naming a URDF beside it; `models/*.yaml` are examples)."""
        path = Path(path)
        data = yaml.safe_load(path.read_text(encoding="utf-8"))
        xml = (path.parent / data["urdf"]).read_text(encoding="utf-8")
        return cls(xml, data["base_frame"], data["tip_frame"], data)

    @classmethod
    def mtm(cls, side: str) -> Self:
        """The da Vinci master arm, `side` "right" or "left": 7 joints; base L (z up), tip H at the wrist centre."""
        return cls._named("mtm", side, SIDES, "master arm")

    @classmethod
    def psm(cls, instrument: str = "lnd") -> Self:
        """The da Vinci patient-side arm with an instrument ("lnd" = large needle driver).

        6 joints and a jaw; base B = remote centre of motion, tip T on the wrist's yaw axis, z along the jaws.
        """
        return cls._named("psm", instrument, INSTRUMENTS, "patient-side arm")

    @classmethod
    def _named(cls, kind: str, which: str, choices: tuple[str, ...], title: str) -> Self:
        if which not in choices:
            names = " and ".join(f'palpate.Arm.{kind}("{choice}")' for choice in choices)
            raise ArmError(
                f"there is no {title} {which!r}",
                why=f"the models are {', '.join(choices)}",
                mend=f"use {names}, or palpate.Arm.load(path) for an arm of your own",
            )
        return cls.load(models_folder() / f"{kind}_{which}.yaml")

    def ik(self, X_0T: ArrayLike, q0: ArrayLike | None = None, *, restarts: int = 64) -> Array:
        """Joints (n,) that put the tip at X_0T (4, 4), within the limits; near `q0` when it is given.

        Raises:
            ArmError: no start arrives to 1e-8 m and 1e-8 rad; names the smallest error found.
        """
        goal = np.asarray(X_0T, dtype=float)
        q, best = self.ik_nearest(goal, q0, restarts=restarts)
        if best.converged:
            return q
        p = ", ".join(f"{1e3 * x:.1f}" for x in goal[:3, 3])
        raise ArmError(
            f"{self.name} cannot reach the tip pose at ({p}) mm in its base frame",
            why=f"the nearest it came is {1e3 * best.position_error:.2f} mm and "
            f"{math.degrees(best.orientation_error):.2f} degrees away, within its joint limits",
            mend="move the arm's base or the goal, or turn the goal",
        )

    def ik_nearest(
        self, X_0T: ArrayLike, q0: ArrayLike | None = None, *, restarts: int = 64
    ) -> tuple[Array, _core.IkResult]:
        """Joints (n,) whose tip comes nearest to X_0T (4, 4), and how near; `converged` when it is there.

        It starts from `q0` when it is given, from home, then `restarts` times from random joints, always the same.
        Of two misses the nearer one is that with less position error plus 0.05 m per rad of orientation error.
        """
        goal = np.asarray(X_0T, dtype=float)
        options = _core.IkOptions()
        options.max_iterations = 60
        rng = np.random.default_rng(0)
        first = [] if q0 is None else [np.asarray(q0, dtype=float)]
        starts = [*first, self.home, *(rng.uniform(self.q_min, self.q_max) for _ in range(restarts))]
        best, nearest = None, math.inf
        for start in starts:
            q, result = self.ik_from(goal, start, options)
            miss = result.position_error + 0.05 * result.orientation_error
            if best is None or miss < nearest:
                best, nearest = (q, result), miss
            if result.converged:
                return q, result
        assert best is not None
        return best

    def link_poses(self, q: ArrayLike, jaw: float = 0.0) -> dict[str, Array]:
        """X_0link (4, 4) of every link at q (n,), drawn bars, jaws and grips included.

        jaw: opening of the jaws (PSM) or the grips (MTM), 0 = closed [rad].
        """
        q = np.asarray(q, dtype=float)
        poses = dict(zip(self.link_names, self.link_poses_array(q), strict=True))
        angle = dict(zip(self.joint_names, q, strict=True))
        for joint in self._drawn:
            turn = joint.multiplier * float(angle.get(joint.source, jaw))
            poses[joint.child] = poses[joint.parent] @ joint.X_parent @ _turn(joint.axis, turn)
        return poses

    def leader_options(self) -> _core.LeaderOptions:
        """What a simulated leader of this arm is made of: coupling, encoders, friction, rotors, drive limits."""
        data = self._hardware("coupling", "encoder_step_deg", "coulomb", "viscous", "rotor_inertia")
        options = _core.LeaderOptions()
        options.coupling = np.array(data["coupling"], dtype=float)
        options.encoder_step = np.radians(np.array(data["encoder_step_deg"], dtype=float))
        options.coulomb = np.array(data["coulomb"], dtype=float)
        options.viscous = np.array(data["viscous"], dtype=float)
        options.rotor_inertia = np.array(data["rotor_inertia"], dtype=float)
        options.tau_max = self.tau_max
        return options

    def follower_options(self) -> _core.FollowerOptions:
        """What a simulated follower of this arm is made of: speed limits and encoders."""
        data = self._hardware("encoder_step_deg")
        options = _core.FollowerOptions()
        options.v_max = self.v_max
        degrees = np.array(data["encoder_step_deg"], dtype=float)
        options.encoder_step = np.radians(degrees) + 1e-3 * np.array(data.get("encoder_step_mm", 0 * degrees))
        return options

    def _hardware(self, *keys: str) -> dict[str, Any]:
        missing = [key for key in keys if key not in self._data]
        if missing:
            raise ArmError(
                f"{self.name} does not say {', '.join(missing)}",
                why="its model file has no such entry",
                mend="add it to the model's YAML (models/mtm_right.yaml shows them all), or fill the options yourself",
            )
        return self._data


# ---------------------------------------------------------------- URDF: what is drawn
def _numbers(text: str | None, default: str) -> Array:
    return np.array([float(x) for x in (text or default).split()])


def _origin(element: ElementTree.Element | None) -> Array:
    X = np.eye(4)
    if element is None:
        return X
    roll, pitch, yaw = _numbers(element.get("rpy"), "0 0 0")
    X[:3, :3] = (
        _turn(np.array([0, 0, 1.0]), yaw) @ _turn(np.array([0, 1.0, 0]), pitch) @ _turn(np.array([1.0, 0, 0]), roll)
    )[:3, :3]
    X[:3, 3] = _numbers(element.get("xyz"), "0 0 0")
    return X


def _turn(axis: Array, angle: float) -> Array:
    """Rotation by `angle` about a unit axis, 4x4 (Rodrigues)."""
    x, y, z = axis
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    X = np.eye(4)
    X[:3, :3] += math.sin(angle) * K + (1 - math.cos(angle)) * (K @ K)
    return X


def _visuals(robot: ElementTree.Element) -> list[Visual]:
    colours: dict[str | None, tuple[float, ...]] = {
        m.get("name"): tuple(_numbers(c.get("rgba"), "0.7 0.7 0.7 1"))
        for m in robot.iter("material")
        if (c := m.find("color")) is not None
    }
    visuals = []
    for link in robot.findall("link"):
        for visual in link.findall("visual"):
            geometry = visual.find("geometry")
            shape = None if geometry is None else next(iter(geometry), None)
            if shape is None or shape.tag not in ("box", "cylinder", "sphere"):
                continue
            keys = {"box": ("size",), "cylinder": ("radius", "length"), "sphere": ("radius",)}[shape.tag]
            size = tuple(float(x) for key in keys for x in _numbers(shape.get(key), "0"))
            material = visual.find("material")
            r, g, b, a = colours.get(None if material is None else material.get("name"), (0.7, 0.7, 0.7, 1.0))
            visuals.append(Visual(link.get("name", ""), shape.tag, size, _origin(visual.find("origin")), (r, g, b, a)))
    return visuals


def _moving(robot: ElementTree.Element, chain: set[str]) -> list[ElementTree.Element]:
    """Joints that move but are not in the chain."""
    return [j for j in robot.findall("joint") if j.get("type") != "fixed" and j.get("name") not in chain]


def _drawn_joints(robot: ElementTree.Element, chain: set[str]) -> list[_DrawnJoint]:
    """In file order, parents before children. A joint without <mimic> turns with the jaw itself."""
    drawn = []
    for joint in _moving(robot, chain):
        parent, child, axis, mimic = (joint.find(tag) for tag in ("parent", "child", "axis", "mimic"))
        assert parent is not None
        assert child is not None
        name = joint.get("name", "")
        drawn.append(
            _DrawnJoint(
                name,
                parent.get("link", ""),
                child.get("link", ""),
                _origin(joint.find("origin")),
                _numbers(None if axis is None else axis.get("xyz"), "1 0 0"),
                name if mimic is None else mimic.get("joint", ""),
                1.0 if mimic is None else float(mimic.get("multiplier", "1")),
            )
        )
    return drawn


def _jaw_range(robot: ElementTree.Element, chain: set[str]) -> tuple[float, float]:
    """Limits of the joint that opens the jaws or the grips; (0, 0) when there is none."""
    for joint in _moving(robot, chain):
        limit = joint.find("limit")
        if joint.find("mimic") is None and limit is not None:
            return float(limit.get("lower", "0")), float(limit.get("upper", "0"))
    return 0.0, 0.0
