"""Frames per second of the viewer in a headless browser that renders by software, beside those of an empty page.

A picture at rest is not drawn, and many scenes last no longer than a page needs to load: the hand is therefore moved
by `SWAY` besides its path, as a person does who drags it.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from palpate import _core
from palpate_lab.verify.bench.browser import Page, open_browser

if TYPE_CHECKING:
    from palpate.session import Session

_RATE = 1000.0  # of the bare loop [Hz]
SETTLE = 12.0
"""Time in which the picture finds its resolution before the measurement [s]."""
SWAY, SWAY_PERIOD = 0.004, 3.0
"""Displacement of the hand [m], and its period [s]."""
_STEP = 1.0 / 60.0  # between two displacements [s]
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
        with shown(scene, quality) as (url, updates, missed):
            page.open(url + (f"?scale={scale}" if scale else ""), size)
            page.wait_for(READY)
            on_progress(f"{scene}: the picture finds its resolution ({settle:g} s)")
            time.sleep(settle)
            before, sent, late, began = page.processor_seconds(), updates(), missed(), time.monotonic()
            found = page.evaluate(_FRAMES % (1e3 * duration))
            spent = time.monotonic() - began
            after, sent, late = page.processor_seconds(), updates() - sent, missed() - late
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
        **_rates(found["times"], duration),
        "updates_per_s": sent / spent,
        "missed_per_s": late / spent,
        "processor_ms_per_frame": {
            name: 1e3 * (after[name] - before.get(name, 0.0)) / frames for name in ("GPU", "renderer") if name in after
        },
        "control": control,
    }


def _rates(times: list[float], duration: float) -> dict[str, float]:
    """Frames per second: mean over the duration [s], of the median frame, and of the slowest one.

    times: of the frames [ms].
    """
    gaps = np.diff(times)
    mean = len(times) / duration
    if not len(gaps):
        return {"fps": mean, "fps_p50": mean, "fps_worst": mean}
    return {"fps": mean, "fps_p50": 1e3 / float(np.median(gaps)), "fps_worst": 1e3 / float(gaps.max())}


def _control(page: Page, size: tuple[int, int], drawn: tuple[int, int], duration: float) -> dict[str, float]:
    """Rates of a page that only clears a canvas of the same size, beside a loop that only keeps time."""
    page.open("about:blank", size)
    time.sleep(0.5)
    loop = _core.BareLoop(_RATE)
    before, began = page.processor_seconds(), time.monotonic()
    loop.start()
    found = page.evaluate(_CONTROL % (*size, *drawn, 1e3 * duration))
    loop.stop()
    spent, late = page.processor_seconds()["GPU"] - before["GPU"], int(loop.timing()["missed_ticks"])
    frames = max(len(found["times"]), 1)
    return _rates(found["times"], duration) | {
        "processor_ms_per_frame": 1e3 * spent / frames,
        "missed_per_s": late / (time.monotonic() - began),
    }


@contextmanager
def shown(scene: str, quality: str) -> Iterator[tuple[str, Callable[[], int], Callable[[], int]]]:
    """Runs a scene in real time in the viewer; yields the address, and the updates sent and ticks missed so far."""
    from palpate.scene import Scene
    from palpate.session import PairsSession, Session
    from palpate.viewer import LiveViewer, stage_of
    from palpate.viewer.pairs import PairsViewer

    given = Scene.load(scene)
    session: Session | PairsSession
    viewer: LiveViewer | PairsViewer
    loops: list[Session]
    if given.pairs:
        session = PairsSession(given)
        stages = {name: stage_of(rig, name) for name, rig in session.rigs.items()}
        viewer = PairsViewer(session.pairs, stages, given.title, session, session, port=0)
        loops = list(session.pairs.values())
    else:
        session = Session(given)
        viewer = LiveViewer(session, stage_of(session.rig), port=0)
        loops = [session]
    viewer.picture.choose(quality)
    stop = threading.Event()
    swaying = threading.Thread(target=_sway, args=(loops, stop), daemon=True)
    try:
        session.start()
        swaying.start()
        yield viewer.url, lambda: viewer.frames, lambda: sum(int(one.timing["missed_ticks"]) for one in loops)
    finally:
        stop.set()
        session.stop()
        viewer.close()


def _sway(loops: list[Session], stop: threading.Event) -> None:
    """Move the hands about their paths until `stop`."""
    began = time.monotonic()
    while not stop.wait(_STEP):
        turn = 2.0 * np.pi * (time.monotonic() - began) / SWAY_PERIOD
        for one in loops:
            one.change(p_hand_offset_W=SWAY * np.array([np.sin(turn), np.cos(turn) - 1.0, np.sin(2.0 * turn)]))


def table(found: list[dict[str, Any]]) -> str:
    """The figures as text."""
    lines = []
    for one in found:
        control, spent = one["control"], one["processor_ms_per_frame"]
        lines += [
            f"{one['scene']}: {one['quality']} picture, {one['drawn'][0]} x {one['drawn'][1]} of a window of "
            f"{one['size'][0]} x {one['size'][1]}, {one['triangles']} triangles, {one['draw_calls']} draw calls",
            f"  {one['fps']:6.1f} frames/s; p50 {one['fps_p50']:.1f}, worst {one['fps_worst']:.1f}; "
            f"{one['updates_per_s']:.1f} updates/s; {one['missed_per_s']:.1f} missed ticks/s of the loops, "
            f"{control['missed_per_s']:.1f} of a bare loop beside the empty page",
            f"  {spent['GPU']:6.1f} ms of processor a frame to draw, {spent['renderer']:.1f} ms in the page",
            f"  {control['fps']:6.1f} frames/s of an empty page (control), "
            f"{control['processor_ms_per_frame']:.1f} ms of processor a frame",
        ]
    return "\n".join([*lines, f"renderer: {found[0]['renderer']}"])
