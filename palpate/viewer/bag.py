"""Converts a bag to the ticks of a run for the viewer. Signals that the bag does not contain stay zero."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from palpate.arm import Arm
from palpate.base.arrays import Array
from palpate.base.arrays.so3 import matrices, quaternions
from palpate.base.errors import PalpateError, RecordError
from palpate.record.bags.bag import Bag
from palpate.record.bags.tracks import ArmTracks, Track
from palpate.record.ticks import TICK, Ticks
from palpate.scene.rig import build
from palpate.scene.scene import Scene
from palpate.viewer.stage import ArmPlace, Stage
from palpate.viewer.staging import stage_of

MOST_RATE = 1000.0
"""Highest tick rate of a replay [Hz]."""
_MODELS = {"MTMR": "mtm_right", "MTML": "mtm_left", "PSM1": "psm_lnd", "PSM2": "psm_lnd", "PSM3": "psm_lnd"}
_PLACES = {"leader": [0.345, 0.243, 0.219], "follower": [-0.120, -0.060, 0.155]}
"""Positions of the arm bases without a scene [m], for display only: not a calibration."""


def stage_and_ticks(bag: Bag, scene: Path | None) -> tuple[Stage, Ticks]:
    """Stage and ticks that the viewer draws for a bag.

    Args:
        bag: a CRTK session.
        scene: scene file with the arms' models and bases and the objects. When left out, the scene in the bag is
            used; without one, only the arms are drawn.

    Raises:
        RecordError: an arm has no model, or a different number of joints. SceneError: the scene cannot be set up.
    """
    leader, follower = bag.pair
    text = bag.scene if scene is None else ""
    if scene is not None or text:
        stage = stage_of(build(Scene.load(scene) if scene is not None else Scene.parse(text, str(bag.path))))
    else:
        places = (_place(bag, leader, "leader"), _place(bag, follower or "PSM1", "follower"))
        stage = Stage(
            f"{leader} {follower or ''}".strip(), [], *places, radius=0.002, stiffness=0.0, damping=0.0,
            force_cap=np.inf, motion_scale=1.0, focus=np.array([0.1, 0.05, 0.1]), extent=0.5,
        )  # fmt: skip
    return stage, ticks(bag, stage.leader, stage.follower)


def ticks(bag: Bag, leader: ArmPlace, follower: ArmPlace) -> Ticks:
    """The session resampled at a steady rate, with the last received value of each signal: (n,) of `TICK`.

    Raises:
        RecordError: an arm in the bag has fewer joints than its model.
    """
    name, partner = bag.pair
    arm = bag.arms[name]
    clock = arm.q.t if len(arm.q.t) else arm.pose.t
    step = max(float(np.median(np.diff(clock))) if len(clock) > 2 else 0.01, 1.0 / MOST_RATE)
    t = np.arange(clock[0], bag.duration + 0.5 * step, step)
    out = np.zeros(len(t), TICK)
    out["t"] = t - t[0]
    _leader(out, bag, arm, leader.arm, t)
    if partner is not None:
        _follower(out, bag, bag.arms[partner], follower, t)
    out["p_WP"] = out["p_WT"]  # no CRTK topic reports contacts
    return out


def _leader(out: Ticks, bag: Bag, arm: ArmTracks, model: Arm, t: Array) -> None:
    q = _joints(bag, arm, model, t)
    out["q"][:, : model.n], out["v"][:, : model.n] = q, _filled(arm.v, t, model.n)
    X_LH = np.array([model.fk(row) for row in q])
    R_LH = X_LH[:, :3, :3]
    out["p_LH"], out["quat_LH"] = X_LH[:, :3, 3], quaternions(R_LH)
    if len(arm.gripper.t):
        out["gripper"] = _filled(arm.gripper, t, 1)[:, 0]
    out["v_LH"] = np.gradient(out["p_LH"], out["t"], axis=0) if len(t) > 1 else 0.0
    wrench, absolute = _filled(arm.wrench, t, 6), _filled(arm.absolute, t, 1)[:, 0] > 0.5
    # An absolute wrench is expressed in the frame of measured_cp, M; the others are expressed in the tip's frame.
    R_MH = matrices(_filled(arm.pose, t, 7)[:, 3:]) if len(arm.pose.t) else R_LH
    in_tip = np.where(absolute[:, None], _turned(R_MH.transpose(0, 2, 1), wrench[:, :3]), wrench[:, :3])
    moment = np.where(absolute[:, None], _turned(R_MH.transpose(0, 2, 1), wrench[:, 3:]), wrench[:, 3:])
    out["F_H_H"], out["F_H_L"], out["t_H_L"] = in_tip, _turned(R_LH, in_tip), _turned(R_LH, moment)
    power = np.einsum("ij,ij->i", out["F_H_L"], out["v_LH"])
    out["energy_port"] = -np.concatenate([[0.0], np.cumsum(power[:-1] * np.diff(out["t"]))])


def _follower(out: Ticks, bag: Bag, arm: ArmTracks, place: ArmPlace, t: Array) -> None:
    n, X_WB = place.arm.n, place.X_WA
    q = _joints(bag, arm, place.arm, t)
    out["q_follower"][:, :n] = q
    X_WT = np.array([X_WB @ place.arm.fk(row) for row in q])
    out["p_WT"], out["quat_WT"] = X_WT[:, :3, 3], quaternions(X_WT[:, :3, :3])
    out["p_WT_goal"] = out["p_WT"]
    if len(arm.gripper.t):
        out["jaw"] = _filled(arm.gripper, t, 1)[:, 0]


def _joints(bag: Bag, arm: ArmTracks, model: Arm, t: Array) -> Array:
    if arm.q.values.shape[1] < model.n:
        raise RecordError(
            f"{arm.name} has {arm.q.values.shape[1]} joints in the bag, its model {model.n}",
            where=str(bag.path),
            why="without measured_js the arm cannot be drawn" if not len(arm.q.t) else "",
            mend="record measured_js, or name the arms' models with --scene",
        )
    return _filled(arm.q, t, model.n)


def _filled(track: Track, t: Array, width: int) -> Array:
    """Last received values (m, width); the first value before the first message, zero without any message."""
    if not len(track.t) or track.values.shape[1] < width:
        return np.zeros((len(t), width))
    return track.at(np.maximum(t, track.t[0]))[:, :width]


def _place(bag: Bag, name: str, side: str) -> ArmPlace:
    X = np.eye(4)
    X[:3, 3] = _PLACES[side]
    try:
        model = Arm.model(_MODELS[name.rsplit("/", 1)[-1]])
    except (KeyError, PalpateError):
        raise RecordError(
            f"there is no model of the arm {name}", where=str(bag.path), why=f"known: {', '.join(_MODELS)}",
            mend="name the arms' models and bases with --scene SCENE.yaml",
        ) from None  # fmt: skip
    return ArmPlace(side, model, X)


def _turned(R: Array, v: Array) -> Array:
    """Vectors (n, 3), each turned by its own rotation (n, 3, 3)."""
    return np.asarray(np.einsum("nij,nj->ni", R, v))
