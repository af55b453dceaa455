"""The columns of a LeRobot data set by name: those of Open-H-Embodiment, or those of the dVRK's data collection."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.base.arrays import Array, so3
from palpate.export.episode import ArmOfEpisode, Episode
from palpate.export.frames import PEAKS, WRENCH

POSE = ("x", "y", "z", "qx", "qy", "qz", "qw")
_RENDERED = {"sensor": "rendered", "units": "N + N m"}
_AT_TIP = {**_RENDERED, "frame": "world, about the tool tip", "of": "environment on the instrument"}
_ON_HAND = {**_RENDERED, "frame": "base of the leader", "of": "device on the hand"}
_PEAK = {"window": "ticks after the frame before, up to this one"}


@dataclass(frozen=True)
class Column:
    """One feature of a data set."""

    values: NDArray[Any] | list[str]
    """(n, k) numbers, or n texts."""
    names: tuple[str, ...]
    """(k,)."""
    info: dict[str, str] = field(default_factory=dict)
    """Units, frame and origin."""

    @property
    def dtype(self) -> str:
        """Type of an element in LeRobot's words."""
        if isinstance(self.values, list):
            return "string"
        return "int64" if self.values.dtype.kind == "i" else "float32"

    @property
    def missing(self) -> bool:
        """True if no number was recorded."""
        return not isinstance(self.values, list) and self.dtype == "float32" and not np.isfinite(self.values).any()


def open_h(episode: Episode) -> dict[str, Column]:
    """The columns by the names of Open-H-Embodiment: poses absolute, arms one after the other."""
    n, arms = len(episode), episode.arms
    pose = {"units": "m, quaternion, rad", "frame": "base of the arm" if episode.foreign else "world"}
    joints = {"units": "rad, m"}
    tip = _AT_TIP | ({"frame": "base of the arm, about the tool tip"} if episode.foreign else {})
    found = {
        "observation.state": _each(arms, lambda a: (a.frames.pose, a.frames.jaw[:, :1]), (*POSE, "gripper"), pose),
        "action": _each(arms, lambda a: (a.frames.goal, a.frames.jaw[:, 1:]), (*POSE, "gripper"), pose),
        "observation.meta.joint_positions": _joints(arms, "q", joints),
        "observation.meta.joint_setpoints": _joints(arms, "q_goal", joints),
        "observation.meta.joint_positions.mtm": _leader(arms, joints),
        "observation.meta.force_torque": _each(arms, lambda a: (a.frames.wrench,), WRENCH, tip),
        "observation.meta.force_peak": _each(arms, lambda a: (a.frames.peaks,), PEAKS, tip | _PEAK),
        "observation.meta.force_torque.mtm": _each(arms, lambda a: (a.frames.hand,), WRENCH, _ON_HAND),
        "observation.meta.force_peak.mtm": _each(arms, lambda a: (a.frames.hand_peaks,), PEAKS, _ON_HAND | _PEAK),
        "observation.meta.contact": _each(
            arms, lambda a: (a.frames.contact,), ("depth", "touches", "nx", "ny", "nz"), {"units": "m, 1, 1"}
        ),
        **_bodies(episode),
        **{f"observation.meta.tool.{arm.name}": Column([arm.tool] * n, ("value",)) for arm in arms},
        "instruction.text": Column([episode.task] * n, ("value",)),
        **_stamps(episode, "observation.meta.host_stamp_ns"),
    }
    for arm in arms:
        for stream in (arm.name, arm.leader):
            if stream:
                found |= _stamps(episode, f"observation.meta.{stream}_stamp_ns")
    return _kept(episode, found)


