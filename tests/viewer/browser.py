"""A headless Chromium with a viewer's page, and screen coordinates of points."""

import shutil
from contextlib import contextmanager

import numpy as np
import pytest
from viser.transforms import SO3

from palpate import Scene

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
HARMLESS = "passive event listener"  # a warning of Chromium about the slider of the widget library
FLAGS = [
    "--headless=new",
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-quic",
    "--no-first-run",
]

# The page draws at every frame that the browser offers, and each frame by software costs 30 ms of both cores or more.
FEW_FRAMES = """
const frame = window.requestAnimationFrame.bind(window);
window.requestAnimationFrame = (draw) => setTimeout(() => frame(draw), 150);
"""


def small_scene():
    """The shipped scene with an organ of 6000 triangles, because rendering by software is slow."""
    scene = Scene.load("palpation")
    first = scene.objects[0].model_copy(update={"triangles": 6000})
    return scene.model_copy(update={"objects": (first,)})


@contextmanager
def open_page(url, size=(1200, 500), ready="#palpate-force", script=""):
    """The page after a script; `page.strangers` collects requests to other hosts, `page.errors` errors."""
    if CHROMIUM is None:
        pytest.skip("Chromium is not installed (Debian: apt-get install chromium), so the viewer is not tested")
    api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed (uv sync --group test)")
    with api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        page = browser.new_page(viewport={"width": size[0], "height": size[1]})
        page.set_default_timeout(90_000)  # software rendering on a busy machine
        page.add_init_script(FEW_FRAMES + script)
        page.strangers, page.errors = [], []
        own = (url, url.replace("http", "ws", 1), "data:", "blob:")
        page.on("request", lambda r: None if r.url.startswith(own) else page.strangers.append(r.url))
        complaint = lambda m: m.type == "error" and HARMLESS not in m.text  # noqa: E731
        page.on("console", lambda m: page.errors.append(m.text) if complaint(m) else None)
        page.on("pageerror", lambda e: page.errors.append(str(e)))
        page.goto(url)
        page.wait_for_selector(ready, state="attached")
        yield page
        browser.close()


def number(page, name):
    """The number of a read-out, e.g. `force` [N]."""
    return float(page.inner_text(f"#palpate-{name}").split()[0])


def on_screen(page, server, p_W):
    """Pixel (x, y) of a point p_W (3,) [m], by the camera of the newest client."""
    camera = list(server.get_clients().values())[-1].camera
    x, y, z = SO3(np.array(camera.wxyz)).as_matrix().T @ (np.asarray(p_W) - camera.position)
    box = page.query_selector("canvas[data-engine]").bounding_box()
    f = 0.5 * box["height"] / np.tan(0.5 * camera.fov)
    return box["x"] + 0.5 * box["width"] + f * x / z, box["y"] + 0.5 * box["height"] + f * y / z
