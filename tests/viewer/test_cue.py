"""The cue of force for devices without force, the placement of names, and the view that shows everything."""

import contextlib
from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from unittest.mock import MagicMock

import numpy as np
import pytest
from fake_session import FakeSession, stage
from viser.transforms import SO3

from palpate.scene import Scene
from palpate.viewer.control_panel import BALL, BALL_PIXELS, ControlPanel
from palpate.viewer.cue import LARGEST, LOWEST_TONE, Cues, ForceCue
from palpate.viewer.drawing import Drawing
from palpate.viewer.labels import Eye, arrange
from palpate.viewer.views import FIELD_OF_VIEW, Framing, overview


def pressed_tick():
    session = FakeSession()
    controls = session.controls
    controls.p_hand_offset_W = np.array([0.0, 0.0, -0.02])
    session.controls = controls
    tick = session.latest()
    assert tick["depth"] > 0.005
    return tick


def test_drawn_tool_stays_on_the_surface_while_the_hand_goes_in():
    tick, free = pressed_tick(), FakeSession().latest()
    for on in (True, False):
        scene = MagicMock()
        scene.add_icosphere.side_effect = lambda *_, **given: MagicMock(**{"position": np.zeros(3), **given})
        scene.add_frame.side_effect = lambda *_, **given: MagicMock(**given)
        drawing = Drawing(scene, replace(stage(), pseudo_haptic=on, objects=[]))
        base = drawing._follower._base
        drawing.show(tick)
        np.testing.assert_allclose(drawing.p_WT, tick["p_WP"] if on else tick["p_WT"], atol=1e-12)
        moved = tick["delta_x"] if on else np.zeros(3)
        np.testing.assert_allclose(base.position, stage().follower.X_WA[:3, 3] + moved, atol=1e-9)
        assert drawing.cue.halo.visible == on
        drawing.show(free)
        np.testing.assert_allclose(drawing.p_WT, free["p_WT"], atol=1e-12)
        np.testing.assert_allclose(base.position, stage().follower.X_WA[:3, 3], atol=1e-12)
        assert not drawing.cue.halo.visible


def test_halo_grows_with_the_force_up_to_the_cap():
    cue = ForceCue(MagicMock(), replace(stage(), pseudo_haptic=True))
    tick, seen = pressed_tick(), []
    for force in (0.0, 1.5, 3.0, 30.0):
        tick["F_T_W"] = [0.0, 0.0, force]
        cue.show(tick)
        seen.append((cue.halo.scale / stage().radius, cue.halo.color))
    assert [size for size, _ in seen] == pytest.approx([1.0, 0.5 * (1.0 + LARGEST), LARGEST, LARGEST])
    assert seen[0][1] == (255, 214, 70)
    assert seen[2][1] == (225, 20, 20)


def test_each_cue_has_its_gain_and_shows_the_force_on_the_tool():
    tick = pressed_tick()
    cue = ForceCue(MagicMock(), stage(), Cues(displaced=0.5), enabled=True)
    np.testing.assert_allclose(cue.shift(tick), 0.5 * tick["delta_x"])
    assert cue.dent(tick) is None
    deeper = ForceCue(MagicMock(), stage(), Cues(dimple=2.0), enabled=True)
    np.testing.assert_allclose(deeper.shift(tick), 0.0)
    np.testing.assert_allclose(deeper.dent(tick), tick["p_WP"] - 2.0 * tick["delta_x"])
    assert ForceCue(MagicMock(), stage(), Cues(dimple=2.0), enabled=False).dent(tick) is None
    shown = Cues(bar=2.0, tone=1.0)
    assert [shown.bar_share(force, 3.0) for force in (0.0, 0.75, 9.0)] == [0.0, 0.5, 1.0]
    assert [shown.tone_Hz(force, 3.0) for force in (0.0, 1.5, 3.0, 9.0)] == pytest.approx(
        [0.0, LOWEST_TONE * 2**0.5, 2 * LOWEST_TONE, 2 * LOWEST_TONE]
    )
    assert Cues().bar_share(3.0, 3.0) == Cues().tone_Hz(3.0, 3.0) == 0.0


def test_the_dent_of_a_displaced_tool_is_that_of_its_own_gain():
    tick = pressed_tick()
    scene = MagicMock()
    scene.add_icosphere.side_effect = lambda *_, **given: MagicMock(
        **{"position": np.zeros(3), "radius": 0.002, **given}
    )
    scene.add_frame.side_effect = lambda *_, **given: MagicMock(**given)
    for cues, part in ((Cues(displaced=1.0), 0.0), (Cues(displaced=1.0, dimple=1.5), 1.5), (Cues(), 1.0)):
        presses = Drawing(scene, replace(stage(), objects=[]), cues=cues).show(tick)
        ((centre, _, _, _),) = presses[0]
        np.testing.assert_allclose(centre, tick["p_WP"] - part * tick["delta_x"], atol=1e-9)


@pytest.mark.parametrize(
    ("leader", "shown"),
    [("{driver: mouse}", True), ("{driver: gamepad}", True), ("{driver: simulated}", False), ("{}", False),
     ("{pseudo_haptic: true}", True), ("{driver: mouse, pseudo_haptic: false}", False)],
)  # fmt: skip
def test_one_word_in_the_scene(leader, shown):
    scene = Scene.parse(f"objects: [{{sphere: {{radius: 0.03}}}}]\narms: {{leader: {leader}}}\n")
    assert scene.arms.leader.shows_force == shown


