"""Sliders keep a width in any window, and nothing of the panels is cut off."""

import pytest
from browser import open_page, small_scene

from palpate.scene import Scene
from palpate.session import Session
from palpate.viewer import LiveViewer, stage_of

WIDTHS = "[...document.querySelectorAll('.mantine-Slider-track')].map(e => e.getBoundingClientRect().width)"
EDGES = (
    "[...document.querySelectorAll('input')].map(e => e.getBoundingClientRect()).filter(r => r.width > 0)"
    ".map(r => r.right)"
)
CUT = (  # how far the contents of a panel reach beyond it
    "[...document.querySelectorAll('.mantine-ScrollArea-viewport')].filter(e => e.clientWidth > 0)"
    ".map(e => e.scrollWidth - e.clientWidth)"
)


@pytest.mark.parametrize(
    ("name", "size", "least"),
    [
        ("guided", (800, 600), 40.0),
        ("tray_cubes", (800, 600), 40.0),
        ("palpation", (1190, 800), 60.0),
        ("palpation", (1210, 800), 60.0),
        ("palpation", (1440, 900), 60.0),
    ],
)
def test_sliders_can_be_moved_and_numbers_are_whole(name, size, least):
    """A short label beside a slider left it no width in a small window; a usual one was taken for a small one."""
    if name == "tray_cubes":
        pytest.importorskip("mujoco")
    session = Session(small_scene() if name == "palpation" else Scene.load(name))
    viewer = LiveViewer(session, stage_of(session.rig), port=0, runner=session)
    try:
        with open_page(viewer.url, size) as page:
            page.wait_for_function(f"{WIDTHS}.length >= 3")
            page.wait_for_timeout(2500)  # the window has been reported
            widths = page.evaluate(WIDTHS)
            assert min(widths) >= least, widths
            assert max(page.evaluate(EDGES)) <= size[0]
            assert max(page.evaluate(CUT)) <= 1
    finally:
        viewer.close()
        session.close()
