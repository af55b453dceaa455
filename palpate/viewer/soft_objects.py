"""Draws soft objects as the loop deforms them, on request coloured by displacement."""

from __future__ import annotations

from typing import Protocol

import numpy as np
import viser

from palpate.arrays import Array
from palpate.viewer.drawing import Drawing
from palpate.viewer.stage import Stage

STILL = 2e-5
"""Smallest motion of a vertex that is drawn [m]."""
SCALES = (0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1)
"""Displacements of the last colour, of which the smallest that holds all vertices so far is used [m]."""
COLORS = np.array([[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]], dtype=np.float64)
"""Colours from no displacement to the largest: nearly those of matplotlib's viridis."""


class SoftSource(Protocol):
    """A running session with soft objects."""

    def soft_vertices(self, index: int) -> Array:
        """Deformed surface of an object: vertices (n, 3) in the object's frame O [m]."""
        ...


class SoftObjects:
    """The soft objects of a stage; reads their newest surfaces and never waits for the loop."""

    def __init__(self, gui: viser.GuiApi, stage: Stage, drawing: Drawing, source: SoftSource) -> None:
        """Adds a check box for the colours, with their legend."""
        self._drawing, self._source = drawing, source
        self._rest = {k: obj.vertices for k, obj in enumerate(stage.objects) if obj.soft}
        self._drawn: dict[int, Array] = {}
        self._scale = SCALES[0]
        self.frames = 0  #: updates that were sent to the browsers
        with gui.add_folder("Soft tissue"):
            self.coloured = gui.add_checkbox("displacement", False, hint="Colours the tissue by its displacement")
            self._legend = gui.add_html(_legend(self._scale), visible=False)
        self.coloured.on_update(lambda _: self._redraw())

    def show(self) -> None:
        """Draws the surfaces that have moved."""
        for k, rest in self._rest.items():
            vertices = self._source.soft_vertices(k)
            if k in self._drawn and np.abs(vertices - self._drawn[k]).max() < STILL:
                continue
            self._drawn[k] = vertices
            self._drawing.deform(k, vertices, self._colors(vertices - rest) if self.coloured.value else None)
            self.frames += 1

    def _redraw(self) -> None:
        self._legend.visible = self.coloured.value
        self._drawn = {}

    def _colors(self, moved: Array) -> Array:
        size = np.linalg.norm(moved, axis=1)
        scale = next((s for s in SCALES if s >= max(self._scale, size.max())), SCALES[-1])
        if scale != self._scale:
            self._scale = scale
            self._legend.content = _legend(scale)
        return colors(size / scale)


def colors(share: Array) -> Array:
    """Colours (n, 3), 0 to 255, for shares (n,) of the largest displacement."""
    at = np.linspace(0.0, 1.0, len(COLORS))
    return np.stack([np.interp(share, at, COLORS[:, k]) for k in range(3)], axis=1)


def _legend(scale: float) -> str:
    bar = ",".join(f"rgb({r:.0f},{g:.0f},{b:.0f})" for r, g, b in COLORS)
    return (
        f'<div style="padding:0 10px 6px 10px;font-size:12px"><div style="height:10px;'
        f'background:linear-gradient(90deg,{bar})"></div>0 to {1e3 * scale:g} mm</div>'
    )
