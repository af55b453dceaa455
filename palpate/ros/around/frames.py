"""Publishes the tree of frames, and the models and joint states of the arms."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from palpate.arm import Arm
from palpate.base.arrays import Array
from palpate.base.arrays.so3 import pose
from palpate.record.ticks import Ticks
from palpate.ros.around.convert import WORLD, is_heard, latched, transforms
from palpate.scene.live_targets import object_poses

if TYPE_CHECKING:
    from palpate.ros.plant import CrtkPlant
    from palpate.session import Session


class Frames:
    """Publishes /tf, and ~/NAME/joint_states and ~/NAME/robot_description for each arm NAME.

    Frames: palpate_world > NAME_base > NAME/LINK for each link of the model, the measured NAME_handle and NAME_tool,
    palpate_proxy, palpate_object_OBJECT, and palpate_frame_FRAME for each entry of the scene's list `frames`:
    latched on /tf_static where its pose is known or registered, on /tf where a tracker sees it.
    """

    def __init__(
        self, node: Any, session: Session, plant: CrtkPlant, pair: str = "", draws_objects: bool = True
    ) -> None:
        from sensor_msgs.msg import JointState
        from std_msgs.msg import String
        from tf2_msgs.msg import TFMessage

        self._node, self._session = node, session
        self._tf = node.create_publisher(TFMessage, "/tf", 10)
        self._static = node.create_publisher(TFMessage, "/tf_static", latched())
        scene, arms, names = session.rig.scene, session.rig.arms, plant.loop.names
        own = f"{pair}_" if pair else ""  # frames of several pairs in one tree
        self._leader, self._follower = names.leader, names.follower or f"{own}virtual"
        self._proxy, self._draws_objects = f"{own}palpate_proxy", draws_objects
        self._arms = {
            self._leader: (scene.arm("leader"), arms.X_WL, "q", "gripper"),
            self._follower: (scene.arm("follower"), arms.X_WB, "q_follower", "jaw"),
        }
        self._joints = {name: node.create_publisher(JointState, f"~/{name}/joint_states", 10) for name in self._arms}
        self._models = [node.create_publisher(String, f"~/{name}/robot_description", latched()) for name in self._arms]
        for publisher, side in zip(self._models, ("leader", "follower"), strict=True):
            publisher.publish(String(data=scene.arm(side).urdf))
        self._publish_static()

    def _edges(self, live: bool) -> list[tuple[str, str, Array]]:
        """Parent, child and pose of the entries of the scene's list `frames` that move, or of those that do not."""
        rig = self._session.rig
        own = {section.child for section in rig.scene.frames}
        edges = [edge for edge in rig.frames.edges if edge.child in own and (edge.kind == "live") == live]
        return [(_tf_name(edge.parent), _tf_name(edge.child), edge.X) for edge in edges]

    def _publish_static(self) -> None:
        from tf2_msgs.msg import TFMessage

        stamp = self._node.get_clock().now().to_msg()
        found = self._edges(live=False)
        if found and self._draws_objects:
            self._static.publish(TFMessage(transforms=transforms(found, stamp)))

    def show(self, tick: Ticks) -> None:
        """Publish all frames and joint states of a tick, for those who listen."""
        stamp = self._node.get_clock().now().to_msg()
        for name, (arm, _, joints, _) in self._arms.items():
            q = np.array(tick[joints][: arm.n])
            if np.isfinite(q).all() and is_heard(self._joints[name]):
                self._joints[name].publish(_joint_state(arm, q, stamp, name))
        if is_heard(self._tf):
            self._publish_tree(tick, stamp)

    def _publish_tree(self, tick: Ticks, stamp: Any) -> None:
        """Publish all frames that move."""
        from tf2_msgs.msg import TFMessage

        found = [(WORLD, self._proxy, _translation(tick["p_WP"]))]
        X_WL = self._session.rig.arms.X_WL
        found.append((WORLD, f"{self._leader}_handle", X_WL @ pose(tick["p_LH"], tick["quat_LH"])))
        found.append((WORLD, f"{self._follower}_tool", pose(tick["p_WT"], tick["quat_WT"])))
        for name, (arm, X_WA, joints, pinch) in self._arms.items():
            q = np.array(tick[joints][: arm.n])
            found.append((WORLD, f"{name}_base", X_WA))
            if np.isfinite(q).all():
                links = arm.link_poses(q, float(np.nan_to_num(tick[pinch])))
                found += [(f"{name}_base", f"{name}/{link}", X) for link, X in links.items()]
        poses = object_poses(self._session.rig, tick)
        if self._draws_objects:
            found += [(WORLD, f"palpate_object_{name}", X_WO) for name, X_WO in poses.items()]
            found += self._edges(live=True)
        good = [edge for edge in found if np.isfinite(edge[2]).all()]
        self._tf.publish(TFMessage(transforms=transforms(good, stamp)))


def _tf_name(frame: str) -> str:
    return WORLD if frame == "world" else f"palpate_frame_{frame}"


def _translation(p: Array) -> Array:
    X = np.eye(4)
    X[:3, 3] = p
    return X


def _joint_state(arm: Arm, q: Array, stamp: Any, name: str) -> Any:
    from sensor_msgs.msg import JointState
    from std_msgs.msg import Header

    return JointState(header=Header(stamp=stamp, frame_id=name), name=list(arm.joint_names), position=q.tolist())
