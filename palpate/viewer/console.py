"""The right-hand panel and the drag handle: everything a person can change while the session runs."""

from __future__ import annotations

import threading
from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray

from palpate.record.ticks import Ticks
from palpate.viewer.server import set_value
from palpate.viewer.source import Source
from palpate.viewer.stage import Stage

Array = NDArray[np.float64]

REACH = 0.12
"""The ball moves the hand no further than this from its path, along each axis [m]."""
BALL = 0.016
"""Its radius [m]."""
HAND = (245, 150, 30)


class Console:
    """Sliders, pedal and buttons, and the ball to drag at the leader's handle; each change is one new `Controls`."""

    def __init__(self, server: viser.ViserServer, stage: Stage, source: Source) -> None:
        """Fills the main panel, docked on the right, and hangs the ball into the scene."""
        self._source, self._stage = source, stage
        self._lock = threading.Lock()
        self._p_grab, self._offset_grab = np.zeros(3), np.zeros(3)
        gui = server.gui
        gui.set_panel_label(stage.title)
        with gui.add_folder("Tissue"):
            self.stiffness = self._scaled(gui, "stiffness [N/m]", stage.stiffness, "stiffness_scale")
            self.damping = self._scaled(gui, "damping [N s/m]", stage.damping, "damping_scale")
        with gui.add_folder("Hand"):
            gui.add_html(
                '<div style="padding:0 10px 6px 10px;font-size:12px;opacity:.8">Drag the orange ball at the '
                "master's handle (with shift: level with the table). The hand moves, the instrument follows "
                f"{1 / stage.motion_scale:.3g} times finer, and the organ pushes back.</div>"
            )
            self.back = gui.add_button("Let the hand go back", hint="Back onto the path of the scene")
            self.clutch = gui.add_checkbox("clutch", False, hint="Pedal: the hand moves, the instrument stays")
        with gui.add_folder("Run"):
            self.pause = gui.add_checkbox("pause", False, hint="Simulated time stands still")
            self.reset = gui.add_button("Reset the console", hint="Tissue, hand, clutch and pause as at the start")
        server.gui.main_panel.dock_right()
        server.gui.main_panel.set_width(280)
        self.ball = server.scene.add_icosphere("/hand", BALL, HAND, opacity=0.75, cast_shadow=False)
        self._hint = server.scene.add_label(
            "/hand/hint", "drag", position=(0.0, 0.0, 1.6 * BALL), anchor="bottom-center"
        )
        self.ball.on_drag("left")(self._drag)
        self.ball.on_drag("left", modifier="shift")(self._drag)
        self.back.on_click(lambda _: self._change(p_hand_offset_W=np.zeros(3)))
        self.clutch.on_update(lambda _: self._change(clutch=self.clutch.value))
        self.pause.on_update(lambda _: self._change(paused=self.pause.value))
        self.reset.on_click(lambda _: self._reset())

    def show(self, tick: Ticks) -> None:
        """The ball rides on the hand's intended position."""
        X_WL = self._stage.leader.X_WA
        self.ball.position = X_WL[:3, :3] @ tick["p_hand_L"] + X_WL[:3, 3]

    def _scaled(self, gui: viser.GuiApi, label: str, nominal: float, name: str) -> viser.GuiSliderHandle[float]:
        """A slider in the unit of the thing; the loop is told the ratio to the scene's value."""
        top = 3.0 * nominal if nominal > 0 else 1.0
        step = 10.0 ** np.floor(np.log10(top / 50.0))
        slider = gui.add_slider(
            label, 0.0, top, step, nominal, disabled=nominal <= 0,
            hint=None if nominal > 0 else "zero in the scene: give the object one there to change it here",
        )  # fmt: skip
        slider.on_update(lambda _: self._change(**{name: slider.value / nominal}))
        return slider

    def _change(self, **fields: Any) -> None:
        with self._lock:
            controls = self._source.controls
            for name, value in fields.items():
                setattr(controls, name, value)
            self._source.controls = controls

    def _reset(self) -> None:
        set_value(self.stiffness, self._stage.stiffness)
        set_value(self.damping, self._stage.damping)
        set_value(self.clutch, False)
        set_value(self.pause, False)
        self._change(stiffness_scale=1.0, damping_scale=1.0, clutch=False, paused=False, p_hand_offset_W=np.zeros(3))

    async def _drag(self, event: viser.SceneNodeDragEvent[viser.IcosphereHandle]) -> None:
        """Moves the hand with the pointer: in the plane of the screen, or level with the table while shift is held."""
        p_W = np.array(event.end_position)
        if event.phase == "start":
            self._hint.visible = False
            self._p_grab = np.array(event.start_position)
            self._offset_grab = np.array(self._source.controls.p_hand_offset_W)
        if event.modifier == "shift":
            p_W = _on_level(np.array(event.client.camera.position), p_W, float(self._p_grab[2]))
        offset = np.clip(self._offset_grab + p_W - self._p_grab, -REACH, REACH)
        self._change(p_hand_offset_W=offset)


def _on_level(eye: Array, p: Array, z: float) -> Array:
    """Where the ray from the eye through p meets the height z; p itself when the ray runs along the table."""
    fall = p[2] - eye[2]
    return p if abs(fall) < 1e-6 else np.asarray(eye + (z - eye[2]) / fall * (p - eye))
