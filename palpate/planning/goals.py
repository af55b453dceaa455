"""Starts and goals of a motion: joint positions, poses of the tip, names, files."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from palpate import _core
from palpate.arm import Arm
from palpate.base.arrays import Array
from palpate.base.arrays.so3 import matrices
from palpate.base.arrays.yaml_loader import read_yaml
from palpate.base.errors import PlanningError
from palpate.base.values.units import convert
from palpate.planning.kinematics import pose_of

_RESTARTS = 24  # random starts of the inverse kinematics
_SAME = 1e-3  # solutions nearer than this in all joints are one [rad, m]
_AT_LIMIT = 1e-4  # a joint this near to its limit is at it [rad, m]


@dataclass(frozen=True)
class Unreachable:
    """Why no joint positions reach a pose."""

    reason: str


def read(value: Any, arm: Arm, states: dict[str, Array], what: str) -> Array:
    """Joint positions (n,) or a pose X_WT (4, 4), from numbers, text or a file.

    Text is ``joints:q1,q2,...`` [rad, m], ``pose:x,y,z,roll,pitch,yaw`` [m, deg], a name in `states`, or the path of a
    YAML or JSON file with ``joints: [...]``, ``pose: {xyz: [...], rpy_deg: [...]}`` or ``pose`` as (4, 4).

    Raises:
        PlanningError: the value cannot be understood; the message says what is possible.
    """
    if isinstance(value, Path) or (isinstance(value, str) and value not in states and _is_file(value)):
        value = _from_file(Path(value), what)
    if isinstance(value, str):
        value = _from_text(value, states, what)
    if isinstance(value, dict):
        value = _from_keys(value, what)
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        array = np.empty(0)
    if array.shape == (4, 4) and np.isfinite(array).all():
        return _require_pose(array, what)
    if array.shape != (arm.n,) or not np.isfinite(array).all():
        raise PlanningError(
            f"the {what} must be {arm.n} joint positions or a (4, 4) pose. Got: {value!r:.80}",
            mend=f"the joints are {', '.join(arm.joint_names)} [rad, m]",
        )
    for name, q, low, high in zip(arm.joint_names, array, arm.q_min, arm.q_max, strict=True):
        if not low - 1e-9 <= q <= high + 1e-9:
            why = f"its limits are {low:g} to {high:g}"
            raise PlanningError(f"the {what} puts {name} at {q:g}", why=why, mend="choose a value within the limits")
    return array


def _is_file(text: str) -> bool:
    return Path(text).suffix.lower() in (".yaml", ".yml", ".json") or Path(text).is_file()


def _from_file(path: Path, what: str) -> Any:
    try:
        data = read_yaml(path)
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise PlanningError(f"the file of the {what} cannot be read", where=str(path), why=str(error)) from None
    return data if isinstance(data, (dict, list)) else {}


def _from_text(text: str, states: dict[str, Array], what: str) -> Any:
    if text in states:
        return states[text]
    kind, colon, rest = text.partition(":")
    try:
        numbers = [float(x) for x in rest.replace(",", " ").split()]
    except ValueError:
        numbers = []
    if colon and kind == "joints" and numbers:
        return numbers
    if colon and kind == "pose" and len(numbers) in (3, 6):
        return pose_of(np.array(numbers[:3]), np.radians([*numbers[3:], 0, 0, 0][:3]))
    raise PlanningError(
        f"the {what} {text!r} is not understood",
        mend=f"a name ({', '.join(states)}), joints:q1,q2,... or pose:x,y,z,roll,pitch,yaw, or a YAML file",
    )


def _from_keys(data: dict[str, Any], what: str) -> Any:
    value: Any = data.get("joints")
    if "places" in data:  # recorded by a pedal: the first is the start
        rows = places(data, what)
        value = rows[0] if what == "start" else rows[-1]
    if "pose" in data:
        value = data["pose"]
        if isinstance(value, dict) and "xyz" in value:
            turn = value.get("rpy_deg", [0, 0, 0])
            try:
                X = pose_of(np.asarray(value["xyz"], dtype=float), np.radians(np.asarray(turn, dtype=float)))
                if "quaternion" in value:
                    X[:3, :3] = matrices(np.asarray(value["quaternion"], dtype=float)[None])[0]
                value = X
            except (TypeError, ValueError, IndexError):
                value = None
    if value is None:
        raise PlanningError(f"the {what} has neither joints nor pose", mend="write joints: [...] or pose: {xyz: [...]}")
    if np.ndim(value) == 2 and np.shape(value) != (4, 4):
        value = value[-1]  # a plan file: its end
    return value


def places(data: dict[str, Any], what: str = "file") -> list[Any]:
    """Joint positions of all places of a file that was recorded by a pedal.

    Raises:
        PlanningError: the file holds no place.
    """
    rows = [one.get("joints") for one in data.get("places") or [] if isinstance(one, dict)]
    if not rows or any(row is None for row in rows):
        raise PlanningError(
            f"the {what} has no recorded place", mend="press the pedal: palpate run --record-places FILE"
        )
    return rows


def read_places(path: Path) -> list[Any]:
    """All places of a file; raises as `places`."""
    return places(_from_file(path, "file of places"), "file of places")


def _require_pose(X: Array, what: str) -> Array:
    R = X[:3, :3]
    if np.abs(R @ R.T - np.eye(3)).max() > 1e-6 or np.linalg.det(R) < 0.0:
        raise PlanningError(f"the rotation of the {what} is not a rotation matrix", mend="give R with R R^T = I, det 1")
    return X


def solutions(arm: Arm, X_BT: Array, near: Array, seed: int = 0) -> list[Array] | Unreachable:
    """Joint positions (n,) that place the tip at X_BT (4, 4), the nearest to `near` (n,) first.

    The search starts from `near`, from home and from random positions; joints that turn further than a full circle
    give further solutions.
    """
    rng = np.random.default_rng(seed)
    starts = [near, arm.home, *(rng.uniform(arm.q_min, arm.q_max) for _ in range(_RESTARTS))]
    options = _core.IkOptions()
    options.max_iterations = 60
    found: list[Array] = []
    best, best_q = math.inf, arm.home
    last = None
    for q0 in starts:
        q, result = arm.ik_from(X_BT, q0, options)
        miss = result.position_error + 0.05 * result.orientation_error
        if miss < best:
            best, best_q, last = miss, q, result
        if result.converged:
            found += [q for q in _turned(arm, q) if not any(np.abs(q - p).max() < _SAME for p in found)]
    if found:
        return sorted(found, key=lambda q: float(np.abs(q - near).max()))
    assert last is not None
    return Unreachable(_why(arm, best_q, last))


def _turned(arm: Arm, q: Array) -> list[Array]:
    """q, and q with joints turned by a full circle within their limits."""
    variants = [q]
    for i in np.nonzero(arm.q_max - arm.q_min > 2.0 * np.pi)[0]:
        for turn in (-2.0 * np.pi, 2.0 * np.pi):
            if arm.q_min[i] <= q[i] + turn <= arm.q_max[i]:
                other = q.copy()
                other[i] += turn
                variants.append(other)
    return variants


def _why(arm: Arm, q: Array, result: _core.IkResult) -> str:
    """The limits at which the nearest reachable position stops, and how far it is from the goal."""
    stops = []
    for name, value, low, high in zip(arm.joint_names, q, arm.q_min, arm.q_max, strict=True):
        for limit, side in ((low, "lower"), (high, "upper")):
            if abs(value - limit) < _AT_LIMIT:
                stops.append(f"{name} is at its {side} limit {limit:g}")
    away = f"{1e3 * result.position_error:.1f} mm and {math.degrees(result.orientation_error):.1f} deg away"
    return f"unreachable: {'; '.join(stops) or 'no joint is at a limit'}; the nearest pose is {away}"


def length(text: str | None, name: str) -> float | None:
    """A length as it is written on the command line, such as 3mm or 0.003 [m]; None if it was left out.

    Raises:
        PlanningError: the text is no length.
    """
    if text is None:
        return None
    value = convert(text, "m")
    if value is None:
        try:
            value = float(text)
        except ValueError:
            raise PlanningError(f"{name} {text!r} is not a length", mend="write e.g. 3mm") from None
    return value
