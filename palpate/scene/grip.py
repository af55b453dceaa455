"""Checks gripper and jaws of a scene against its arms, and hands them to the core."""

from __future__ import annotations

from palpate import _core
from palpate.arm import Arm
from palpate.base.errors import SceneError
from palpate.scene.scene import Scene


def fill(o: _core.SimulationOptions, scene: Scene) -> None:
    """Write gripper and jaws of a scene into the options of the core."""
    gripper, jaw, mapping, stability = scene.arms.leader.gripper, scene.arms.follower.jaw, o.mapping, o.stability
    mapping.gripper_min, mapping.gripper_max = gripper.closed, gripper.open
    mapping.jaw_min, mapping.jaw_max, mapping.jaw_rate, mapping.jaw_start = jaw.closed, jaw.open, jaw.rate, jaw.start
    stability.gripper_cap = gripper.torque
    o.mapping, o.stability = mapping, stability


def check(scene: Scene, follower: Arm) -> None:
    """Refuse jaws that the follower does not have, angles that they cannot reach, and a gripper without a motor.

    Raises:
        SceneError: the message names the key, its value and the limits.
    """
    gripper, jaw = scene.arms.leader.gripper, scene.arms.follower.jaw
    if gripper.torque > 0.0 and scene.arms.leader.driver is None:
        raise SceneError(
            f"arms.leader.gripper.torque: {gripper.torque:g} N m, but the gripper of {scene.arms.leader.model} "
            "has no motor",
            where=scene.where("arms", "leader", "gripper", "torque"),
            mend="leave torque out; the fingers feel the jaws on a device whose driver has a function grip",
        )
    if not jaw.model_fields_set:
        return
    low, high = follower.jaw_range
    if low == high:
        raise SceneError(
            f"arms.follower.jaw: {follower.name} has no jaws",
            where=scene.where("arms", "follower", "jaw"),
            mend="leave jaw out, or take a follower with a jaw, such as psm_lnd",
        )
    for key in ("start", "closed", "open"):
        angle = getattr(jaw, key)
        if not low <= angle <= high:
            raise SceneError(
                f"arms.follower.jaw.{key}: {angle:g} rad is outside the jaws' limits, {low:.3f} to {high:.3f} rad",
                where=scene.where("arms", "follower", "jaw", key),
                mend="choose an angle within the limits",
            )
