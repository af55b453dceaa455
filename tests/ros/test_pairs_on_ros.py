"""Two pairs of one scene on ROS 2: names of their arms."""

import pytest

from palpate.base.errors import PalpateError
from palpate.cli.commands.ros._pairs import wanted
from palpate.ros.pairs import devices_of
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
        devices_of(scene)
    devices_of(Scene.parse(TWO))
    assert wanted(Scene.parse(TWO), "left") == ["left"]
    with pytest.raises(PalpateError, match="there is no pair 'middle'"):
        wanted(Scene.parse(TWO), "middle")
