"""Sliders keep a width in a small window: a short label beside a slider leaves it none."""

import pytest
from browser import open_page, small_scene

from palpate.scene import Scene
from palpate.session import Session
from palpate.viewer import LiveViewer, stage_of

WIDTHS = "[...document.querySelectorAll('.mantine-Slider-track')].map(e => e.getBoundingClientRect().width)"


@pytest.mark.parametrize("guided", [False, True])
def test_sliders_of_a_small_window_can_be_moved(guided):
    scene = Scene.load("guided") if guided else small_scene()
    session = Session(scene)
    viewer = LiveViewer(session, stage_of(session.rig), port=0, runner=session)
    try:
        with open_page(viewer.url, (800, 600)) as page:
            page.wait_for_function(f"{WIDTHS}.length >= 3")
            page.wait_for_timeout(1000)
            widths = page.evaluate(WIDTHS)
            assert min(width for width in widths) >= 40.0, widths
    finally:
        viewer.close()
        session.close()
