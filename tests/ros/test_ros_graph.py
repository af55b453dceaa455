"""`palpate ros graph`: rates and ages of topics whose publisher is known exactly."""

import os

import pytest

from palpate.base.errors import PalpateError
from palpate.ros import graph


def test_rates_and_ages_are_those_of_the_publisher(native, node):
    """The leader sends 200 states a second, each 50 ms after its stamp."""
    from rclpy.qos import DurabilityPolicy, QoSProfile
    from std_msgs.msg import String

    options = native.MockLeaderOptions()
    options.leader, options.rate = f"SEEN{os.getpid()}", 200.0
    leader = native.MockLeader(native.Context(), options)
    faults = native.MessageFaults()
    faults.delay = 0.05
    leader.inject(faults)
    leader.start()
    quality = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    node.create_publisher(String, "/seen_latched", quality).publish(String(data="once"))
    told = []
    try:
        found = graph.measure(1.5, progress=told.append)
    finally:
        leader.stop()
    topics = {one.name: one for one in found.topics}
    pose = topics[f"/{options.leader}/measured_cp"]
    assert pose.rate_hz == pytest.approx(200.0, rel=0.1)
    assert pose.messages == pytest.approx(300, rel=0.25)
    assert 50.0 <= pose.age_p50_ms < 70.0
    assert pose.age_max_ms >= pose.age_p50_ms
    latched = topics["/seen_latched"]
    assert latched.messages == 1, "the last message arrives although nothing is published meanwhile"
    assert latched.rate_hz is None
    assert told[0] >= 2
    assert len(pose.publishers) == 1
    assert pose.subscribers == [], "the nodes that look are left out"


def test_a_network_without_nodes_is_told(native, monkeypatch):
    monkeypatch.setenv("ROS_DOMAIN_ID", str((int(os.environ["ROS_DOMAIN_ID"]) + 30) % 100))
    with pytest.raises(PalpateError, match="there is no node on this network"):
        graph.measure(0.1)
