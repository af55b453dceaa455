"""A small second picture at the tool tip, rendered by the browser itself."""

from __future__ import annotations

import threading
import time

import numpy as np
import viser

from palpate.base.arrays import Array, so3
from palpate.viewer.controls import set_value
from palpate.viewer.drawing import Drawing

SIZE = (180, 270)
"""Height and width of the picture [pixels]."""
MOST_RATE = 8.0
"""Largest rate of the pictures [Hz]."""
_SHARE = 4.0  # pause after a picture over the time that it took: the main view keeps most of the browser [-]
_SLOWEST = 1.0  # a browser that takes longer, because it renders without a graphics card, gets no inset [s]
_FIELD_OF_VIEW = np.radians(35.0)
_FROM = np.array([0.02, -0.075, 0.035])  # camera relative to the tip [m]


class Inset:
    """A switch and a picture; the newest browser renders for all."""

    def __init__(self, server: viser.ViserServer, drawing: Drawing) -> None:
        """Adds both to the present folder of the panel."""
        self._server, self._drawing = server, drawing
        hint = "A second picture at the tool tip. It costs the browser one more rendering for each picture."
        self.on = server.gui.add_checkbox("inset at tip", False, hint=hint)
        self.picture = server.gui.add_image(np.full((*SIZE, 3), 240, np.uint8), visible=False)
        self.took = 0.0
        """Time that the browser needed for the last picture [s]."""
        self._run: threading.Thread | None = None
        self.on.on_update(lambda _: self._switch())

    def close(self) -> None:
        """Ends the pictures."""
        set_value(self.on, False)
        if self._run is not None:
            self._run.join(timeout=2.0)

    def _switch(self) -> None:
        self.picture.visible = self.on.value
        if self.on.value and (self._run is None or not self._run.is_alive()):
            self._run = threading.Thread(target=self._render, name="palpate-inset", daemon=True)
            self._run.start()

    def _render(self) -> None:
        while self.on.value:
            clients = list(self._server.get_clients().values())
            wxyz, position = camera(self._drawing.p_WT)
            began = time.perf_counter()
            try:
                image = clients[-1].get_render(
                    *SIZE, wxyz=wxyz, position=position, fov=float(_FIELD_OF_VIEW), timeout=20.0
                )
            except Exception:  # the browser was closed, or it does not answer
                time.sleep(0.5)
                continue
            self.took = time.perf_counter() - began
            self.picture.image = image[:, :, :3]
            if self.took > _SLOWEST:
                self.picture.label = f"off: this browser needs {self.took:.1f} s for a picture"
                set_value(self.on, False)
                return
            time.sleep(max(1.0 / MOST_RATE - self.took, _SHARE * self.took))


def camera(p_WT: Array) -> tuple[Array, Array]:
    """Orientation (4,) w x y z and position (3,) [m] of a camera that looks at the tip, x right and y down."""
    z = -_FROM / np.linalg.norm(_FROM)
    x = np.cross(z, [0.0, 0.0, 1.0])
    x /= np.linalg.norm(x)
    return so3.quaternions(np.stack([x, np.cross(z, x), z], axis=1)[None])[0], p_WT + _FROM
