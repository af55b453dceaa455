// Runs before the scripts of the page: makes the picture light where the browser renders without a graphics card.
//
// A light picture has no multisampling, at most 30 frames/s, and a resolution that is adapted to the measured frame
// rate; once the scene rests it is drawn again in full resolution. Materials and lights are the server's: the page
// reports what it found through a hidden text field.
(() => {
  const LEVELS = [1, 0.8, 0.64, 0.5, 0.4, 0.32]; // drawn pixels per pixel of the page
  const START = 3; // first level
  const ENOUGH = 26, AMPLE = 29, SLOW = 12; // frames/s: below, less resolution; above, more; too slow for a full picture
  const WINDOW = 2000; // ms of a measurement
  const AGAIN = 60000; // ms before a level that was too slow is tried again
  const REST = 400; // ms without a motion of the camera after which a scene that stands still is drawn sharp
  const CAP = 30; // ms between two frames of a light picture: every second one of a 60 Hz screen

  const context = document.createElement("canvas").getContext("webgl2");
  const info = context && context.getExtension("WEBGL_debug_renderer_info");
  const renderer = context ? String(context.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : context.RENDERER)) : "none";
  if (context && context.getExtension("WEBGL_lose_context")) context.getExtension("WEBGL_lose_context").loseContext();
  const software = /swiftshader|llvmpipe|softpipe|software|basic render/i.test(renderer);
  const state = { renderer, software, slow: false, light: software, fps: 0, scale: 1, width: 0, height: 0, antialias: !software };
  let field = "", mode = "automatic", level = START, ample = 0, still = false, resting = false;
  const blocked = LEVELS.map(() => 0);
  const fixed = parseFloat(new URLSearchParams(location.search).get("scale")); // of the address: no adaptation
  const light = () => (mode === "automatic" ? state.software || state.slow : mode === "light");

  const getContext = HTMLCanvasElement.prototype.getContext;
  HTMLCanvasElement.prototype.getContext = function (kind, options) {
    const plain = software && String(kind).startsWith("webgl")
      ? { ...options, antialias: false, preserveDrawingBuffer: false } // the buffer is kept by copying it
      : options;
    return getContext.call(this, kind, plain);
  };

  const request = window.requestAnimationFrame.bind(window), cancel = window.cancelAnimationFrame.bind(window);
  const waiting = new Map(); // identifier that the page knows -> that of the present request
  let last = 0;
  window.requestAnimationFrame = (callback) => {
    const step = (t) => {
      if (light() && t !== last && t - last < CAP) return waiting.set(id, request(step));
      last = t;
      waiting.delete(id);
      return callback(t);
    };
    const id = request(step);
    waiting.set(id, id);
    return id;
  };
  window.cancelAnimationFrame = (id) => {
    cancel(waiting.has(id) ? waiting.get(id) : id);
    waiting.delete(id);
  };

  const points = () => window.__viserTestpoints;
  const setLevel = (to) => {
    level = Math.min(Math.max(to, 0), LEVELS.length - 1);
    ample = 0;
  };
  const adapt = (fps, now) => {
    state.slow = state.slow || (!light() && fps < SLOW);
    if (!light()) return;
    if (fps < ENOUGH) {
      blocked[level] = now + AGAIN;
      setLevel(level + 1);
    } else if (fps >= AMPLE && level > 0 && blocked[level - 1] < now && ++ample >= 3) setLevel(level - 1);
  };
  const dismiss = () => {
    // the library's warning about software rendering covers the scene; the folder "Picture" says the same
    for (const note of document.querySelectorAll(".mantine-Notification-root"))
      if (note.textContent.includes("Software WebGL")) note.querySelector("button")?.click();
  };
  const resolve = () => {
    const scale = fixed || (light() ? (resting ? 1 : LEVELS[level]) : null);
    state.scale = scale || window.devicePixelRatio;
    points().devSettings.set({ fixedDpr: scale });
  };
  const report = () => {
    dismiss();
    const canvas = document.querySelector("canvas[data-engine]");
    if (canvas) [state.width, state.height] = [canvas.width, canvas.height];
    state.window = innerWidth;
    state.light = light();
    resolve();
    const send = window.__viserMutable && window.__viserMutable.sendMessage;
    if (send && field) send({ type: "GuiUpdateMessage", uuid: field, updates: { value: JSON.stringify(state) } });
  };

  const eye = () => window.__viserMutable?.camera?.matrixWorld.elements.join(); // pose of the camera
  let seen = "", moved = 0;
  let began = 0, before = 0, frame = -1, frames = 0, busy = 0, idle = 9;
  const watch = (t) => {
    request(watch);
    if (!points()) return;
    idle += 1;
    if (points().rendererInfo.render.frame !== frame) {
      if (idle <= 3 && !resting) [frames, busy] = [frames + 1, busy + t - before]; // a scene at rest is still, not slow
      [frame, before, idle] = [points().rendererInfo.render.frame, t, 0];
    }
    const now = eye();
    if (now !== seen) [seen, moved] = [now, t];
    if (resting !== (still && t - moved > REST)) {
      resting = !resting;
      resolve();
    }
    if (t - began < WINDOW) return;
    if (frames >= 5) {
      state.fps = Math.round((1e4 * frames) / busy) / 10;
      if (began) adapt(state.fps, t);
    }
    [began, frames, busy] = [t, 0, 0];
    report();
  };
  request(watch);

  window.palpatePicture = {
    state,
    follow: (uuid, wanted, stands) => {
      [field, mode, still] = [uuid, wanted, stands];
      if (points()) report();
    },
  };
})();
