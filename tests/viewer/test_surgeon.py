"""The surgeon's view: where the eyes are, what they are asked to render, and the forces drawn on the picture."""

import time
from types import SimpleNamespace

import numpy as np
import pytest

from palpate import Scene
from palpate.base.arrays import so3
from palpate.record.ticks import TICK
from palpate.scene.rig import build
from palpate.viewer import surgeon
from palpate.viewer.staging import stage_of
from palpate.viewer.surgeon import GREEN, SIZE, SurgeonView, project, vertical_angle, with_bars, with_forces

SCENE = """
objects:
  - {name: floor, plane: {}, stiffness: 400}
ecm: {endoscope: {baseline: 0.006, width_deg: 60}}
"""


@pytest.fixture(scope="module")
def rig():
    return build(Scene.parse(SCENE))


def test_projection_by_similar_triangles():
    """A point at a depth z and the half width z tan(30 deg) lies on the rim of a picture of 60 degrees."""
    angle, rim = vertical_angle(60.0), 0.2 * np.tan(np.radians(30.0))
    high = rim * SIZE[0] / SIZE[1]
    seen = project(np.eye(4), [[0, 0, 0.2], [rim, 0, 0.2], [0, high, 0.2], [0, 0, -0.2]], angle)
    np.testing.assert_allclose(seen[:3], [[140, 105], [280, 105], [140, 210]], atol=1e-9)
    assert np.isnan(seen[3]).all(), "behind the camera"


def test_eyes_are_apart_by_the_baseline_and_see_the_same_way(rig):
    left, right = (rig.ecm.eye(rig.ecm.q0, side) for side in ("left", "right"))
    np.testing.assert_allclose(left[:3, :3], right[:3, :3])
    np.testing.assert_allclose(left[:3, :3].T @ (right[:3, 3] - left[:3, 3]), [0.006, 0, 0], atol=1e-12)
    p_WT = (rig.arms.X_WB @ rig.arms.follower.fk(rig.arms.q_follower0))[:3, 3]
    seen = [project(X, p_WT, vertical_angle(60.0))[0] for X in (left, right)]
    for pixel in seen:  # the automatic camera looks at the tool
        assert np.linalg.norm(pixel - [140, 105]) < 25
    assert seen[0][0] - seen[1][0] > 5, "a near point lies further right for the left eye"


def tick_with(p_WT, F):
    tick = np.zeros((), dtype=TICK)
    tick["p_WT"], tick["F_T_W"], tick["F_H_L"] = p_WT, F, F
    return tick


def green(image):
    return np.argwhere((image == GREEN).all(axis=2))


def test_the_arrow_starts_at_the_tip_and_points_along_the_force():
    X_WC, blank = np.eye(4), np.full((*SIZE, 3), 90, np.uint8)
    tick = tick_with([0, 0, 0.1], [0, -2.0, 0])  # up in the picture
    rows, columns = green(with_forces(blank, [tick], X_WC, vertical_angle(60.0))).T
    assert abs(columns.mean() - 140) < 3
    assert rows.max() == pytest.approx(105, abs=3)
    length = 2.0 * surgeon.TIP_SCALE / 0.1 * 0.5 * SIZE[0] / np.tan(0.5 * vertical_angle(60.0))
    assert rows.max() - rows.min() == pytest.approx(length, abs=6)
    assert len(green(with_forces(blank, [tick_with([0, 0, 0.1], [0, 0, 0])], X_WC, 1.0))) == 0
    assert len(green(with_forces(blank, [tick_with([0, 0, -0.1], [0, -2.0, 0])], X_WC, 1.0))) == 0


class FakeClient:
    def __init__(self):
        self.asked = []

    def get_render(self, height, width, *, wxyz, position, fov, timeout):
        self.asked.append((wxyz, position, fov))
        return np.full((height, width, 4), 10 * len(self.asked), np.uint8)


class FakeServer:
    def __init__(self):
        self.client = FakeClient()
        handle = lambda *_, **values: SimpleNamespace(on_update=lambda f: f, **values)  # noqa: E731
        self.gui = SimpleNamespace(
            add_dropdown=lambda *_, **more: handle(value=more["initial_value"]),
            add_image=lambda image, visible: handle(image=image, visible=visible),
        )

    def get_clients(self):
        return {0: self.client}


@pytest.mark.parametrize(("choice", "sides"), [("left eye", ["left"]), ("both eyes", ["left", "right"])])
def test_the_browser_renders_each_eye_once_and_pictures_stand_side_by_side(rig, choice, sides):
    server, q = FakeServer(), rig.ecm.q0 + [0.1, 0, 0, 0.2]  # noqa: RUF005
    view = SurgeonView(server, rig.ecm, lambda: q, lambda: [tick_with([0, 0, 0], [0, 0, 0])])
    view.choice.value = choice
    view._switch()
    end = time.monotonic() + 10.0
    while view.shown < 1 and time.monotonic() < end:
        time.sleep(0.01)
    view.close()
    assert view.picture.visible
    assert view.picture.image.shape == (SIZE[0], SIZE[1] * len(sides), 3)
    for side, (wxyz, position, angle) in zip(sides, server.client.asked, strict=False):
        X = rig.ecm.eye(q, side)
        np.testing.assert_allclose(position, X[:3, 3])
        np.testing.assert_allclose(so3.matrices(wxyz), X[:3, :3], atol=1e-12)
        assert angle == pytest.approx(vertical_angle(60.0))


def test_the_stage_holds_the_endoscope_arm(rig):
    assert stage_of(rig).ecm is rig.ecm


def test_the_forces_of_two_tools_are_both_in_the_picture():
    """The arrows stand at both tips, and the numbers from left to right as the tools do."""
    X_WC, blank = np.eye(4), np.full((*SIZE, 3), 90, np.uint8)
    left, right = tick_with([-0.03, 0, 0.1], [0, -2.0, 0]), tick_with([0.03, 0, 0.1], [0, -1.0, 0])
    angle = vertical_angle(60.0)
    both = with_forces(blank, [right, left], X_WC, angle)
    rows, columns = green(both).T
    one, other = columns < 140, columns > 140
    assert 1.6 < np.ptp(rows[one]) / np.ptp(rows[other]) < 2.4
    np.testing.assert_array_equal(both, with_forces(blank, [left, right], X_WC, angle))
    box = (slice(185, 205), slice(6, 66))  # the number of a single tool
    np.testing.assert_array_equal(both[box], with_forces(blank, [left], X_WC, angle)[box])


def test_the_bar_of_a_condition_fills_with_its_share():
    plain = np.zeros((SIZE[0], SIZE[1], 3), np.uint8)
    for share in (0.0, 0.25, 1.0, 3.0):
        drawn = with_bars(plain, [share])
        red = int((drawn[SIZE[0] - 10] == (225, 38, 38)).all(axis=1).sum())
        assert red == round((SIZE[1] - 12) * min(share, 1.0))
        assert not drawn[: SIZE[0] - 20].any()
    assert not with_bars(plain, []).any()