def dvrk(episode: Episode) -> dict[str, Column]:
    """The columns by the names of the dVRK's data collection: joints, and topics with dots."""
    n, arms = len(episode), episode.arms
    axes = {"units": "rad, m"}
    found = {"observation.state": _joints(arms, "q", axes, True), "action": _joints(arms, "q_goal", axes, True)}
    for arm in arms:
        f, name, leader = arm.frames, f"ros.{arm.name.upper()}", f"ros.{arm.leader.upper()}"
        R = so3.matrices(f.pose[:, [6, 3, 4, 5]])
        body = np.concatenate([np.einsum("nji,nj->ni", R, f.wrench[:, k : k + 3]) for k in (0, 3)], axis=1)
        found |= {
            f"{name}.measured_cp": _column(f.pose, POSE, {"units": "m, quaternion"}),
            f"{name}.setpoint_cp": _column(f.goal, POSE, {"units": "m, quaternion"}),
            f"{name}.body.measured_cf": _column(body, WRENCH, _AT_TIP | {"frame": "tool"}),
            f"{leader}.measured_js": _column(f.q_leader[:, : len(arm.leader_joints)], arm.leader_joints, axes),
            f"{leader}.gripper.measured_js": _column(f.q_leader[:, -1:], ("gripper",), {"units": "rad"}),
            f"{leader}.spatial.servo_cf": _column(f.hand, WRENCH, _ON_HAND),
        }
    found |= {
        "observation.meta.force_peak": _each(arms, lambda a: (a.frames.peaks,), PEAKS, _AT_TIP | _PEAK),
        "observation.meta.force_peak.mtm": _each(arms, lambda a: (a.frames.hand_peaks,), PEAKS, _ON_HAND | _PEAK),
        **_bodies(episode),
        "stage_name": Column([episode.task] * n, ("value",)),
        **_stamps(episode, "timestamp_ns"),
    }
    return _kept(episode, found)


def _kept(episode: Episode, found: dict[str, Column]) -> dict[str, Column]:
    """The columns without those that a bag of other software does not hold, and without those of no joint."""
    needed = ("observation.state", "action")
    return {
        name: column for name, column in found.items()
        if name in needed or (column.names and not (episode.foreign and column.missing))
    }  # fmt: skip


def _column(values: Array, names: Iterable[str], info: dict[str, str]) -> Column:
    return Column(np.asarray(values, dtype=np.float32), tuple(names), info)


def _each(arms: tuple[ArmOfEpisode, ...], parts: Any, names: tuple[str, ...], info: dict[str, str]) -> Column:
    """The same columns of each arm, one arm after the other; names carry that of the arm if there are several."""
    values = np.concatenate([part for arm in arms for part in parts(arm)], axis=1)
    named = names if len(arms) == 1 else tuple(f"{arm.name}.{name}" for arm in arms for name in names)
    return _column(values, named, info)


def _bodies(episode: Episode) -> dict[str, Column]:
    """Poses of the rigid bodies, by the name that LeRobot gives to the state of the environment."""
    if episode.places is None:
        return {}
    places = episode.places[..., [0, 1, 2, 4, 5, 6, 3]].reshape(len(episode), -1)
    names = [f"{body}.{name}" for body in episode.bodies for name in POSE]
    return {"observation.environment_state": _column(places, names, {"units": "m, quaternion", "frame": "world"})}


def _joints(arms: tuple[ArmOfEpisode, ...], which: str, info: dict[str, str], numbered: bool = False) -> Column:
    """Joints and jaw of each arm; `numbered` names them joint_0, joint_1 ..."""
    values, names = [], []
    for arm in arms:
        own = [f"joint_{k}" for k in range(len(arm.joints))] if numbered else list(arm.joints)
        jaw = arm.frames.jaw[:, 1 if which == "q_goal" else 0, None]
        values += [getattr(arm.frames, which)[:, : len(own)], jaw]
        names += [name if len(arms) == 1 else f"{arm.name}.{name}" for name in (*own, "jaw")]
    return _column(np.concatenate(values, axis=1), names, info)


def _leader(arms: tuple[ArmOfEpisode, ...], info: dict[str, str]) -> Column:
    values, names = [], []
    for arm in arms:
        if arm.leader_joints:
            values += [arm.frames.q_leader[:, : len(arm.leader_joints)], arm.frames.q_leader[:, -1:]]
            own = (*arm.leader_joints, "gripper")
            names += [name if len(arms) == 1 else f"{arm.leader}.{name}" for name in own]
    return _column(np.concatenate(values, axis=1) if values else np.zeros((len(arms[0].frames), 0)), names, info)


def _stamps(episode: Episode, name: str) -> dict[str, Column]:
    return {name: Column(episode.stamps[:, None], ("ns",), {"units": "ns"})}


NAMINGS = {"openh": open_h, "dvrk": dvrk}
