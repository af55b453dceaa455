"""A hand in front of a headset: an emulated WebXR device in a real browser leads the tool, and vibrates."""

import contextlib
import json
import time

import numpy as np
import pytest

pytest.importorskip("viser", reason="the viewer is not installed")

from browser import open_page

from palpate.base.errors import DeviceError
from palpate.devices import webxr
from palpate.devices.buttons import CAMERA, CLUTCH, OWN, TABLE
from palpate.scene import Scene
from palpate.session import Session
from palpate.viewer import LiveViewer, stage_of, xr
from palpate.viewer.server import close_server, open_server

K, SCALE = 400.0, 0.5
SCENE = {
    "objects": [{"name": "plane", "plane": {}, "stiffness": K, "damping": 0.0}],
    "contact": {"radius": 0.002},
    "mapping": {"scale": SCALE},
    "operator": {"path": [{"t": 0.0, "xyz": [0.0, 0.0, 0.012]}, {"t": 1.0, "xyz": [0.0, 0.0, 0.012]}]},
    "arms": {"leader": {"driver": "webxr"}},
}
START = [0.1, 1.2, -0.3]  # of the emulated controller: x right, y up, z towards the user [m]

EMULATOR = """
(() => {  // a minimal emulator of the parts of WebXR that three.js and the page use
  const at = { p: START, goal: START, q: [0, 0, 0, 1], trigger: 0, squeeze: false, tracked: true, pulses: [] };
  window.emulated = at;
  const point = (v) => ({ x: v[0], y: v[1], z: v[2], w: v.length > 3 ? v[3] : 1 });
  const transform = () => ({ position: point(at.p), orientation: point(at.q), matrix: new Float32Array(16) });
  const glide = () => {  // a hand does not jump: 2 mm a frame at most
    const way = at.goal.map((x, i) => x - at.p[i]), d = Math.hypot(...way);
    at.p = at.p.map((x, i) => x + way[i] * Math.min(1, 0.002 / (d || 1)));
  };
  const space = { getOffsetReferenceSpace: () => space };
  const button = (pressed, value) => ({ pressed, value, touched: pressed });
  const source = {
    handedness: "right", gripSpace: {}, targetRaySpace: {}, hand: null, targetRayMode: "tracked-pointer", profiles: [],
    gamepad: {
      get buttons() { return [button(at.trigger > 0.5, at.trigger), button(at.squeeze, at.squeeze ? 1 : 0)]; },
      axes: [], hapticActuators: [{ pulse: (strength, ms) => at.pulses.push([strength, ms]) }],
    },
  };
  class Session extends EventTarget {
    constructor() {
      super();
      Object.assign(this, { inputSources: [source], renderState: {}, ended: false, visibilityState: "visible",
        enabledFeatures: [], environmentBlendMode: "opaque" });
    }
    updateRenderState(state) { Object.assign(this.renderState, state); }
    async requestReferenceSpace() { return space; }
    requestAnimationFrame(callback) {
      const wait = callback.name === "step" ? 20 : 1000; // the renderer's own frames, by software, take the processor
      return setTimeout(() => this.ended || (wait < 1000 && glide(), false) || callback(performance.now(), {
        session: this, getPose: () => (at.tracked ? { transform: transform(), emulatedPosition: false } : null),
        getJointPose: () => null, getViewerPose: () => null,
      }), wait);
    }
    cancelAnimationFrame(id) { clearTimeout(id); }
    async end() { this.ended = true; this.dispatchEvent(new Event("end")); }
  }
  window.XRWebGLLayer = class {
    constructor() { Object.assign(this, { framebuffer: null, framebufferWidth: 64, framebufferHeight: 64 }); }
    getViewport() { return { x: 0, y: 0, width: 32, height: 64 }; }
  };
  window.XRWebGLBinding = undefined;
  WebGL2RenderingContext.prototype.makeXRCompatible = async () => {};
  window.XRRigidTransform = class {};
  const xr = { requestSession: async () => new Session(), isSessionSupported: async () => true, addEventListener() {} };
  Object.defineProperty(navigator, "xr", { value: xr });
})();
""".replace("START", json.dumps(START))


def message(**changes):
    return {"hand": "right", "tracked": True, "p": START, "q": [0, 0, 0, 1], "pinch": 0.0, "buttons": {}, **changes}


@pytest.fixture
def driver():
    webxr.PAGES.add(-1)
    made = webxr.WebXR()
    made.force_cap = 2.0
    made.open()
    yield made
    made.close()
    webxr.PAGES.discard(-1)


def test_a_pose_of_the_page_is_one_of_the_base(driver):
    """x stays, up is z, and towards the user is minus y, for positions and for rotations."""
    s = np.sin(0.15)
    assert xr.take(json.dumps(message(p=[0.1, 0.2, 0.3], q=[0.0, s, 0.0, np.cos(0.15)])))
    X = np.asarray(driver.read().X)
    assert X[:3, 3] == pytest.approx([0.1, -0.3, 0.2])
    about_z = np.array([[np.cos(0.3), -np.sin(0.3), 0], [np.sin(0.3), np.cos(0.3), 0], [0, 0, 1]])
    assert X[:3, :3] == pytest.approx(about_z), "a turn about the vertical"


def own(name):
    """The bit of a headset's own button."""
    return 1 << OWN + list(TABLE["webxr"]).index(name)


def test_pinch_and_buttons(driver):
    xr.take(json.dumps(message(pinch=1.0, buttons={"upper": True, "squeeze": False, "new": True})))
    reading = driver.read()
    assert (reading.gripper, reading.buttons) == (0.0, CAMERA | own("upper"))
    xr.take(json.dumps(message(pinch=0.25, buttons={"squeeze": True})))
    reading = driver.read()
    assert (reading.gripper, reading.buttons) == (pytest.approx(0.375), CLUTCH | own("squeeze"))


