"""Sections and messages of trackers on ROS 2; tests/ros reads them from another process."""

from types import SimpleNamespace as Message

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from palpate.base.errors import SceneError
from palpate.scene import Scene
from palpate.sensing.trackers.gate import Gate, Limits
from palpate.sensing.trackers.ros_topic import sighting, topics

SCENE = """\
frames:
  - {{child: one, pose: {{xyz: [0, 0, 1]}}, tracker: t, tool: A}}
  - {{child: two, pose: {{xyz: [0, 0, 1]}}, tracker: t, tool: B}}
trackers: {{t: {{topic: "{topic}"}}}}
objects: [{{name: ball, sphere: {{radius: 0.03}}, frame: one}}]
"""


def message(p, quat_xyzw, stamp=12.25):
    x, y, z, w = quat_xyzw
    pose = Message(position=Message(x=p[0], y=p[1], z=p[2]), orientation=Message(x=x, y=y, z=z, w=w))
    return Message(header=Message(stamp=Message(sec=int(stamp), nanosec=int(stamp % 1 * 1e9))), pose=pose)


@pytest.mark.parametrize("seed", range(5))
def test_a_message_is_the_pose_of_its_quaternion(seed):
    turn = Rotation.random(random_state=seed)
    seen = sighting("A", message([0.1, 0.2, 0.3], turn.as_quat()))
    assert (seen.tool, seen.t, seen.valid) == ("A", 12.25, True)
    np.testing.assert_allclose(seen.X[:3, :3], turn.as_matrix(), atol=1e-14)
    np.testing.assert_allclose(seen.X[:3, 3], [0.1, 0.2, 0.3])


@pytest.mark.parametrize(
    ("wrong", "why"),
    [
        (message([0, 0, 1], [0, 0, 0, 1.0], stamp=0.0), "marks the pose as invalid"),
        (message([0, 0, 1], [0, 0, 0, 0.9]), "scale"),
        (message([0, 0, 1], [0, 0, 0, 0.0]), "scale"),
        (message([0, 0, np.nan], [0, 0, 0, 1.0]), "not finite"),
        (message([0, 0, 1000.0], [0, 0, 0, 1.0]), "millimetres"),
        (message([0, 0.1, 1], [0, 0, 0, 1.0]), "jumped by 100.0 mm"),
        (message([0, 0, 1], [0, 0, 0, 1.0], stamp=10.0), "stamp goes backwards"),
    ],
)
def test_wrong_messages_are_refused_by_the_gate_with_the_cause(wrong, why):
    X = np.eye(4)
    X[2, 3] = 1.0
    gate = Gate("A", X, Limits())
    assert gate.take(sighting("A", message([0, 0, 1], [0, 0, 0, 1.0], stamp=12.0)), 0.0)
    assert not gate.take(sighting("A", wrong), 0.05)
    assert why in gate.status(0.05)
    np.testing.assert_array_equal(gate.X, X)


def test_each_tool_has_its_topic():
    assert topics("/polaris/{tool}/measured_cp", ["A", "B"]) == {
        "A": "/polaris/A/measured_cp", "B": "/polaris/B/measured_cp",
    }  # fmt: skip
    Scene.parse(SCENE.format(topic="/polaris/{tool}/measured_cp"))


@pytest.mark.parametrize(
    ("topic", "words"),
    [
        ("/polaris/measured_cp", "one topic for the frames one, two"),
        ("polaris/measured_cp", "is not a topic"),
        ("/polaris/measured cp", "is not a topic"),
        ("/polaris//{tool}", "is not a topic"),
    ],
)
def test_wrong_topics_are_refused_with_the_mend(topic, words):
    with pytest.raises(SceneError, match=words):
        Scene.parse(SCENE.format(topic=topic))
