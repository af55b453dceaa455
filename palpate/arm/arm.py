"""Arms: the da Vinci master arm (MTM) and patient-side arm (PSM), or an arm of your own (docs/arms.md).

    arm = palpate.Arm.mtm("right")          # or palpate.Arm.load("my_arm.yaml")
    X_LH = arm.fk(arm.home)                 # pose of the handle in the arm's base, 4x4
    q = arm.ik(X_LH)                        # inverse kinematics

The parameters of the arms (kinematics, limits, masses, encoders, friction) are in `models/`, each with its source.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterator
from copy import deepcopy
from functools import cache, cached_property
from pathlib import Path
from typing import Self, cast
from xml.etree import ElementTree

import numpy as np
import yaml
from numpy.typing import ArrayLike, NDArray

from palpate import _core
from palpate.arm.shapes import DrawnJoint, Visual, drawn_joints, jaw_range, sticks, turn_about, visuals
from palpate.base import limits
from palpate.base.arrays import Array
from palpate.base.arrays.plain import Content
from palpate.base.arrays.yaml_loader import OwnLoader, read_yaml
from palpate.base.errors import ArmError

SIDES = ("right", "left")
INSTRUMENTS = ("lnd", "prograsp")

#: Models that come with Palpate, `models/NAME.yaml`. Each may be used as a leader or as a follower.
NAMES = (*(f"mtm_{side}" for side in SIDES), *(f"psm_{tool}" for tool in INSTRUMENTS), "six_axis", "delta")

#: Keys of a model file. Lists have one number per joint.
KEYS = {
    "name": "name of the arm in messages and plots",
    "urdf": "URDF of a serial arm, relative to this file",
    "base_frame": "root link of the URDF; default: its root",
    "tip_frame": "link of the handle or the tool; default: the end of the longest chain",
    "device": "instead of a URDF: a device with closed-form kinematics, e.g. delta",
    "parameters": "parameters of the device",
    "home": "joint positions at rest [rad, m]; default: the middle of the limits",
    "counterbalance": "a spring: {torque: N m, along: [..]}; default: none",
    "coupling": "matrix A of q_joint = A q_motor; default: identity",
    "encoder_step_deg": "encoder resolution on the motor side [deg]; default: ideal",
    "encoder_step_mm": "encoder resolution of prismatic joints [mm]; default: ideal",
    "coulomb": "Coulomb friction [N m, N]; default: none",
    "viscous": "viscous friction [N m s/rad, N s/m]; default: none",
    "rotor_inertia": "rotor inertia reflected to the joint [kg m^2, kg]; default: none",
    "platform": "true: joint 4 is an MTM's platform, which has its own controller",
    "remote_centre": "true: the base frame is at the remote centre of motion (the body wall)",
    "tool_type": "number of the instrument, as the arm announces it after a colon on tool_type",
    "jaw_tip": "distance from the tip to the end of the jaws [m]",
    "spheres": "contact spheres in addition to the tip's: [{link: name, at: [x, y, z], radius: m}, ..]",
    "capsules": "the instrument as others touch it: [{link: name, from: [x, y, z], to: [x, y, z], radius: m}, ..]",
}
_PER_JOINT = ("home", "encoder_step_deg", "encoder_step_mm", "coulomb", "viscous", "rotor_inertia")


def models_folder() -> Path:
    """Folder of the arms' files: in the installed package, or `models/` of the repository."""
    here = Path(__file__).resolve().parents[1]
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
    """An arm in its base frame: kinematics, dynamics, limits and appearance.

    Joint vectors have shape (n,) in rad (prismatic joints: m); poses are 4x4; X_0T is the tip in the base. Methods of
    the compiled class (`fk`, `jacobian`, `gravity`, `bias`, `inverse_dynamics`, `mass_matrix`, ...) raise ValueError
    naming the argument and both shapes. One object holds one workspace: do not share it between threads.
    """

    name: str
    home: Array
    urdf: str
    """Text of its URDF; empty for a device without a URDF."""
    folder: Path | None
    """Folder of its URDF, to which names of mesh files are relative; None for a URDF that is given as text."""
    frames: tuple[str, str]
    """Base and tip frame of the URDF; empty names for a device without a URDF."""
    jaw_range: tuple[float, float]

    def __init__(self, xml: str, base_frame: str, tip_frame: str, data: Content | None = None) -> None:
        """Build from the text of a URDF; `data` holds the further values of a model file (`KEYS`)."""
        super().__init__(xml, base_frame, tip_frame)
        robot = ElementTree.fromstring(xml)
        chain = set(self.joint_names)
        self.urdf, self.folder = xml, None
        self.frames = (base_frame, tip_frame)
        self._drawn = drawn_joints(robot, chain)
        self.jaw_range = jaw_range(robot, chain)
        self._describe(data or {}, robot.get("name", "arm"))

    @classmethod
    def device(cls, kind: str, parameters: dict[str, float], data: Content | None = None) -> Self:
        """A device with closed-form kinematics (docs/arms.md), e.g. `Arm.device("delta", {"upper": 0.1, ...})`.

        Raises:
            ArmError: a parameter is missing, wrong or unknown; the message names it.
        """
        arm = cls.__new__(cls)
        try:
            numbers = {
                name: np.atleast_1d(np.asarray(value, dtype=float)).tolist() for name, value in parameters.items()
            }
            _core.Arm.__init__(arm, kind, numbers)
        except (RuntimeError, TypeError, ValueError) as error:
            raise ArmError(str(error), mend="docs/arms.md lists the parameters") from None
        arm.urdf, arm.folder, arm.frames = "", None, ("", "")
        arm._drawn, arm.jaw_range = [], (0.0, 0.0)
        arm._describe(data or {}, kind)
        return arm

    @property
    def tool_type(self) -> str:
        """Number of the instrument, as an arm announces it; empty if the model names none."""
        return str(self._data.get("tool_type", ""))

    @cached_property
    def visuals(self) -> list[Visual]:
        """Boxes, cylinders and spheres of the links; sticks between the joints where the URDF has none."""
        return self.drawn or sticks(self.segments)

    @cached_property
    def drawn(self) -> list[Visual]:
        """Boxes, cylinders and spheres that the URDF draws as <visual>."""
        return visuals(ElementTree.fromstring(self.urdf)) if self.urdf else []

    def _describe(self, data: Content, name: str) -> None:
        self._data = data
        self.name = str(data.get("name", name))
        for key in _PER_JOINT:
            if key in data and np.shape(data[key]) != (self.n,):
                raise ArmError(
                    f"{self.name}: {key} needs {self.n} numbers, one per joint",
                    why=f"it has the shape {np.shape(data[key])}",
                    mend=f"the joints are {', '.join(self.joint_names)}",
                )
        self.home = np.asarray(data.get("home", 0.5 * (self.q_min + self.q_max)), dtype=float)
        for joint, q, low, high in zip(self.joint_names, self.home, self.q_min, self.q_max, strict=True):
            if not low <= q <= high:
                raise ArmError(
                    f"{self.name}: home puts {joint} at {q:g}, outside its limits {low:g} to {high:g}",
                    mend="choose home within the limits",
                )
        spring = data.get("counterbalance")
        if spring is not None:
            self.set_counterbalance(float(spring["torque"]), np.asarray(spring["along"], dtype=float))

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """An arm from a model file (docs/arms.md; `models/*.yaml` are examples).

        Raises:
            ArmError: the file or its URDF is not valid; the message names the file, the fault and the remedy.
        """
        path = Path(path)
        data = _read(path)
        try:
            return cls._of(data, path)
        except ArmError:
            raise
        except (AttributeError, IndexError, KeyError, TypeError, ValueError) as error:
            why = f"{error} is missing" if isinstance(error, KeyError) else str(error)
            mend = "docs/arms.md shows each key with its value"
            raise ArmError("a value of the model file is not valid", where=str(path), why=why, mend=mend) from None

    @classmethod
    def _of(cls, data: Content, path: Path) -> Self:
        """The arm of the model file `path` with the keys `data`."""
        if "device" in data:
            data.setdefault("name", path.stem)
            return cls.device(str(data["device"]), dict(data.get("parameters") or {}), data)
        if "urdf" not in data:
            raise ArmError("no arm is named", where=str(path), mend="give urdf: my_arm.urdf, or device: delta")
        urdf = path.parent / str(data["urdf"])
        try:
            xml = limits.read_text(urdf)
            base, tip = _ends(xml)
            arm = cls(xml, str(data.get("base_frame", base)), str(data.get("tip_frame", tip)), data)
            arm.folder = urdf.parent.resolve()
            return arm
        except OSError as error:
            raise ArmError(
                "the arm's URDF cannot be read", where=str(urdf), why=str(error), mend=f"urdf: in {path.name}"
            ) from None
        except (RuntimeError, UnicodeDecodeError, ElementTree.ParseError) as error:
            raise ArmError(str(error), where=str(urdf), mend=f"mend the URDF, or {path.name}") from None

    @classmethod
    def model(cls, name: str, folder: str | Path = ".") -> Self:
        """An arm by the name of a model in `NAMES`, or by the path of a model file, relative to `folder`."""
        return cls.load(models_folder() / f"{name}.yaml" if name in NAMES else Path(folder) / name)

    @classmethod
    def mtm(cls, side: str) -> Self:
        """The da Vinci master arm, `side` "right" or "left": 7 joints, base L (z up), tip H at the wrist centre."""
        return cls._named("mtm", side, SIDES, "master arm")

    @classmethod
    def psm(cls, instrument: str = "lnd") -> Self:
        """The da Vinci patient-side arm with an instrument: "lnd", the large needle driver, or "prograsp".

        6 joints and a jaw; base B at the remote centre of motion, tip T on the wrist's yaw axis, z along the jaws.
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
        """Joint positions (n,) within the limits that place the tip at X_0T (4, 4); near `q0` if given.

        Raises:
            ArmError: no start converges to 1e-8 m and 1e-8 rad; the message names the smallest error found.
        """
        goal = np.asarray(X_0T, dtype=float)
        q, best = self.ik_nearest(goal, q0, restarts=restarts)
        if best.converged:
            return q
        p = ", ".join(f"{1e3 * x:.1f}" for x in goal[:3, 3])
        raise ArmError(
            f"{self.name} cannot reach the tip pose at ({p}) mm in its base frame",
            why=f"the nearest pose found is {1e3 * best.position_error:.2f} mm and "
            f"{math.degrees(best.orientation_error):.2f} degrees away, within its joint limits",
            mend="move the arm's base or the goal, or turn the goal",
        )

    def ik_nearest(
        self, X_0T: ArrayLike, q0: ArrayLike | None = None, *, restarts: int = 64
    ) -> tuple[Array, _core.IkResult]:
        """Joint positions (n,) whose tip is nearest to X_0T (4, 4), and the result of the search (`converged`, errors).

        The search starts from `q0` if given, from home, then from `restarts` random positions with a fixed seed.
        The distance of a pose is its position error plus 0.05 m per rad of orientation error.
        """
        goal = np.asarray(X_0T, dtype=float)
        options = _core.IkOptions()
        options.max_iterations = 60
        best, nearest = None, math.inf
        for start in self._starts(q0, restarts):
            q, result = self.ik_from(goal, start, options)
            miss = result.position_error + 0.05 * result.orientation_error
            if best is None or miss < nearest:
                best, nearest = (q, result), miss
            if result.converged:
                return q, result
        assert best is not None
        return best

    def _starts(self, q0: ArrayLike | None, restarts: int) -> Iterator[Array]:
        """Start positions of the inverse kinematics; most searches converge from the first."""
        if q0 is not None:
            yield np.asarray(q0, dtype=float)
        yield self.home
        rng = np.random.default_rng(0)
        for _ in range(restarts):
            yield rng.uniform(self.q_min, self.q_max)

    def link_poses(self, q: ArrayLike, jaw: ArrayLike = 0.0) -> dict[str, Array]:
        """Poses X_0link (..., 4, 4) of every link at q (..., n), including the drawn links (bars, jaws, grips).

        jaw: opening angle (...) of the jaws (PSM) or the grips (MTM), 0 = closed [rad].
        """
        q = np.asarray(q, dtype=float)
        links = self.link_poses_array(q.reshape(-1, self.n)).reshape(*q.shape[:-1], len(self.link_names), 4, 4)
        poses = dict(zip(self.link_names, np.moveaxis(links, -3, 0), strict=True))
        angle = dict(zip(self.joint_names, np.moveaxis(q, -1, 0), strict=True))
        for joint in self._drawn:
            turn = joint.multiplier * np.asarray(angle.get(joint.source, jaw))
            poses[joint.child] = poses[joint.parent] @ joint.X_parent @ turn_about(joint.axis, turn)
        return poses

    def drawn_joint(self, child: str) -> DrawnJoint | None:
        """The joint that moves a link outside the kinematic chain, such as a jaw; None for other links."""
        return next((joint for joint in self._drawn if joint.child == child), None)

    @property
    def spheres(self) -> list[Content]:
        """Contact spheres in addition to the tip's, as in the model file (`KEYS`)."""
        return list(self._data.get("spheres", []))

    @property
    def capsules(self) -> list[Content]:
        """The instrument as other instruments touch it, as in the model file (`KEYS`)."""
        return list(self._data.get("capsules", []))

    def leader_options(self) -> _core.LeaderOptions:
        """Options of a simulated leader: coupling, encoders, friction, rotors and drive limits.

        Raises:
            ArmError: a joint has no inertia, or its drive has no limit.
        """
        options = _core.LeaderOptions()
        options.coupling = np.array(self._data.get("coupling", np.eye(self.n)), dtype=float)
        options.encoder_step = self._encoder_step()
        options.coulomb = self._per_joint("coulomb")
        options.viscous = self._per_joint("viscous")
        options.rotor_inertia = self._per_joint("rotor_inertia")
        options.tau_max = self.tau_max
        self._require(self.mass_matrix(self.home).diagonal() + options.rotor_inertia > 1e-9, "moves no mass",
                      "give its links an <inertial>, or rotor_inertia in the model file")  # fmt: skip
        self._require(options.tau_max > 0.0, "has no drive limit",
                      "give it <limit effort=...> in the URDF")  # fmt: skip
        return options

    def follower_options(self) -> _core.FollowerOptions:
        """Options of a simulated follower: speed limits, encoders, and drives if it is driven by torques.

        Raises:
            ArmError: a joint has no speed limit.
        """
        options = _core.FollowerOptions()
        options.v_max = self.v_max
        options.encoder_step = self._encoder_step()
        drives = options.drives
        drives.coulomb, drives.viscous = self._per_joint("coulomb"), self._per_joint("viscous")
        drives.rotor_inertia = self._per_joint("rotor_inertia")
        options.drives = drives
        self._require(options.v_max > 0.0, "has no speed limit", "give it <limit velocity=...> in the URDF")
        return options

    @property
    def has_platform(self) -> bool:
        """True if joint 4 is an MTM's platform, which has its own controller."""
        return bool(self._data.get("platform", False))

    @property
    def has_remote_centre(self) -> bool:
        """True if the base frame is at the remote centre of motion."""
        return bool(self._data.get("remote_centre", False))

    def _per_joint(self, key: str) -> Array:
        return np.array(self._data.get(key, np.zeros(self.n)), dtype=float)

    def _encoder_step(self) -> Array:
        return np.radians(self._per_joint("encoder_step_deg")) + 1e-3 * self._per_joint("encoder_step_mm")

    def _require(self, satisfied: NDArray[np.bool_], fault: str, mend: str) -> None:
        for joint, valid in zip(self.joint_names, satisfied, strict=True):
            if not valid:
                raise ArmError(f"{self.name}: joint {joint!r} {fault}", mend=mend)


