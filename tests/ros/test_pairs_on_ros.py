"""Two pairs of one scene on ROS 2: names of their own, and the graph as measured."""

import time

import pytest

from palpate.cli.ros._pairs import wanted
from palpate.errors import PalpateError
from palpate.ros.pairs import require_devices
from palpate.scene import Scene

TWO = """\
objects: [{plane: {}, stiffness: 300}]
pairs:
  right: {devices: {leader: MTMR}, arms: {follower: {base: {xyz: [0.1, 0, 0.2]}}}}
  left: {devices: {leader: MTML}}
"""


def test_a_pair_without_names_of_its_arms_is_refused():
    scene = Scene.load("two_hands")
    with pytest.raises(PalpateError, match="pair right does not name its arms"):
        require_devices(scene)
    require_devices(Scene.parse(TWO))
    assert wanted(Scene.parse(TWO), "left") == ["left"]
    with pytest.raises(PalpateError, match="there is no pair 'middle'"):
        wanted(Scene.parse(TWO), "middle")


@pytest.mark.usefixtures("built")
def test_nodes_of_two_pairs_have_names_of_their_own_and_the_graph_measures_them():
    from palpate.ros import graph, sim
    from palpate.ros.around import Around
    from palpate.ros.haptics import Devices, HapticSession, Limits

    scene = Scene.load("two_hands")
    robot = sim.start(("MTMR", "MTML"), rate=100.0)
    sessions, around = [], []
    try:
        for name, leader in (("right", "MTMR"), ("left", "MTML")):
            devices = Devices(leader, "virtual", "none", "console", name)
            sessions.append(HapticSession(scene.pair(name), devices, Limits(rate=100.0)))
            around.append(Around(sessions[-1], pair=name, draws_objects=name == "right"))
        for session in sessions:
            session.start()
        time.sleep(0.5)
        found = graph.measure(0.3)
    finally:
        for one in (*around, *sessions):
            one.close()
        robot.stop()
    assert found.duplicate_nodes == []
    names = {node.name for node in found.nodes}
    assert {"/right/palpate", "/left/palpate"} <= names
    assert {"/right/palpate_haptics_MTMR", "/left/palpate_haptics_MTML"} <= names
    topics = {one.name: one for one in found.topics}
    measured = topics["/MTMR/measured_cp"]
    assert measured.messages > 0
    assert "/right/palpate_haptics_MTMR" in measured.subscribers
    assert topics["/right/palpate/markers"].publishers == ["/right/palpate"]
