"""Places the arms and computes their joints at the start, from the scene or automatically; checks their reach."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from palpate.arm import Arm
from palpate.base.arrays import Array, so3
from palpate.base.errors import SceneError
from palpate.scene import placing
from palpate.scene.hand import HandPlan
from palpate.scene.scene import Scene
from palpate.scene.surface import PlacedSurface

_RCM_HEIGHT = 0.12  # height of an automatic follower base above the surface: half of the instrument's travel [m]
_LEADER_OFFSET = np.array([0.35, -0.15, 0.05])  # offset of an automatic leader handle from the objects' box [m]
_MAX_JOINTS = 7  # number of joints that a record stores
_GRAVITY = np.array([0.0, 0.0, -9.81])  # in W [m/s^2]
_TOLERANCE = (1e-6, 1e-5)  # errors with which a pose counts as reached [m, rad]


@dataclass(frozen=True)
class Arms:
    """Both arms with their base poses and their joint positions at the start."""

    leader: Arm
    follower: Arm
    X_WL: Array  # (4, 4)
    X_WB: Array  # (4, 4)
    q_leader0: Array  # (n,) [rad, m]
    q_follower0: Array  # (n,) [rad, m]


def place(scene: Scene, surfaces: list[PlacedSurface], path: HandPlan, R_picture: Array | None = None) -> Arms:
    """Place the arms as the scene states, or so that they reach the objects; compute their joints at the start.

    R_picture: orientation R_WL (3, 3) of an automatic leader base that follows a picture; None: chosen by reach.

    Raises:
        SceneError: a start pose or a point of the path is out of reach; the message names the arm, pose and distance.
        ArmError: the simulated leader has a joint without inertia or without a drive limit.
    """
    leader = _arm(scene, "leader")
    if scene.arms.leader.driver is None:
        leader.leader_options()  # what no place can mend, such as a joint that moves no mass, comes first
    follower = _arm(scene, "follower")
    X_WB = _follower_base(scene, follower, surfaces, path)
    q_follower0 = _follower_start(scene, follower, X_WB, path)
    X_WT = X_WB @ follower.fk(q_follower0)

    X_WL, q_leader0 = _leader(scene, surfaces, leader, X_WT, R_picture)
    leader.set_gravity(X_WL[:3, :3].T @ _GRAVITY)
    arms = Arms(leader, follower, X_WL, X_WB, q_leader0, q_follower0)
    _check_path(scene, arms, path)
    return arms


def _arm(scene: Scene, side: str) -> Arm:
    arm = scene.arm(side)
    if arm.n > _MAX_JOINTS:
        raise SceneError(
            f"{side} {arm.name} has {arm.n} joints; a session takes arms of up to {_MAX_JOINTS}",
            where=scene.where("arms", side, "model"),
            mend='lock joints with type="fixed", or name a tip_frame nearer to the base',
        )
    return arm


def _follower_base(scene: Scene, arm: Arm, surfaces: list[PlacedSurface], path: HandPlan) -> Array:
    base = placing.base_pose(scene, "follower")
    if base is not None:
        return base
    start = path.positions_W[0]
    if not arm.has_remote_centre:  # upright, with its tip at home at the start of the path
        X = np.eye(4)
        X[:3, 3] = start - arm.fk(arm.home)[:3, 3]
        return X
    nearest = min((s.nearest(start[None])[0][0] for s in surfaces), key=lambda q: float(np.linalg.norm(q - start)))
    up = np.array([0.0, 0.0, 1.0])
    out = start - nearest
    out = out / np.linalg.norm(out) if np.linalg.norm(out) > 1e-9 else up
    axis = out + up  # between the surface normal and the vertical
    axis = axis / np.linalg.norm(axis) if np.linalg.norm(axis) > 0.1 else out
    X = np.eye(4)
    X[:3, :3] = so3.onto(axis)
    X[:3, 3] = nearest + _RCM_HEIGHT * axis
    return X


def _follower_start(scene: Scene, arm: Arm, X_WB: Array, path: HandPlan) -> Array:
    start = scene.arms.follower.start
    if start is not None:
        X_BT = np.linalg.inv(X_WB) @ start.matrix()
        return _reach(scene, "follower", arm, X_WB, X_BT, arm.home, "arms", "follower", "start")
    X_WT = np.eye(4)
    X_WT[:3, 3] = path.positions_W[0]
    q = arm.home
    if not arm.has_remote_centre:
        X_WT[:3, :3] = (X_WB @ arm.fk(arm.home))[:3, :3]
    for _ in range(20 if arm.has_remote_centre else 0):  # rotate the goal with the shaft until the wrist is straight
        straight = np.concatenate([q[:4], np.zeros(len(q) - 4)])
        X_WT[:3, :3] = (X_WB @ arm.fk(straight))[:3, :3]
        q, _ = _ik(arm, np.linalg.inv(X_WB) @ X_WT, straight)
    place = ("arms", "follower", "base") if scene.arms.follower.base else ("operator",)
    return _reach(scene, "follower", arm, X_WB, np.linalg.inv(X_WB) @ X_WT, q, *place)


def _leader(
    scene: Scene, surfaces: list[PlacedSurface], arm: Arm, X_WT: Array, R_picture: Array | None
) -> tuple[Array, Array]:
    axes = np.eye(3) if R_picture is None else R_picture
    section = scene.arms.leader
    base = placing.base_pose(scene, "leader")
    if section.driver is not None:
        return (base if base is not None else _base_next_to(surfaces, np.zeros(3), axes)), arm.home
    if section.start is not None:
        q = np.array(section.start)
        if len(q) != arm.n:
            raise SceneError(
                f"arms.leader.start must have {arm.n} numbers, one per joint of {arm.name}. Got: {len(q)}",
                where=scene.where("arms", "leader", "start"),
                mend=f"its joints are {', '.join(arm.joint_names)}",
            )
        for name, value, low, high in zip(arm.joint_names, q, arm.q_min, arm.q_max, strict=True):
            if not low <= value <= high:
                raise SceneError(
                    f"arms.leader.start: {name} = {value:g} rad is outside its limits, {low:.3f} to {high:.3f} rad",
                    where=scene.where("arms", "leader", "start"),
                    mend="choose a value within the limits, or leave start out",
                )
        return (base if base is not None else _base_next_to(surfaces, arm.fk(q)[:3, 3], axes)), q
    handle = arm.fk(arm.home)
    if not arm.orients:
        return (base if base is not None else _base_next_to(surfaces, handle[:3, 3], axes)), arm.home
    fixed = base[:3, :3] if base is not None else R_picture
    for yaw in (0.0,) if fixed is not None else np.radians([0, 90, -90, 180, 45, -45, 135, -135]):
        c, s = math.cos(yaw), math.sin(yaw)
        R_WL = fixed if fixed is not None else np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])
        X_LH = handle.copy()
        X_LH[:3, :3] = R_WL.T @ X_WT[:3, :3]  # the handle has the tool's orientation
        q, missed = _ik(arm, X_LH, arm.home)
        if missed[0] < _TOLERANCE[0] and missed[1] < _TOLERANCE[1]:
            return (base if base is not None else _base_next_to(surfaces, handle[:3, 3], R_WL)), q
    raise SceneError(
        f"leader {arm.name} cannot give its handle the orientation of the tool at the start",
        where=scene.where("arms", "leader"),
        why=f"its wrist is {math.degrees(missed[1]):.1f} degrees short of it",
        mend="give arms.leader.start or another arms.leader.base, or turn arms.follower.start"
        + (", or set ecm.follow_picture: false" if R_picture is not None else ""),
    )


def _base_next_to(surfaces: list[PlacedSurface], p_LH: Array, R_WL: Array) -> Array:
    bounds = np.array([s.bounds for s in surfaces])
    low, high = bounds[:, 0].min(axis=0), bounds[:, 1].max(axis=0)
    corner = np.array([high[0], 0.5 * (low[1] + high[1]), 0.5 * (low[2] + high[2])])
    X = np.eye(4)
    X[:3, :3] = R_WL
    X[:3, 3] = corner + _LEADER_OFFSET - R_WL @ p_LH
    return X


def _check_path(scene: Scene, arms: Arms, path: HandPlan) -> None:
    """Check that both arms reach the intended path with constant orientation."""
    last = np.searchsorted(path.times, 6 * path.period, side="right") if path.period else len(path.times)
    rows = np.linspace(0, max(0, int(last) - 1), 120).astype(int)
    rows = rows[np.diff(rows, prepend=-1) > 0]  # np.unique would import numpy.ma
    X_WT, X_LH = arms.X_WB @ arms.follower.fk(arms.q_follower0), arms.leader.fk(arms.q_leader0)
    p0, R_LW, scale = X_WT[:3, 3].copy(), arms.X_WL[:3, :3].T, scene.mapping.scale
    X_BW, q_f, q_l, handle0 = np.linalg.inv(arms.X_WB), arms.q_follower0, arms.q_leader0, X_LH[:3, 3].copy()
    place = ("operator", "path") if scene.operator.path else ("operator", "palpate")
    for i in rows:
        what = f"the operator's path at {path.times[i]:.3g} s"
        X_WT[:3, 3] = path.positions_W[i]
        q_f = _reach(scene, "follower", arms.follower, arms.X_WB, X_BW @ X_WT, q_f, *place, what=what)
        if scene.arms.leader.driver is not None:
            continue  # only the person at the device knows where the hand goes
        X_LH[:3, 3] = handle0 + R_LW @ (path.positions_W[i] - p0) / scale
        q_l = _reach(scene, "leader", arms.leader, arms.X_WL, X_LH, q_l, *place, what=what)


def _reach(
    scene: Scene, side: str, arm: Arm, X_W0: Array, X_0T: Array, q0: Array, *place: str, what: str = "its start pose"
) -> Array:
    """Joint positions whose tip is at X_0T in the arm's base, which stands at X_W0."""
    q, (far, turned) = _ik(arm, X_0T, q0)
    if far < _TOLERANCE[0] and turned < _TOLERANCE[1]:
        return q
    p = ", ".join(f"{x:.3f}" for x in (X_W0 @ X_0T)[:3, 3])
    base = ", ".join(f"{x:.3f}" for x in X_W0[:3, 3])
    raise SceneError(
        f"{side} {arm.name} cannot reach {what}: tip at ({p}) m in W, {1e3 * far:.1f} mm and "
        f"{math.degrees(turned):.1f} degrees out of reach",
        where=scene.where(*place),
        why=f"its base stands at ({base}) m in W",
        mend=_mend_reach(scene, side),
    )


def _mend_reach(scene: Scene, side: str) -> str:
    """What lets an arm reach its path: only what has not been done already."""
    if getattr(scene.arms, side).base is not None:
        return f"move the base, or leave out arms.{side}.base: the arm is then placed automatically"
    ways = [f"give arms.{side}.base", f"begin elsewhere (arms.{side}.start, or home in its model file)"]
    if side == "leader" and scene.mapping.scale < 1.0:
        ways.insert(0, f"let the hand move less: mapping.scale 1 instead of {scene.mapping.scale:g}")
    return f"the arm was placed automatically; {', or '.join(ways)}"


def _ik(arm: Arm, X_0T: Array, q0: Array) -> tuple[Array, tuple[float, float]]:
    """Joint positions closest to a pose, and the remaining pose error [m, rad]."""
    q, result = arm.ik_nearest(X_0T, q0, restarts=24)
    return q, (result.position_error, result.orientation_error)
