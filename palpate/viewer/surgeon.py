"""The surgeon's view: the picture of the simulated stereo endoscope, one eye or side by side, with the force on it.

The browser renders the picture, as for the inset at the tool tip. The force overlay follows Figs 8 and 12 of the paper:
the red arrow of the scene is the deflection at the tip, the green one the force of the surface on the tool, and the
number is the force on the hand.
"""

from __future__ import annotations

import threading
import time
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import viser
from numpy.typing import NDArray

from palpate.base.arrays import Array, so3
from palpate.record.ticks import Ticks
from palpate.viewer.controls import set_value

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from palpate.scene.placed_ecm import PlacedEcm

Image = NDArray[np.uint8]
SIZE = (210, 280)
"""Height and width of the picture of one eye [pixels]."""
TIP_SCALE = 0.012
"""Length of the force arrow at the tip [m/N]."""
GREEN = (40, 210, 80)
CHOICES = ("off", "left eye", "right eye", "both eyes")
_MOST_RATE = 8.0  # of the pictures [Hz]
_SHARE = 3.0  # pause after a picture over the time that it took: the main view keeps most of the browser [-]
_SLOWEST = 3.0  # a browser that takes longer gets no picture [s]


def vertical_angle(width_deg: float, size: tuple[int, int] = SIZE) -> float:
    """Vertical angle of view [rad] of a picture of a size (height, width), for its horizontal angle [deg]."""
    return float(2.0 * np.arctan(np.tan(0.5 * np.radians(width_deg)) * size[0] / size[1]))


def project(X_WC: Array, p_W: Array, angle: float, size: tuple[int, int] = SIZE) -> Array:
    """Pixels (n, 2), column and row, of points (n, 3) in W [m]; NaN behind the camera.

    Args:
        X_WC: pose (4, 4) of the camera, x right and y down.
        p_W: the points.
        angle: vertical angle of view [rad].
        size: height and width of the picture [pixels].
    """
    p = (np.atleast_2d(p_W) - X_WC[:3, 3]) @ X_WC[:3, :3]
    focal = 0.5 * size[0] / np.tan(0.5 * angle)
    z = np.where(p[:, 2] > 1e-6, p[:, 2], np.nan)[:, None]
    return np.asarray(0.5 * np.array([size[1], size[0]]) + focal * p[:, :2] / z)


def with_bars(image: Image, shares: Sequence[float]) -> Image:
    """The picture of an eye with a bar for each tool at its lower edge, filled by a share from 0 to 1."""
    drawn = np.array(image)
    height, width = drawn.shape[:2]
    for k, share in enumerate(shares):
        top, left = height - 12 - 14 * k, 6
        full = round((width - 12) * min(max(share, 0.0), 1.0))
        drawn[top : top + 9, left : width - 6] = (70, 70, 70)
        drawn[top : top + 9, left : left + full] = (225, 38, 38)
    return drawn


def with_forces(image: Image, ticks: Sequence[Ticks], X_WC: Array, angle: float) -> Image:
    """The picture of an eye with the force on each tool as an arrow at its tip, and the force on each hand in newtons.

    The numbers stand in the order of the tools in the picture, from left to right.

    Args:
        image: (h, w, 3), red, green, blue.
        ticks: the newest tick of each pair.
        X_WC: pose (4, 4) of the eye.
        angle: vertical angle of view [rad].
    """
    from PIL import Image as Picture  # comes with viser
    from PIL import ImageDraw

    drawn = Picture.fromarray(image)
    pen, size = ImageDraw.Draw(drawn), (image.shape[0], image.shape[1])
    columns = []
    for tick in ticks:
        p_WT = np.array(tick["p_WT"], dtype=float)
        start, end = project(X_WC, np.stack([p_WT, p_WT + TIP_SCALE * np.array(tick["F_T_W"])]), angle, size)
        columns.append(start[0])
        if np.isfinite([start, end]).all() and np.linalg.norm(end - start) > 2.0:
            _arrow(pen, start, end, GREEN)
    for place, k in enumerate(np.argsort(columns)):
        force, left = float(np.linalg.norm(ticks[k]["F_H_L"])), 6 + 64 * place
        pen.rectangle((left, size[0] - 20, left + 58, size[0] - 5), fill=(20, 20, 20))
        pen.text((left + 4, size[0] - 19), f"{force:.2f} N", fill=(255, 255, 255))
    return np.asarray(drawn)


