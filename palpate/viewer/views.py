"""Camera views: the whole scene, or a close-up of the tool."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import viser

from palpate.base.arrays import Array
from palpate.viewer.controls import set_value
from palpate.viewer.drawing import Drawing
from palpate.viewer.inset import Inset
from palpate.viewer.stage import Stage

View = tuple[Array, Array]
"""Position of the camera and the point it looks at, (3,) each [m]."""

GLASS = 0.5
"""Transparency of the organs in the close-up [-]."""
FIELD_OF_VIEW = np.radians(42.0)
_FILLED = 0.86
"""Share of the picture that the overview fills [-]; the rest is a margin."""
_FIRST = 0.8  # width over height of a picture before a browser tells it
_SAME_SHAPE, _UNMOVED = 0.02, 1e-3  # share of width over height; motion of a camera that nobody moved [m]
_CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
FROM_ABOVE_IN_FRONT = np.array([-0.10, -1.15, 0.50])
"""Direction of the camera from the middle: on the surgeon's side."""


def overview(stage: Stage, aspect: float = _FIRST) -> View:
    """View that is filled by the objects, the instrument's tip and the ball to drag.

    aspect: width over height of the picture between the panels.
    """
    return overview_of(stage.seen if len(stage.seen) else stage.focus + 0.4 * stage.extent * _CORNERS, aspect)


def overview_of(p: Array, aspect: float) -> View:
    """View that is filled by points (n, 3) in W [m]; aspect: width over height of the picture."""
    back = FROM_ABOVE_IN_FRONT / np.linalg.norm(FROM_ABOVE_IN_FRONT)
    right = np.cross([0.0, 0.0, 1.0], back)
    right /= np.linalg.norm(right)
    axes = np.stack([right, np.cross(back, right), back])
    low, high = (p @ axes.T).min(axis=0), (p @ axes.T).max(axis=0)
    middle = 0.5 * (low + high)
    half = np.tan(0.5 * FIELD_OF_VIEW) * np.array([min(aspect, 1.5), 1.0]) * _FILLED
    across, toward = np.abs(p @ axes.T - middle)[:, :2], (p @ axes.T - middle)[:, 2]
    away = float((across / half + toward[:, None]).max())
    look_at = axes.T @ middle
    return look_at + away * back, look_at


def picture(client: viser.ClientHandle) -> float:
    """Width over height of a browser's picture, which lies between the panels."""
    return max(client.camera.image_width, 1) / max(client.camera.image_height, 1)


def look(client: viser.ClientHandle, view: View) -> None:
    """Moves the camera of a browser."""
    with client.atomic():
        client.camera.position, client.camera.look_at = view


class Framing:
    """Fills the picture of each browser with the overview, until its user moves the camera.

    A browser states the size of its picture when it connects, and another one when the panels have taken their place
    beside it.

    Args:
        server: the server of the page.
        view: the overview for a width over height of the picture.
    """

    def __init__(self, server: viser.ViserServer, view: Callable[[float], View]) -> None:
        self._view = view
        self._given: dict[int, tuple[float, Array]] = {}  # of each browser: width over height, position of the camera
        start_with(server, view(_FIRST))
        server.on_client_connect(self._begin)
        server.on_client_disconnect(self._left)
        for client in server.get_clients().values():
            self._begin(client)

    def _begin(self, client: viser.ClientHandle) -> None:
        self._look(client)
        client.camera.on_update(lambda _: self.follow(client))

    def _left(self, client: viser.ClientHandle) -> None:
        self._given.pop(client.client_id, None)

    def _look(self, client: viser.ClientHandle) -> None:
        aspect = picture(client)
        view = self._view(aspect)
        self._given[client.client_id] = aspect, view[0]
        look(client, view)

    def follow(self, client: viser.ClientHandle) -> None:
        """Fit the overview again if the picture has another shape now and the user has left the camera as it was."""
        aspect, given = self._given.get(client.client_id, (0.0, np.zeros(3)))
        if not aspect or abs(picture(client) / aspect - 1.0) < _SAME_SHAPE:
            return
        at = np.asarray(client.camera.position)
        if min(float(np.linalg.norm(at - p)) for p in (given, self._view(_FIRST)[0])) < _UNMOVED:
            self._look(client)


def close_up(p_WT: Array) -> View:
    """View of the tool tip (3,) [m] from a distance of 0.2 m."""
    return p_WT + np.array([0.03, -0.17, 0.09]), p_WT


def start_with(server: viser.ViserServer, view: View) -> None:
    """Sets the initial view of a browser."""
    camera = server.initial_camera
    camera.position, camera.look_at = (tuple(point) for point in view)
    camera.up, camera.fov, camera.near, camera.far = (0.0, 0.0, 1.0), float(FIELD_OF_VIEW), 0.01, 30.0


def add_buttons(server: viser.ViserServer, stage: Stage, drawing: Drawing) -> Inset:
    """Adds buttons that move the camera of the requesting browser, the transparency slider, and the inset."""
    gui = server.gui
    with gui.add_folder("View"):
        places = ("scene", "tool tip", *(("device",) if drawing.device is not None else ()))
        buttons = gui.add_button_group("look at", places)
        # no hint: viser then puts label and slider into one row, which leaves the slider no width in a narrow panel
        inside = bool(stage.targets) or any(obj.regions or obj.holds for obj in stage.objects)
        glass = gui.add_slider("see through organs", 0.0, 0.9, 0.1, GLASS if inside else 0.0)
        drawing.see_through(glass.value)

        if stage.frames:
            frames = gui.add_checkbox("frames", True, hint="Axes and names of the scene's frames")
            frames.on_update(lambda _: drawing.show_frames(frames.value))
        hint = "For devices without force: draws the tool on the surface, and the force as a halo"
        cue = gui.add_checkbox("force cue", drawing.cue.enabled, hint=hint)
        inset = Inset(server, drawing)

    @cue.on_update
    def _(_: object) -> None:
        drawing.cue.enabled = cue.value

    @glass.on_update
    def _(_: object) -> None:
        drawing.see_through(glass.value)

    @buttons.on_click
    def _(event: viser.GuiEvent[viser.GuiButtonGroupHandle]) -> None:
        near = event.target.value == "tool tip"
        aspect = _FIRST if event.client is None else picture(event.client)
        view = close_up(drawing.p_WT) if near else overview(stage, aspect)
        if event.target.value == "device" and drawing.device is not None:
            view = overview_of(drawing.device.corners(), aspect)
        set_value(glass, GLASS if near or inside else 0.0)
        drawing.see_through(glass.value)
        if event.client is not None:
            look(event.client, view)

    return inset
