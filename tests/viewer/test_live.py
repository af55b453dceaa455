"""The live viewer in a real browser: dragging the hand, forces, and controls."""

import io
import time

import numpy as np
import pytest
from browser import number, on_screen, open_page
from fake_session import FakeSession, stage
from PIL import Image

from palpate.base.errors import PortError
from palpate.viewer.live import LiveViewer


@pytest.fixture(scope="module")
def viewer():
    viewer = LiveViewer(FakeSession(), stage(), port=0)
    yield viewer
    viewer.close()


@pytest.fixture(scope="module")
def page(viewer):
    with open_page(viewer.url) as page:
        time.sleep(1.0)
        yield page


def until(condition, seconds=90.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "timeout"
        time.sleep(0.1)


def picture(page):
    """The view between the panels (n, m, 3), 0 to 255."""
    return np.asarray(Image.open(io.BytesIO(page.screenshot())).convert("RGB")).astype(float)[:, 330:910]


def test_page_draws_the_scene_without_other_hosts(page):
    until(lambda: picture(page).std() > 20.0, 60.0)  # the page fades in
    middle = picture(page)
    red = (middle[..., 0] > 1.6 * middle[..., 1]) & (middle[..., 0] > 60.0)
    assert red.mean() > 0.01  # the organ
    assert page.strangers == []
    assert page.errors == []
    assert page.inner_text("#palpate-status") == "free"


def test_dragging_the_ball_moves_the_hand_and_the_force_changes(page, viewer):
    assert number(page, "force") == 0.0
    x, y = on_screen(page, viewer._server, viewer.control_panel.ball.position)
    page.mouse.move(x, y)
    page.mouse.down()
    for step in range(1, 9):
        page.mouse.move(x, y + 6 * step)
        time.sleep(0.05)
    page.mouse.up()
    until(lambda: number(page, "force") > 0.5)
    assert viewer.control_panel._source.controls.p_hand_offset_W[2] < -0.01
    assert number(page, "depth") > 1.0
    assert page.inner_text("#palpate-status") == "touching"


def test_drag_at_the_edge_of_the_ball_does_not_turn_the_camera_and_one_beside_it_does(page, viewer):
    camera = list(viewer._server.get_clients().values())[-1].camera
    turned = {}
    for aside in (25.0, 80.0):  # the ball is at least 60 pixels wide
        x, y = on_screen(page, viewer._server, viewer.control_panel.ball.position)
        before = np.array(camera.wxyz)
        page.mouse.move(x - aside, y)
        page.mouse.down()
        for step in range(1, 9):
            page.mouse.move(x - aside - 5 * step, y)
            time.sleep(0.05)
        page.mouse.up()
        time.sleep(1.0)
        turned[aside] = float(np.abs(np.array(camera.wxyz) - before).max())
    assert turned[25.0] < 1e-6
    assert turned[80.0] > 1e-3


def test_stiffness_slider_raises_the_force(page, viewer):
    before = number(page, "force")
    thumb = page.query_selector_all('[role="slider"]')[0]
    thumb.focus()
    for _ in range(10):
        page.keyboard.press("ArrowRight")
    until(lambda: viewer.control_panel._source.controls.stiffness_scale > 1.0)
    until(lambda: number(page, "force") > 1.05 * before)


def test_clutch_releases_the_hand_and_shows_it(page, viewer):
    page.get_by_label("clutch").click()
    until(lambda: viewer.control_panel._source.controls.clutch)
    until(lambda: "clutched" in page.inner_text("#palpate-status"))
    page.get_by_label("clutch").click()
    until(lambda: "clutched" not in page.inner_text("#palpate-status"))


def test_reset_restores_the_initial_state(page, viewer):
    page.get_by_text("Reset controls").click()
    until(lambda: number(page, "force") == 0.0)
    controls = viewer.control_panel._source.controls
    assert controls.stiffness_scale == 1.0
    np.testing.assert_array_equal(controls.p_hand_offset_W, 0.0)
    assert page.strangers == []
    assert page.errors == []


def test_a_scene_that_stands_still_is_drawn_a_sixth_as_often(monkeypatch):
    viewer, drawn = LiveViewer(FakeSession(), stage(), port=0), []
    viewer._stop.set()
    viewer._thread.join()  # this thread draws
    monkeypatch.setattr(viewer._drawing, "show", drawn.append)
    for moving, expected in ((False, 10), (True, 60)):
        drawn.clear()
        monkeypatch.setattr(type(viewer.picture), "still", property(lambda self, moving=moving: not moving))
        for frame in range(60):
            viewer._frame(frame)
        assert len(drawn) == expected
    viewer.close()


def test_busy_port_is_reported_with_a_remedy(viewer):
    port = viewer._server.get_port()
    with pytest.raises(PortError, match=f"port {port} cannot be used for the viewer") as caught:
        LiveViewer(FakeSession(), stage(), port=port)
    assert "--port 0" in str(caught.value)


def test_binds_to_this_machine_only(viewer):
    assert viewer.url.startswith("http://127.0.0.1:")


def test_a_browser_without_graphics_card_gets_the_light_picture_and_frames_arrive(page, viewer):
    until(lambda: viewer.picture.browsers)
    browser = next(iter(viewer.picture.browsers.values()))
    assert browser.software, browser
    assert viewer.picture.light
    assert viewer._drawing._organs[0].is_light or len(viewer._stage.objects[0].triangles) <= 4000
    frame = "window.__viserTestpoints.rendererInfo.render.frame"
    assert not page.evaluate("document.querySelector('canvas[data-engine]').getContext('webgl2')"
                             ".getContextAttributes().antialias")  # fmt: skip
    before = page.evaluate(frame)
    until(lambda: page.evaluate(frame) > before + 3)
    assert 0 < browser.width < 1200
