"""The right-hand panel and the ball to drag: all that the user can change while the session runs."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import numpy as np
import viser

from palpate.base.arrays import Array
from palpate.record.ticks import Ticks
from palpate.viewer.bodies import jaw_slider
from palpate.viewer.controls import set_value
from palpate.viewer.run_buttons import RunButtons, Runner
from palpate.viewer.source import Source
from palpate.viewer.stage import Stage

REACH = 0.12
"""Largest displacement of the hand from its path by the ball, along each axis [m]."""
BALL = 0.016
"""Smallest radius of the ball [m]."""
BALL_PIXELS = 64.0
"""Smallest width of the ball on the screen [pixels]."""
HAND = (245, 150, 30)
_TEXT = '<div style="padding:0 10px 6px 10px;font-size:12px;opacity:.8">{}</div>'


class HandBall:
    """The ball at the leader's handle; dragging it moves the hand."""

    def __init__(self, server: viser.ViserServer, stage: Stage, source: Source) -> None:
        """Adds the ball to the scene."""
        self._source, self._stage = source, stage
        self._offset, self._offset_grab, self._p_grab = np.zeros(3), np.zeros(3), np.zeros(3)
        led = stage.device is not None  # the hand is on the device
        self.ball = server.scene.add_icosphere("/hand", BALL, HAND, opacity=0.6, cast_shadow=False, visible=not led)
        self.ball.on_drag("left")(self._drag)
        self.ball.on_drag("left", modifier="shift")(self._drag)

    def show(self, tick: Ticks) -> None:
        """Moves the ball to the hand's intended position."""
        X_WL = self._stage.leader.X_WA
        self.ball.position = X_WL[:3, :3] @ tick["p_hand_L"] + X_WL[:3, 3]

    def resize_ball(self, server: viser.ViserServer, scale: Callable[[int], float] = lambda _: 1.0) -> None:
        """Keeps the ball at least `BALL_PIXELS` wide in every browser.

        scale: pixels drawn for a pixel of the window, by the number of a client.
        """
        radius = BALL
        for number, client in server.get_clients().items():
            camera = client.camera
            away = float(np.linalg.norm(np.asarray(camera.position) - self.ball.position))
            metres_per_pixel = 2.0 * away * np.tan(0.5 * camera.fov) / max(camera.image_height / scale(number), 1.0)
            radius = max(radius, 0.5 * BALL_PIXELS * metres_per_pixel)
        if abs(radius - self.ball.radius) > 0.05 * self.ball.radius:
            self.ball.radius = min(radius, 4.0 * BALL)

    def _grab(self) -> None:
        """A drag begins."""

    def _send(self) -> None:
        """Sends the displacement of the hand to the loop."""
        controls = self._source.controls
        controls.p_hand_offset_W = self._offset
        self._source.controls = controls

    async def _drag(self, event: viser.SceneNodeDragEvent[viser.IcosphereHandle]) -> None:
        """Moves the hand with the pointer: up, down and across, or level with the table while shift is held."""
        p_W = np.array(event.end_position)
        if event.phase == "start":
            self._grab()
            self._p_grab, self._offset_grab = np.array(event.start_position), self._offset
        eye = np.array(event.client.camera.position)
        if event.modifier == "shift":
            p_W = _on_level(eye, p_W, float(self._p_grab[2]))
        else:
            p_W = upright(eye, p_W, self._p_grab)
        self._offset = np.clip(self._offset_grab + p_W - self._p_grab, -REACH, REACH)
        self._send()


