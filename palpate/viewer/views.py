"""Camera views: the whole scene, or a close-up of the tool."""

from __future__ import annotations

import numpy as np
import viser

from palpate.arrays import Array
from palpate.viewer.controls import set_value
from palpate.viewer.drawing import Drawing
from palpate.viewer.stage import Stage

View = tuple[Array, Array]
"""Position of the camera and the point it looks at, (3,) each [m]."""

GLASS = 0.5
"""Transparency of the organs in the close-up [-]."""
FIELD_OF_VIEW = np.radians(42.0)
FROM_ABOVE_IN_FRONT = np.array([-0.10, -1.15, 0.50])
"""Camera position relative to the focus, for a scene of 0.4 m [m]: on the surgeon's side."""


def overview(stage: Stage) -> View:
    """View of organ and master arm side by side, with room above for the arms."""
    size = stage.extent / 0.4
    look_at = stage.focus + size * np.array([-0.02, 0.0, 0.10])
    return look_at + size * FROM_ABOVE_IN_FRONT, look_at


def close_up(p_WT: Array) -> View:
    """View of the tool tip (3,) [m] from a distance of 0.2 m."""
    return p_WT + np.array([0.03, -0.17, 0.09]), p_WT


def start_with(server: viser.ViserServer, view: View) -> None:
    """Sets the initial view of a browser."""
    camera = server.initial_camera
    camera.position, camera.look_at = (tuple(point) for point in view)
    camera.up, camera.fov, camera.near, camera.far = (0.0, 0.0, 1.0), float(FIELD_OF_VIEW), 0.01, 30.0


def add_buttons(gui: viser.GuiApi, stage: Stage, drawing: Drawing) -> None:
    """Adds a button for each view, which moves the camera of the requesting browser, and the transparency slider."""
    with gui.add_folder("View"):
        buttons = gui.add_button_group("look at", ("scene", "tool tip"))
        hint = "Transparency of the organs, to show the tool inside"
        inside = bool(stage.targets) or any(obj.regions or obj.holds for obj in stage.objects)
        glass = gui.add_slider("see through", 0.0, 0.9, 0.1, GLASS if inside else 0.0, hint=hint)
        drawing.see_through(glass.value)

        if stage.frames:
            frames = gui.add_checkbox("frames", True, hint="Axes and names of the scene's frames")
            frames.on_update(lambda _: drawing.show_frames(frames.value))

    @glass.on_update
    def _(_: object) -> None:
        drawing.see_through(glass.value)

    @buttons.on_click
    def _(event: viser.GuiEvent[viser.GuiButtonGroupHandle]) -> None:
        near = event.target.value == "tool tip"
        view = close_up(drawing.p_WT) if near else overview(stage)
        set_value(glass, GLASS if near or inside else 0.0)
        drawing.see_through(glass.value)
        if event.client is not None:
            with event.client.atomic():
                event.client.camera.position, event.client.camera.look_at = view
