"""The picture of a device: handle, workspace, what is left of the range, and the mapping."""

from dataclasses import replace
from unittest.mock import MagicMock

import numpy as np
import pytest
from fake_session import FakeSession, stage

from palpate.devices.loop import mapped_rig
from palpate.scene import Scene
from palpate.viewer import stage_of
from palpate.viewer.device import DeviceDrawing
from palpate.viewer.drawing import Drawing
from palpate.viewer.stage import DeviceMark

X_WL = np.array([[0.0, -1.0, 0.0, 0.3], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.1], [0.0, 0.0, 0.0, 1.0]])


def drawn(centre=(0.0, 0.0, 0.0), size=(0.16, 0.12, 0.1), scale=0.5):
    scene = MagicMock()
    for add in (scene.add_icosphere, scene.add_frame, scene.add_line_segments):
        add.side_effect = lambda *args, **given: MagicMock(given=args, **given)
    mark = DeviceMark("simulated", X_WL, None if size is None else np.array(size),
                      None if centre is None else np.array(centre), "indexed, 0.5 times the hand", scale)  # fmt: skip
    return scene, DeviceDrawing(scene, mark)


def tick(p, t=1.0, quat=(1.0, 0.0, 0.0, 0.0)):
    found = FakeSession().latest()
    found["p_LH"], found["quat_LH"], found["t"] = p, quat, t
    return found


def test_the_handle_is_drawn_in_the_world_and_the_nearest_side_is_told():
    scene, device = drawn()
    one = tick([0.05, 0.0, 0.0])
    device.show(one)
    assert device._handle.position == pytest.approx([0.3, 0.05, 0.1])
    half = np.sqrt(0.5)
    assert device._axes.wxyz == pytest.approx([half, 0.0, 0.0, half]), "as the base, a quarter about z"
    device.show(tick([0.05, 0.0, 0.0], quat=(half, 0.0, 0.0, half)))
    assert device._axes.wxyz == pytest.approx([0.0, 0.0, 0.0, 1.0]), "and a quarter more by the handle"
    assert device.left(one) == pytest.approx([0.03, 0.06, 0.05])
    assert device.left_in_words(one) == "30 mm to +x"
    corners = device.corners()
    assert np.ptp(corners, axis=0) == pytest.approx([0.22] * 3), "the longest side and the axes of the handle"
    assert corners.mean(axis=0) == pytest.approx([0.3, 0.05, 0.1])
    assert device.left_in_words(tick([-0.05, 0.0, 0.0])) == "30 mm to -x"
    assert not device.at_edge(one)
    assert [[box.visible for box in device._box[red]] for red in (False, True)] == [[True, True], [False, False]]
    edge = tick([0.0, 0.0, 0.045])
    device.show(edge)
    assert device.at_edge(edge)
    assert [[box.visible for box in device._box[red]] for red in (False, True)] == [[False, False], [True, True]]
    assert device.left_in_words(tick([0.0, 0.0, -0.06])) == "beyond by 10 mm"
    workspace, reach = (call.args[1] for call in scene.add_line_segments.call_args_list[:2])
    assert workspace.shape == reach.shape == (12, 2, 3)
    assert np.ptp(workspace.reshape(-1, 3), axis=0) == pytest.approx([0.12, 0.16, 0.1]), "turned as the base"
    assert np.ptp(reach.reshape(-1, 3), axis=0) == pytest.approx([0.06, 0.08, 0.05]), "scaled as the motion of the tool"


def test_the_reach_of_the_tool_stands_still_while_it_moves_as_the_hand_and_goes_along_with_a_clutch():
    _, device = drawn()
    places = []
    for p_LH, p_WT in (([0.0, 0.0, 0.0], [0.1, 0.2, 0.3]), ([0.04, 0.0, 0.0], [0.1, 0.22, 0.3]),
                       ([0.0, 0.0, 0.0], [0.1, 0.22, 0.3])):  # fmt: skip
        one = tick(p_LH)
        one["p_WT"] = p_WT
        device.show(one)
        places.append(device._reach.position)
    assert places[0] == pytest.approx([0.1, 0.2, 0.3])
    assert places[1] == pytest.approx(places[0])
    assert places[2] == pytest.approx([0.1, 0.22, 0.3]), "the hand went back alone"


def test_a_workspace_without_centre_lies_around_the_first_position():
    scene, device = drawn(centre=None)
    device.show(tick([0.0, 0.0, 0.0], t=0.0))
    assert not scene.add_line_segments.called, "not yet measured"
    first = tick([0.02, -0.1, 0.15])
    device.show(first)
    assert device.left(first) == pytest.approx([0.08, 0.06, 0.05])
    for z, below, above in ((0.22, 0.1, 0.0), (0.2, 0.08, 0.02), (0.12, 0.0, 0.1)):
        one = tick([0.02, -0.1, z])
        device.show(one)
        assert device.left(one)[2] == pytest.approx(min(below, above)), "the handle shows where the workspace is"
        assert device._place.position[2] - X_WL[2, 3] == pytest.approx(z + 0.5 * (above - below))


def test_the_centre_by_which_a_law_acts_stays():
    _, device = drawn(centre=None)
    device.mark = replace(device.mark, mapping="drift, 0.5 times the hand")
    device.show(tick([0.0, 0.0, 0.0]))
    far = tick([0.0, 0.0, 0.07])
    device.show(far)
    assert device.left_in_words(far) == "beyond by 20 mm"


def test_an_unknown_workspace_is_said():
    _, device = drawn(size=None)
    one = tick([0.0, 0.0, 0.0])
    device.show(one)
    assert device.left_in_words(one) == "unknown"
    assert not device.at_edge(one)


def test_the_device_is_drawn_in_place_of_the_simulated_arm():
    mark = drawn()[1].mark
    scene = MagicMock()
    assert Drawing(scene, replace(stage(), objects=[]))._leader is not None
    drawing = Drawing(scene, replace(stage(), objects=[], device=mark))
    assert drawing._leader is None
    assert drawing.device.mark is mark


def test_the_stage_of_a_scene_with_a_driver_has_its_workspace_and_mapping():
    scene = Scene.model_validate({
        "objects": [{"name": "ball", "sphere": {"radius": 0.03}, "stiffness": 400}],
        "arms": {"leader": {"driver": "simulated"}}, "mapping": {"law": "drift", "scale": 0.8},
    })  # fmt: skip
    mark = stage_of(mapped_rig(scene, (0.16, 0.16, 0.11))).device
    assert (mark.name, mark.mapping) == ("simulated", "drift, 0.8 times the hand")
    assert mark.workspace == pytest.approx([0.16, 0.16, 0.11])
    assert mark.centre == pytest.approx([0.0, 0.0, 0.0])