class ControlPanel(HandBall):
    """Sliders, pedal, buttons, and the ball at the leader's handle; each change sends new `Controls` to the loop."""

    def __init__(self, server: viser.ViserServer, stage: Stage, source: Source, runner: Runner | None = None) -> None:
        """Fills the main panel, docks it on the right, and adds the ball to the scene."""
        self._lock = threading.Lock()
        super().__init__(server, stage, source)
        gui = server.gui
        gui.set_panel_label(stage.title)
        with gui.add_folder("Hand"):
            smaller = f"The instrument makes the motion {1 / stage.motion_scale:.3g} times smaller"
            drag = (
                "Drag the orange ball at the master's handle to move the hand: up, down and across, and level with the "
                f"table while you hold shift. {smaller}, and what it touches pushes the hand back."
            )
            led = None if stage.device is None else f"Move the hand on the device ({stage.device.name}). {smaller}."
            gui.add_html(_TEXT.format(led or drag))
            hint = "Off: the hand stops on the scene's path"
            self.path = gui.add_checkbox("follow the path", True, hint=hint, visible=led is None)
            if getattr(source, "world", None) is not None:
                self.jaws = jaw_slider(gui, self._pinch)
            self.clutch = gui.add_checkbox("clutch", False, hint="Clutch pedal: the hand moves, the instrument stays")
            self.pedals: dict[str, viser.GuiCheckboxHandle] = {"clutch": self.clutch}
            if hasattr(source, "console"):
                hint = "Camera pedal: the hand moves the endoscope, the instrument stays"
                self.pedals["camera"] = gui.add_checkbox("camera", False, hint=hint)
                self.pedals["coag"] = gui.add_checkbox("coag", False, hint="Coagulation pedal, for programs")
        with gui.add_folder("Tissue"):
            self.stiffness = _slider(gui, "stiffness [N/m]", stage.stiffness)
            self.damping = _slider(gui, "damping [N s/m]", stage.damping)
        with gui.add_folder("Run"):
            self.run = RunButtons(gui, runner, bool(getattr(source, "recording", False)))
            self.pause = self.run.pause
            self.reset = gui.add_button("Reset controls", hint="Hand, tissue and run as at the start")
        gui.main_panel.dock_right()
        gui.main_panel.set_width(280)
        for box in (self.path, *self.pedals.values(), self.pause):
            box.on_update(lambda _: self._send())
        for knob in (self.stiffness, self.damping):
            knob.on_update(lambda _: self._send())
        self.reset.on_click(lambda _: self._reset())

    def _grab(self) -> None:
        self._take_over()

    def _send(self) -> None:
        """Sends the values in the panel to the loop, and its pedals to the console where there is one."""
        values: dict[str, Any] = {
            "hold": not self.path.value, "paused": self.pause.value, "p_hand_offset_W": self._offset,
        }  # fmt: skip
        for name in ("stiffness", "damping"):
            nominal = getattr(self._stage, name)
            if nominal > 0.0:
                values[f"{name}_scale"] = getattr(self, name).value / nominal
        console = getattr(self._source, "console", None)
        with self._lock:
            if console is None:
                self._assign(values | {"clutch": self.clutch.value})
                return
            self._source.change(**values)  # type: ignore[attr-defined]
            for pedal, box in self.pedals.items():
                console.set(pedal, box.value, "viewer")

    def _assign(self, values: dict[str, Any]) -> None:
        controls = self._source.controls
        for name, value in values.items():
            setattr(controls, name, value)
        self._source.controls = controls

    def _reset(self) -> None:
        self._offset = np.zeros(3)
        set_value(self.stiffness, self._stage.stiffness)
        set_value(self.damping, self._stage.damping)
        set_value(self.path, True)
        for box in self.pedals.values():
            set_value(box, False)
        set_value(self.pause, False)
        self._send()

    def _pinch(self, angle: float) -> None:
        self._take_over()
        self._send()
        self._source.change(hand_pinch=angle)  # type: ignore[attr-defined]

    def _take_over(self) -> None:
        """The person goes on from where a simulated operator has led the hand."""
        self._offset = np.array(self._source.controls.p_hand_offset_W)
        set_value(self.path, False)


def _slider(gui: viser.GuiApi, label: str, nominal: float) -> viser.GuiSliderHandle[float]:
    """Slider from zero to three times the scene's value."""
    if nominal <= 0.0:
        return gui.add_slider(f"{label}: zero in the scene", 0.0, 1.0, 0.1, 0.0, disabled=True)
    step = float(10.0 ** np.floor(np.log10(3.0 * nominal / 50.0)))
    return gui.add_slider(label, 0.0, 3.0 * nominal, step, nominal)


def upright(eye: Array, p: Array, grab: Array) -> Array:
    """Point (3,) [m] where the ray from the eye through p meets the vertical plane through `grab` that faces the eye.

    A pointer that moves down then moves the hand straight down; in the plane of the screen it would come nearer, too.
    p itself if the eye looks down by more than 60 degrees, where that plane is seen from its edge.
    """
    normal = (eye - grab) * [1.0, 1.0, 0.0]
    far = float((eye - grab) @ normal)
    fall = float((eye - p) @ normal)
    steep = float(np.linalg.norm(normal)) < 0.5 * float(np.linalg.norm(eye - grab))
    return p if steep or fall <= 0.0 else np.asarray(eye + far / fall * (p - eye))


def _on_level(eye: Array, p: Array, z: float) -> Array:
    """Point (3,) [m] where the ray from the eye through p meets the height z; p itself if the ray is horizontal."""
    fall = p[2] - eye[2]
    return p if abs(fall) < 1e-6 else np.asarray(eye + (z - eye[2]) / fall * (p - eye))