def _arrow(pen: Any, start: Array, end: Array, color: tuple[int, int, int]) -> None:
    along = (end - start) / np.linalg.norm(end - start)
    across = np.array([-along[1], along[0]])
    pen.line([tuple(start), tuple(end)], fill=color, width=3)
    head = [end + 3 * along, end - 6 * along + 4 * across, end - 6 * along - 4 * across]
    pen.polygon([tuple(point) for point in head], fill=color)


class SurgeonView:
    """A choice of eyes and their picture; the newest browser renders for all."""

    def __init__(
        self,
        server: viser.ViserServer,
        placed: PlacedEcm,
        joints: Callable[[], Array],
        ticks: Callable[[], Sequence[Ticks]],
        bar: Callable[[Ticks], float] | None = None,
    ) -> None:
        """Adds both to the present folder of the panel.

        joints: joints (4,) of the endoscope arm now. ticks: the newest tick of each pair. bar: of a condition, the
        share of the bar that a tick fills; then neither arrows nor numbers show the force.
        """
        self._share = bar
        self._server, self._placed, self._joints, self._ticks = server, placed, joints, ticks
        self._angle = vertical_angle(placed.section.endoscope.width_deg)
        hint = "Picture of the simulated endoscope, with deflection (red) and force (green) at the tool tip"
        self.choice = server.gui.add_dropdown("surgeon's view", CHOICES, initial_value=CHOICES[0], hint=hint)
        self.picture = server.gui.add_image(np.full((*SIZE, 3), 240, np.uint8), visible=False)
        self.shown = 0
        """Number of pictures shown."""
        self._run: threading.Thread | None = None
        self.choice.on_update(lambda _: self._switch())

    def close(self) -> None:
        """Ends the pictures."""
        set_value(self.choice, CHOICES[0])
        if self._run is not None:
            self._run.join(timeout=2.0)

    def _switch(self) -> None:
        self.picture.visible = self.choice.value != CHOICES[0]
        if self.picture.visible and (self._run is None or not self._run.is_alive()):
            self._run = threading.Thread(target=self._render, name="palpate-surgeon", daemon=True)
            self._run.start()

    def _sides(self) -> tuple[Literal["left", "right"], ...]:
        both: tuple[Literal["left", "right"], ...] = ("left", "right")
        return {"left eye": both[:1], "right eye": both[1:], "both eyes": both}.get(self.choice.value, ())

    def _render(self) -> None:
        while sides := self._sides():
            clients = list(self._server.get_clients().values())
            began = time.perf_counter()
            try:
                q, ticks = self._joints(), self._ticks()
                images = [self._eye(clients[-1], self._placed.eye(q, side), ticks) for side in sides]
            except Exception:  # the browser was closed, or it does not answer
                time.sleep(0.5)
                continue
            took = time.perf_counter() - began
            self.picture.image = np.concatenate(images, axis=1)
            self.shown += 1
            if took > _SLOWEST * len(sides):
                self.picture.label = f"off: this browser needs {took:.1f} s for a picture"
                set_value(self.choice, CHOICES[0])
                return
            time.sleep(max(1.0 / _MOST_RATE - took, _SHARE * took))

    def _eye(self, client: viser.ClientHandle, X_WC: Array, ticks: Sequence[Ticks]) -> Image:
        wxyz = so3.quaternions(X_WC[None, :3, :3])[0]
        image = client.get_render(*SIZE, wxyz=wxyz, position=X_WC[:3, 3], fov=self._angle, timeout=20.0)
        seen = np.ascontiguousarray(image[:, :, :3])
        if self._share is not None:
            return with_bars(seen, [share for share in map(self._share, ticks) if share > 0.0])
        return with_forces(seen, ticks, X_WC, self._angle)