def test_names_cover_neither_each_other_nor_the_ball():
    random = np.random.default_rng(1)
    ball = (np.array([200.0, 150.0]), np.array([31.0, 31.0]))
    shown = 0
    for _ in range(50):
        texts = ["vessel", "target of the puncture", "a", "incision", "port"]
        points = list(random.uniform([50, 50], [350, 250], (5, 2)))
        points[2] = None
        sides = arrange(points, texts, [ball])
        assert sides[2] is None
        boxes = [ball]
        for point, text, side in zip(points, texts, sides, strict=True):
            if side is None:
                continue
            shown += 1
            vertical, horizontal = side.split("-")
            size = np.array([6.5 * len(text), 17.0])
            away = {"left": 0.5, "right": -0.5, "top": 0.5, "bottom": -0.5, "center": 0.0}
            centre = point + np.array([away[horizontal], away[vertical]]) * size
            assert all(np.any(np.abs(centre - c) >= 0.5 * size + h - 1e-9) for c, h in boxes)
            boxes.append((centre, 0.5 * size))
    assert shown > 180, "of 200"


@pytest.mark.parametrize("size", [(680, 800), (402, 600), (1300, 500)])
def test_overview_shows_all_points_and_is_filled_by_them(size):
    random = np.random.default_rng(2)
    for _ in range(20):
        points = random.uniform([-0.1, -0.1, 0.0], [0.35, 0.3, 0.2], (12, 3))
        eye, target = overview(replace(stage(), seen=points), size[0] / size[1])
        z = (target - eye) / np.linalg.norm(target - eye)
        x = np.cross(z, [0.0, 0.0, 1.0]) / np.linalg.norm(np.cross(z, [0.0, 0.0, 1.0]))
        camera = MagicMock(
            position=eye, wxyz=SO3.from_matrix(np.stack([x, np.cross(z, x), z], axis=1)).wxyz, fov=FIELD_OF_VIEW,
            image_width=size[0], image_height=size[1],
        )  # fmt: skip
        pixels = np.array([Eye.of(camera).pixel(p) for p in points]) / size
        assert pixels.min() > 0.0
        assert pixels.max() < 1.0
        assert np.ptp(pixels, axis=0).max() > 0.4


def test_ball_is_at_least_60_pixels_wide_in_the_overview():
    scene = replace(stage(), seen=np.array([[-0.15, -0.1, 0.0], [0.35, 0.25, 0.2]]))
    for width, height in ((680, 800), (402, 600)):
        eye, _ = overview(scene, width / height)
        panel = ControlPanel.__new__(ControlPanel)
        camera = MagicMock(position=eye, fov=FIELD_OF_VIEW, image_height=height)
        panel.ball = SimpleNamespace(position=np.array([0.3, 0.2, 0.1]), radius=BALL)
        panel.resize_ball(MagicMock(**{"get_clients.return_value": {0: SimpleNamespace(camera=camera)}}))
        away = np.linalg.norm(eye - panel.ball.position)
        assert height * panel.ball.radius / (away * np.tan(0.5 * FIELD_OF_VIEW)) >= 60.0


def test_ball_is_as_wide_in_the_window_where_the_browser_draws_fewer_pixels():
    """A browser that draws half of the pixels showed the ball twice as wide, over handle and arrows."""
    panel = ControlPanel.__new__(ControlPanel)
    radii = []
    for scale in (1.0, 0.5):
        camera = MagicMock(position=np.array([0.0, -1.0, 0.0]), fov=FIELD_OF_VIEW, image_height=800 * scale)
        panel.ball = SimpleNamespace(position=np.zeros(3), radius=BALL)
        server = MagicMock(**{"get_clients.return_value": {3: SimpleNamespace(camera=camera)}})
        panel.resize_ball(server, {3: scale}.__getitem__)
        radii.append(panel.ball.radius)
    assert radii[0] == pytest.approx(radii[1])
    assert 800 * radii[0] / np.tan(0.5 * FIELD_OF_VIEW) == pytest.approx(BALL_PIXELS)


class Window:
    """A browser whose picture has a size and a camera."""

    def __init__(self, size, position):
        self.client_id, self.atomic = 5, contextlib.nullcontext
        self.camera = SimpleNamespace(image_width=size[0], image_height=size[1], position=position, look_at=None)
        self.camera.on_update = lambda call: setattr(self, "updated", call)

    def become(self, *size):
        self.camera.image_width, self.camera.image_height = size
        self.updated(None)


def test_overview_fills_the_picture_that_the_panels_leave_until_the_user_moves_the_camera():
    scene = stage()
    server = MagicMock(**{"get_clients.return_value": {}})
    Framing(server, partial(overview, scene))
    first = overview(scene)[0]
    np.testing.assert_allclose(server.initial_camera.position, first)
    window = Window((640, 400), first)
    server.on_client_connect.call_args[0][0](window)
    np.testing.assert_allclose(window.camera.position, overview(scene, 1.6)[0])
    window.become(441, 400)  # the panels are in their places
    np.testing.assert_allclose(window.camera.position, overview(scene, 441 / 400)[0])
    window.become(882, 800)  # the same shape, drawn sharp
    np.testing.assert_allclose(window.camera.position, overview(scene, 441 / 400)[0])
    mine = window.camera.position = np.array([1.0, 2.0, 3.0])
    window.become(400, 800)
    np.testing.assert_array_equal(window.camera.position, mine)
    late = Window((640, 400), first)
    server.on_client_connect.call_args[0][0](late)
    late.camera.position = first  # its first message left before ours arrived
    late.become(441, 400)
    np.testing.assert_allclose(late.camera.position, overview(scene, 441 / 400)[0])
