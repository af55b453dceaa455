"""Frames per second of the viewer in a headless browser that renders by software, beside those of an empty page."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from palpate.errors import PalpateError
from palpate.verify.bench.browser import Page, open_browser

SETTLE = 12.0
"""Time in which the picture finds its resolution before the measurement [s]."""
READY = "window.__viserTestpoints && window.__viserTestpoints.rendererInfo.render.frame > 5"
_FRAMES = """new Promise(done => {
  const info = window.__viserTestpoints.rendererInfo, began = performance.now(), times = [];
  let frame = info.render.frame;
  const look = t => {
    if (info.render.frame !== frame) { frame = info.render.frame; times.push(performance.now()); }
    if (performance.now() - began > %d) done({times, calls: info.render.calls, triangles: info.render.triangles,
      state: window.palpatePicture.state, css: [innerWidth, innerHeight]});
    else requestAnimationFrame(look);
  };
  requestAnimationFrame(look);
})"""
_CONTROL = """new Promise(done => {
  document.body.innerHTML = '<canvas style="position:fixed;left:0;top:0;width:%dpx;height:%dpx"></canvas>';
  const canvas = document.querySelector('canvas');
  [canvas.width, canvas.height] = [%d, %d];
  const gl = canvas.getContext('webgl2', {antialias: false, preserveDrawingBuffer: true});
  const began = performance.now(), times = [];
  const draw = t => {
    gl.clearColor((times.length %% 60) / 60, 0.5, 0.5, 1); gl.clear(gl.COLOR_BUFFER_BIT);
    times.push(performance.now());
    if (performance.now() - began > %d) done({times}); else requestAnimationFrame(draw);
  };
  requestAnimationFrame(draw);
})"""


def run(
    scene: str,
    size: tuple[int, int] = (1200, 700),
    duration: float = 10.0,
    quality: str = "automatic",
    scale: float | None = None,
    picture: Path | None = None,
    settle: float = SETTLE,
    on_progress: Callable[[str], None] = lambda text: None,
) -> dict[str, Any]:
    """The figures of a scene that runs in real time.

    Args:
        scene: scene file.
        size: width and height of the window [pixels].
        duration: time of the measurement [s].
        quality: of the picture: automatic, full or light.
        scale: drawn pixels per pixel of the page; None: as the page chooses.
        picture: PNG file of the page at the end; None: none.
        settle: time before the measurement [s].
        on_progress: called with what happens next.

    Raises:
        PalpateError: no browser, or it fails; SceneError, MissingExtraError: as for `palpate run`.
    """
    with open_browser() as page:
        on_progress(f"{scene}: loading")
        with shown(scene, quality) as (url, updates):
            page.open(url + (f"?scale={scale}" if scale else ""), size)
            page.wait_for(READY)
            on_progress(f"{scene}: the picture finds its resolution ({settle:g} s)")
            time.sleep(settle)
            before, sent, began = page.processor_seconds(), updates(), time.monotonic()
            found = page.evaluate(_FRAMES % (1e3 * duration))
            spent = time.monotonic() - began
            after, sent = page.processor_seconds(), updates() - sent
            if picture is not None:
                page.photograph(picture)
        state = found["state"]
        on_progress("an empty page of the same size")
        control = _control(page, size, (state["width"], state["height"]), min(duration, 5.0))
    frames = max(len(found["times"]), 1)
    return {
        "scene": scene,
        "renderer": state["renderer"],
        "quality": "light" if state["light"] else "full",
        "size": list(size),
        "drawn": [state["width"], state["height"]],
        "triangles": found["triangles"],
        "draw_calls": found["calls"],
        **_rates(found["times"]),
        "updates_per_s": sent / spent,
        "processor_ms_per_frame": {
            name: 1e3 * (after[name] - before.get(name, 0.0)) / frames for name in ("GPU", "renderer") if name in after
        },
        "control": control,
    }


def _rates(times: list[float]) -> dict[str, float]:
    """Frames per second: mean, of the median frame, and of the slowest one. times: of the frames [ms]."""
    gaps = np.diff(times)
    if len(gaps) < 2:
        raise PalpateError(
            "the browser drew no frames", why="the machine has no time for it, or the scene stands still"
        )
    return {"fps": 1e3 / gaps.mean(), "fps_p50": 1e3 / float(np.median(gaps)), "fps_worst": 1e3 / gaps.max()}


def _control(page: Page, size: tuple[int, int], drawn: tuple[int, int], duration: float) -> dict[str, float]:
    """Rates of a page that only clears a canvas of the same size."""
    page.open("about:blank", size)
    time.sleep(0.5)
    before = page.processor_seconds()
    found = page.evaluate(_CONTROL % (*size, *drawn, 1e3 * duration))
    spent = page.processor_seconds()["GPU"] - before["GPU"]
    return _rates(found["times"]) | {"processor_ms_per_frame": 1e3 * spent / len(found["times"])}


@contextmanager
def shown(scene: str, quality: str) -> Iterator[tuple[str, Callable[[], int]]]:
    """Runs a scene in real time in the viewer; yields the address, and the number of updates sent so far."""
    from palpate.scene import Scene
    from palpate.session import PairsSession, Session
    from palpate.viewer import LiveViewer, stage_of
    from palpate.viewer.pairs import PairsViewer

    given = Scene.load(scene)
    session: Session | PairsSession
    viewer: LiveViewer | PairsViewer
    if given.pairs:
        session = PairsSession(given)
        stages = {name: stage_of(rig, name) for name, rig in session.rigs.items()}
        viewer = PairsViewer(session.pairs, stages, given.title, session, session, port=0)
    else:
        session = Session(given)
        viewer = LiveViewer(session, stage_of(session.rig), port=0)
    viewer.picture.choose(quality)
    try:
        session.start()
        yield viewer.url, lambda: viewer.frames
    finally:
        session.stop()
        viewer.close()


def table(found: list[dict[str, Any]]) -> str:
    """The figures as text."""
    lines = []
    for one in found:
        control, spent = one["control"], one["processor_ms_per_frame"]
        lines += [
            f"{one['scene']}: {one['quality']} picture, {one['drawn'][0]} x {one['drawn'][1]} of a window of "
            f"{one['size'][0]} x {one['size'][1]}, {one['triangles']} triangles, {one['draw_calls']} draw calls",
            f"  {one['fps']:6.1f} frames/s; p50 {one['fps_p50']:.1f}, worst {one['fps_worst']:.1f}; "
            f"{one['updates_per_s']:.1f} updates/s",
            f"  {spent['GPU']:6.1f} ms of processor a frame to draw, {spent['renderer']:.1f} ms in the page",
            f"  {control['fps']:6.1f} frames/s of an empty page (control), "
            f"{control['processor_ms_per_frame']:.1f} ms of processor a frame",
        ]
    return "\n".join([*lines, f"renderer: {found[0]['renderer']}"])
