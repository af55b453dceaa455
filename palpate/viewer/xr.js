// A hand of a headset as the leader (driver webxr): a button begins an immersive session, whose frames give the pose and
// the pinch of each hand. The viewer's own picture is shown in the headset, drawn by the page's renderer.
(() => {
  const AT = { x: 0, y: 1.0, z: -0.5 }; // of the scene's origin, from the floor under the user [m]
  const CLOSED = 0.015, OPEN = 0.08; // distance of thumb and finger at a closed and at an open pinch [m]
  const AGAIN = 2000; // ms between two attempts to reach the server
  const state = (window.palpateXR = { hands: [], presenting: false, sent: 0, vibration: {}, error: "" });
  let renderer = null, socket = null, session = null, space = null, button = null;

  // three.js announces each renderer to its developer tools: the only way to the one of the page
  const tools = (window.__THREE_DEVTOOLS__ = window.__THREE_DEVTOOLS__ || new EventTarget());
  tools.addEventListener("observe", (event) => {
    if (event.detail && event.detail.isWebGLRenderer) renderer = event.detail;
  });

  const connect = () => {
    socket = new WebSocket(location.origin.replace(/^http/, "ws") + "/xr");
    socket.onmessage = (event) => {
      state.vibration = JSON.parse(event.data).vibration;
      state.hands = Object.keys(state.vibration);
      show();
      vibrate();
    };
    socket.onclose = () => {
      state.hands = [];
      show();
      setTimeout(connect, AGAIN);
    };
  };

  const show = () => {
    if (!button && document.body) {
      button = document.createElement("button");
      button.id = "palpate-xr";
      button.style.cssText = "position:fixed;left:50%;bottom:16px;transform:translateX(-50%);z-index:1000;" +
        "padding:10px 18px;font-size:15px;border:0;border-radius:6px;background:#306082;color:#fff;cursor:pointer";
      button.onclick = () => (session ? session.end() : begin().catch((error) => (state.error = String(error))));
      document.body.appendChild(button);
    }
    if (!button) return;
    button.style.display = state.hands.length && navigator.xr ? "block" : "none";
    button.textContent = session ? "leave the headset" : `lead with the ${state.hands.join(" and the ")} hand in a headset`;
  };

  const begin = async () => {
    state.error = "";
    const wanted = { optionalFeatures: ["local-floor", "hand-tracking"] };
    const made = await navigator.xr.requestSession("immersive-vr", wanted);
    made.addEventListener("end", () => {
      session = null;
      state.presenting = false;
      for (const hand of state.hands) send({ hand, tracked: false });
      show();
    });
    renderer.xr.enabled = true;
    await renderer.xr.setSession(made);
    space = await made.requestReferenceSpace("local-floor").catch(() => made.requestReferenceSpace("local"));
    renderer.xr.setReferenceSpace(space.getOffsetReferenceSpace(new XRRigidTransform(AT)));
    session = made;
    state.presenting = true;
    show();
    session.requestAnimationFrame(step);
  };

  const send = (message) => {
    if (!socket || socket.readyState !== WebSocket.OPEN || socket.bufferedAmount > 4096) return;
    socket.send(JSON.stringify(message));
    state.sent += 1;
  };

  const step = (_, frame) => {
    if (!session) return;
    session.requestAnimationFrame(step);
    for (const hand of state.hands) {
      const source = [...session.inputSources].find((one) => one.handedness === hand);
      const measured = source && (source.hand ? fingers(frame, source.hand) : controller(frame, source));
      send(measured ? { hand, tracked: true, ...measured } : { hand, tracked: false });
    }
  };

  const xyz = (v) => [v.x, v.y, v.z];
  const away = (a, b) => Math.hypot(a.x - b.x, a.y - b.y, a.z - b.z);
  const closed = (d) => Math.min(1, Math.max(0, (OPEN - d) / (OPEN - CLOSED)));

  // Position between the tips of thumb and index finger, orientation of the wrist.
  const fingers = (frame, hand) => {
    const names = ["wrist", "thumb-tip", "index-finger-tip", "middle-finger-tip"];
    const poses = names.map((name) => hand.get(name) && frame.getJointPose(hand.get(name), space));
    if (!poses.every((pose) => pose)) return null;
    const [wrist, thumb, index, middle] = poses.map((pose) => pose.transform);
    const [a, b] = [thumb.position, index.position], q = wrist.orientation;
    return {
      p: [0.5 * (a.x + b.x), 0.5 * (a.y + b.y), 0.5 * (a.z + b.z)], q: [q.x, q.y, q.z, q.w],
      pinch: closed(away(a, b)), buttons: { squeeze: away(a, middle.position) < CLOSED + 0.005 },
    };
  };

  const controller = (frame, source) => {
    const pose = source.gripSpace && frame.getPose(source.gripSpace, space);
    if (!pose || pose.emulatedPosition) return null;
    const q = pose.transform.orientation, keys = source.gamepad ? source.gamepad.buttons : [];
    const down = (i) => Boolean(keys[i] && keys[i].pressed);
    return {
      p: xyz(pose.transform.position), q: [q.x, q.y, q.z, q.w], pinch: keys[0] ? Math.min(1, Math.max(0, keys[0].value)) : 0,
      buttons: { squeeze: down(1), lower: down(4), upper: down(5) },
    };
  };

  const vibrate = () => {
    if (!session) return;
    for (const source of session.inputSources) {
      const strength = state.vibration[source.handedness] || 0, pad = source.gamepad;
      const motor = pad && ((pad.hapticActuators && pad.hapticActuators[0]) || pad.vibrationActuator);
      if (strength > 0 && motor && motor.pulse) motor.pulse(strength, 50);
    }
  };

  window.addEventListener("DOMContentLoaded", connect);
})();