def test_a_hand_that_is_not_tracked_is_a_pressed_clutch(driver):
    assert driver.read().buttons & CLUTCH, "before the first pose"
    xr.take(json.dumps(message(p=[0.2, 1.0, 0.0])))
    assert not driver.read().buttons & CLUTCH
    xr.take(json.dumps({"hand": "right", "tracked": False}))
    reading = driver.read()
    assert reading.buttons & CLUTCH
    assert np.asarray(reading.X)[0, 3] == 0.2, "it stays where it was"
    xr.take(json.dumps(message()))
    time.sleep(webxr.STALE + 0.02)
    assert driver.read().buttons & CLUTCH, "the page has stopped"


BAD = [
    b"", b"[", b"[" * 2000, b"3", b"null", b"x" * 5000, json.dumps({"hand": "right", "tracked": True}),
    *(json.dumps(message(**wrong)) for wrong in (
        {"hand": "third"}, {"hand": [1]}, {"p": [1, 2]}, {"p": [1, 2, "3x"]}, {"p": [1, 2, 30]}, {"q": [0, 0, 0, 2]},
        {"p": [float("nan"), 0, 0]}, {"pinch": 2.0}, {"pinch": None}, {"buttons": 3},
    )),
]  # fmt: skip


@pytest.mark.parametrize("text", BAD, ids=range(len(BAD)))
def test_messages_that_are_not_valid_change_nothing(driver, text):
    xr.take(json.dumps(message()))
    before = np.asarray(driver.read().X).copy()
    assert not xr.take(text)
    assert np.array_equal(driver.read().X, before)


def test_the_controller_vibrates_by_the_force_over_its_cap(driver):
    feed = webxr.FEEDS["right"]
    for force, strength in ((0.0, 0.0), (1.0, 0.5), (2.0, 1.0), (9.0, 1.0)):
        driver.write(np.array([0.0, 0.0, force, 0.0, 0.0, 0.0]))
        assert feed.vibration == pytest.approx(strength)
    driver.close()
    assert feed.vibration == 0.0


def test_without_a_viewer_and_with_an_unknown_hand_it_is_refused(driver, monkeypatch):
    with pytest.raises(DeviceError, match="leads already"):
        webxr.WebXR().open()
    with pytest.raises(DeviceError, match="no hand 'third'"):
        webxr.WebXR("third")
    monkeypatch.setattr(webxr, "PAGES", set())  # viewers of other tests may still be open
    with pytest.raises(DeviceError, match="no viewer is open"):
        webxr.WebXR("left").open()


def wait(true, words, most=60.0):
    end = time.monotonic() + most
    while not true():
        assert time.monotonic() < end, words
        time.sleep(0.02)


@contextlib.contextmanager
def led():
    server = open_server("127.0.0.1", 0, "scene")
    session = Session(Scene.model_validate(SCENE))
    session.start()
    viewer = LiveViewer(session, stage_of(session.rig), server=server)
    try:
        yield session, viewer
    finally:
        session.close()
        viewer.close()
        close_server(server)


@pytest.mark.long
def test_an_emulated_headset_in_a_browser_leads_the_tool_and_vibrates(monkeypatch):
    monkeypatch.setattr(webxr, "STALE", 5.0)  # a busy browser; a lost hand is told by a message
    small = {"size": (300, 200), "ready": "canvas[data-engine]"}  # drawn by software
    with led() as (session, viewer), open_page(viewer.url, script=EMULATOR, **small) as page:
        page.wait_for_function("window.palpateXR.hands.length")
        tip = lambda: np.array(session.latest()["p_WT"])  # noqa: E731
        start = tip()
        page.evaluate("document.getElementById('palpate-xr').click()")
        page.wait_for_function("window.palpateXR.presenting || window.palpateXR.error")
        assert page.evaluate("window.palpateXR.error") == ""
        move = "(p) => { window.emulated.goal = p; }"
        wait(lambda: webxr.FEEDS["right"].tracked, "poses come")
        time.sleep(0.3)
        page.evaluate(move, [START[0] + 0.02, START[1], START[2]])
        wait(lambda: abs(tip()[0] - start[0] - SCALE * 0.02) < 1e-4, "right")
        page.evaluate(move, [START[0] + 0.02, START[1], START[2] - 0.01])
        wait(lambda: abs(tip()[1] - start[1] - SCALE * 0.01) < 1e-4, "away")
        page.evaluate(move, [START[0] + 0.02, START[1] - 0.03, START[2] - 0.01])
        wait(lambda: float(session.latest()["contacts"]) > 0, "down, onto the plane")
        wait(lambda: page.evaluate("window.emulated.pulses.length") > 3, "it vibrates")
        cap = session.scene.stability.force_cap
        strength, ms = page.evaluate("window.emulated.pulses.at(-1)")
        assert strength == pytest.approx(session.state.force / cap, abs=0.05)
        assert 0.0 < strength <= 1.0
        assert ms <= 50
        page.evaluate("window.emulated.tracked = false")
        wait(lambda: session.state.force == 0.0, "a lost hand is let go")
        held = tip()
        page.evaluate(move, [START[0] + 0.06, START[1], START[2]])
        time.sleep(1.0)
        assert tip() == pytest.approx(held, abs=1e-4), "the tool stays"
        page.evaluate("document.getElementById('palpate-xr').click()")
        page.wait_for_function("!window.palpateXR.presenting")
        assert not page.errors, page.errors
