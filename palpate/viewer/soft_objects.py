"""Draws soft objects as the loop deforms them, on request coloured by displacement or strain."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import viser
from numpy.typing import NDArray

from palpate.base.arrays import Array
from palpate.viewer.drawing import Drawing
from palpate.viewer.skins import BANDS
from palpate.viewer.stage import Stage
from palpate.viewer.strain import SurfaceStrain

STILL = 2e-5
"""Smallest motion of a vertex that is drawn [m]."""


@dataclass(frozen=True)
class Scale:
    """What the colours show."""

    name: str
    unit: str
    factor: float
    """From SI to the unit."""
    ends: tuple[float, ...]
    """Values of the last colour, of which the smallest that holds all values so far is used (SI)."""


SCALES = (
    Scale("displacement", "mm", 1e3, (0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1)),
    Scale("strain", "%", 1e2, (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0)),
)
OFF = "off"


class SoftSource(Protocol):
    """A running session with soft objects, or a record of one."""

    def soft_vertices(self, index: int) -> Array:
        """Deformed surface of an object: vertices (n, 3) in the object's frame O [m]."""
        ...


class SoftObjects:
    """The soft objects of a stage; reads their newest surfaces and never waits for the loop."""

    def __init__(self, gui: viser.GuiApi, stage: Stage, drawing: Drawing, source: SoftSource) -> None:
        """Adds a choice of the colours, with their legend."""
        self._drawing, self._source = drawing, source
        soft = {k: obj for k, obj in enumerate(stage.objects) if obj.soft}
        self._rest = {k: obj.vertices for k, obj in soft.items()}
        self._triangles = {k: obj.triangles for k, obj in soft.items()}
        self._strain: dict[int, SurfaceStrain] = {}
        self._drawn: dict[int, Array] = {}
        self._ends = {scale.name: scale.ends[0] for scale in SCALES}
        self.frames = 0  #: updates that were sent to the browsers
        with gui.add_folder("Soft tissue"):
            hint = "Colours the tissue by its displacement, or by the largest strain of its surface"
            self.colour = gui.add_dropdown("colour", (OFF, *(s.name for s in SCALES)), initial_value=OFF, hint=hint)
            self._legend = gui.add_html("", visible=False)
        self.colour.on_update(lambda _: self._redraw())

    def show(self) -> None:
        """Draws the surfaces that have moved."""
        scale = next((one for one in SCALES if one.name == self.colour.value), None)
        for k in self._rest:
            vertices = self._source.soft_vertices(k)
            if k in self._drawn and np.abs(vertices - self._drawn[k]).max() < STILL:
                continue
            self._drawn[k] = vertices
            self._drawing.deform(k, vertices, None if scale is None else self._bands(scale, k, vertices))
            self.frames += 1

    @property
    def is_drawn(self) -> bool:
        """False if the colours have changed since the last update."""
        return bool(self._drawn)

    def _redraw(self) -> None:
        scale = next((one for one in SCALES if one.name == self.colour.value), None)
        self._legend.visible = scale is not None
        if scale is not None:
            self._legend.content = legend(scale, self._ends[scale.name])
        self._drawn = {}

    def _bands(self, scale: Scale, k: int, vertices: Array) -> NDArray[np.int64]:
        """Number (m,) of the colour of each triangle."""
        if scale.name == "strain":
            if k not in self._strain:
                self._strain[k] = SurfaceStrain(self._rest[k], self._triangles[k])
            values = self._strain[k].of(vertices)
        else:
            values = np.linalg.norm(vertices - self._rest[k], axis=1)[self._triangles[k]].mean(axis=1)
        before = self._ends[scale.name]
        end = next((one for one in scale.ends if one >= max(before, float(values.max()))), scale.ends[-1])
        if end != before:
            self._ends[scale.name] = end
            self._legend.content = legend(scale, end)
        return bands(values / end)


def bands(share: Array) -> NDArray[np.int64]:
    """Number (m,) of the colour for shares (m,) of the last value."""
    return np.clip((share * len(BANDS)).astype(np.int64), 0, len(BANDS) - 1)


def legend(scale: Scale, end: float) -> str:
    """The colours with the first, the middle and the last value in their unit, as HTML."""
    boxes = "".join(f'<div style="flex:1;height:10px;background:rgb{color}"></div>' for color in BANDS)
    marks = "".join(f"<span>{scale.factor * end * part:g}</span>" for part in (0.0, 0.5))
    return (
        f'<div style="padding:0 10px 6px 10px;font-size:12px" id="palpate-colours"><div>{scale.name} [{scale.unit}]'
        f'</div><div style="display:flex">{boxes}</div><div style="display:flex;justify-content:space-between">'
        f"{marks}<span>{scale.factor * end:g}</span></div></div>"
    )