@cache
def _own(path: Path, changed: int) -> Content:
    """Values of one of our own model files; `changed`: when the file was changed, so that an edit is seen."""
    return cast(Content, yaml.load(limits.read_text(path), OwnLoader))


def _read(path: Path) -> Content:
    """Read a model file and check its keys."""
    try:
        own = path.parent == models_folder()
        data = deepcopy(_own(path, path.stat().st_mtime_ns)) if own else read_yaml(path)
    except (OSError, UnicodeDecodeError) as error:
        mend = f"models that come with Palpate: {', '.join(NAMES)}"
        raise ArmError("the arm's model file cannot be read", where=str(path), why=str(error), mend=mend) from None
    except yaml.YAMLError as error:
        raise ArmError("not valid YAML", where=str(path), why=" ".join(str(error).split())) from None
    if not isinstance(data, dict):
        raise ArmError("a model file is a mapping", where=str(path), mend="begin with: urdf: my_arm.urdf")
    for key in data:
        if key not in KEYS:
            near = difflib.get_close_matches(str(key), KEYS, n=1)
            mend = f"did you mean {near[0]!r}?" if near else f"the keys are: {', '.join(KEYS)}"
            raise ArmError(f"unknown key {key!r}", where=str(path), mend=mend)
    return data


def _ends(xml: str) -> tuple[str, str]:
    """Root link of a URDF, and the link at the end of its longest chain."""
    parent: dict[str, str] = {}
    robot = ElementTree.fromstring(xml)
    for joint in robot.findall("joint"):
        above, below = joint.find("parent"), joint.find("child")
        if above is not None and below is not None:
            parent[below.get("link", "")] = above.get("link", "")
    links = [link.get("name", "") for link in robot.findall("link")]

    def depth(link: str) -> int:
        seen = [link]
        while seen[-1] in parent and parent[seen[-1]] not in seen:
            seen.append(parent[seen[-1]])
        return len(seen)

    roots = [link for link in links if link not in parent]
    return (roots[0] if roots else ""), max(links, key=depth, default="")
