"""A motion plan: what was found, with its clearance and times; as a file, and as it is read back."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from palpate.arm import Arm
from palpate.base.arrays import Array
from palpate.base.arrays.plain import plain
from palpate.base.arrays.so3 import quaternions
from palpate.base.arrays.yaml_loader import MOST_OF_PLAN, Dumper, read_yaml
from palpate.base.errors import OutputError, PlanningError
from palpate.planning.curves import Curve
from palpate.planning.timing import Limits, Trajectory

KIND = "palpate plan 1"
_RATE = 100.0  # of the joint positions in a plan and its file [Hz]
_SPACING = 5e-4  # of the tip's positions in a plan file [m]


@dataclass(frozen=True)
class Clearance:
    """Distance from the obstacles along a plan."""

    t: Array  # (K,) [s]
    distance: Array  # (K,) [m]
    pairs: list[tuple[str, str]]  # nearest pair at each time
    minimum: float  # [m]; infinite without obstacles
    nearest: tuple[str, str]  # pair that comes nearest
    at_t: float  # time at which it does [s]
    p_W: Array  # (3,) place on the obstacle where it does [m]


@dataclass(frozen=True)
class Plan:
    """The result of a search for a motion.

    `success` is False with a `reason`: unreachable, or no path found. The path of a successful plan is a sequence of
    curves whose whole course is proved to keep the clearance asked for.
    """

    success: bool
    reason: str  #: empty if a motion was found
    arm: str  #: name of the arm
    time_s: float  #: time of the search, checks and times [s]
    clearance_asked: float  #: [m]
    seed: int
    planner: str  #: OMPL's planner, or "straight line" where no search was needed
    world_version: str  #: version of the scene for which the plan was made
    joint_names: tuple[str, ...] = ()
    curves: tuple[Curve, ...] = ()
    scale: Array = field(default_factory=lambda: np.zeros(0))
    limits: Limits | None = None
    clearance: Clearance | None = None
    geometry: str = ""  #: collision geometry of the arm: capsules or meshes
    notes: tuple[str, ...] = ()
    blocker: tuple[str, str] = ("", "")  #: without success: the pair that blocked most motions
    X_WB: Array = field(default_factory=lambda: np.eye(4))
    scene: str = ""  #: file of the scene for which the plan was made, or its name; empty if it has none
    jaw: tuple[float, float] = (0.0, 0.0)  #: smallest and largest angle of the jaws for which it is proved [rad]
    from_file: bool = False  #: read from a file, which may have been changed: `sound.require_sound` checks it

    @cached_property
    def trajectory(self) -> Trajectory:
        """The path with times.

        Raises:
            PlanningError: no motion was found.
        """
        if self.limits is None or not self.curves:
            raise PlanningError("the plan has no motion", why=self.reason, mend="plan again")
        return Trajectory(list(self.curves), self.scale, self.limits)

    @property
    def duration_s(self) -> float:
        """Duration of the motion [s]."""
        return self.trajectory.duration if self.success else 0.0

    @property
    def clearance_m(self) -> float | None:
        """Smallest distance from all obstacles along the motion [m]; None without a motion or obstacles."""
        found = self.clearance
        return None if found is None or not np.isfinite(found.minimum) else found.minimum

    @property
    def nearest(self) -> tuple[str, str]:
        """The pair that comes nearest; without success, the pair that blocks."""
        return self.blocker if self.clearance is None else self.clearance.nearest

    @cached_property
    def _sampled(self) -> tuple[Array, Array]:
        return self.trajectory.sampled(_RATE) if self.success else (np.zeros(0), np.zeros((0, 0)))

    @property
    def t(self) -> Array:
        """Times (N,) of `joints` [s]."""
        return self._sampled[0]

    @property
    def joints(self) -> Array:
        """Joint positions (N, n) at the times `t` [rad, m]."""
        return self._sampled[1]

    def as_json(self) -> dict[str, Any]:
        """The values of `palpate plan --json` (docs/json/plan.md)."""
        clearance = self.clearance
        return {
            "success": self.success, "reason": self.reason, "arm": self.arm, "time_s": self.time_s,
            "duration_s": self.duration_s, "clearance_m": self.clearance_m, "clearance_asked_m": self.clearance_asked,
            "nearest": list(self.nearest), "nearest_t": None if clearance is None else clearance.at_t,
            "nearest_place": None if clearance is None else clearance.p_W, "planner": self.planner, "seed": self.seed,
            "geometry": self.geometry, "scene_version": self.world_version, "notes": list(self.notes),
            "jaw_rad": list(self.jaw),
            "joint_names": list(self.joint_names), "joints": self.joints, "t": self.t,
        }  # fmt: skip

    def save(self, path: Path, arm: Arm) -> None:
        """Write the plan as YAML: its curves and limits, from which `load` makes the same motion, and the tip's path.

        Raises:
            OutputError: the file cannot be written. PlanningError: the plan has no motion.
        """
        limits = self.trajectory.limits
        assert self.clearance is not None
        X_WT = tip_path(self, arm, _SPACING)
        data = {
            "kind": KIND, "scene": self.scene, "scene_version": self.world_version, "arm": self.arm,
            "joint_names": list(self.joint_names), "planner": self.planner, "seed": self.seed,
            "geometry": self.geometry, "jaw_rad": list(self.jaw), "time_s": self.time_s,
            "duration_s": self.duration_s, "clearance_asked_m": self.clearance_asked, "clearance_m": self.clearance_m,
            "nearest": list(self.nearest), "scale": self.scale, "v_max": limits.v, "a_max": limits.a, "j_max": limits.j,
            "X_WB": self.X_WB, "curves": [curve.controls for curve in self.curves], "t": self.t, "joints": self.joints,
            "tip_xyz_m": X_WT[:, :3, 3], "tip_wxyz": quaternions(X_WT[:, :3, :3], canonical=True),
        }  # fmt: skip
        text = yaml.dump(plain(data), sort_keys=False, default_flow_style=None, width=200, Dumper=Dumper)
        try:
            path.write_text(text, encoding="utf-8")
        except OSError as error:
            raise OutputError("the plan cannot be written", where=str(path), why=str(error)) from None


def load(path: Path) -> Plan:
    """A plan from its file.

    Raises:
        PlanningError: the file cannot be read, or is no plan.
    """
    try:
        data = read_yaml(path, MOST_OF_PLAN)
        if not isinstance(data, dict) or data.get("kind") != KIND:
            raise PlanningError("the file is not a plan", where=str(path), mend="palpate plan SCENE ... --out FILE")
        curves = tuple(Curve(np.array(controls, dtype=float)) for controls in data["curves"])
        limits = Limits(*(np.array(data[key], dtype=float) for key in ("v_max", "a_max", "j_max")))
        n, (low, high) = len(data["joint_names"]), data.get("jaw_rad", (0.0, 0.0))
        if not curves or any(c.controls.ndim != 2 or c.controls.shape[1] != n for c in curves):
            raise ValueError(f"its curves do not have {n} joints")
        if not all(np.isfinite(c.controls).all() for c in curves):
            raise ValueError("a joint position is not finite")
        return Plan(
            True, "", str(data["arm"]), float(data["time_s"]), float(data["clearance_asked_m"]), int(data["seed"]),
            str(data["planner"]), str(data["scene_version"]), tuple(data["joint_names"]), curves,
            np.array(data["scale"], dtype=float), limits, geometry=str(data["geometry"]),
            X_WB=np.array(data["X_WB"], dtype=float), scene=str(data.get("scene", "")), jaw=(float(low), float(high)),
            from_file=True,
        )  # fmt: skip
    except (OSError, UnicodeDecodeError, yaml.YAMLError, KeyError, TypeError, ValueError) as error:
        if isinstance(error, PlanningError):
            raise
        raise PlanningError("the plan cannot be read", where=str(path), why=str(error), mend="plan again") from None


def tip_path(plan: Plan, arm: Arm, spacing: float) -> Array:
    """Poses X_WT (k, 4, 4) of the tip along the path of a plan, at most `spacing` [m] apart."""
    rows: list[Array] = []
    for curve in plan.curves:
        coarse = np.array([arm.fk(q)[:3, 3] for q in curve.at(np.linspace(0.0, 1.0, 9))])
        count = max(2, int(np.ceil(1.5 * np.linalg.norm(np.diff(coarse, axis=0), axis=1).sum() / spacing)))
        rows += list(curve.at(np.linspace(0.0, 1.0, count, endpoint=False)))
    rows.append(plan.curves[-1].controls[-1])
    return np.array([plan.X_WB @ arm.fk(q) for q in rows])
