"""Style of the report's figures: one palette, two widths, vector graphics embedded in the page."""

from __future__ import annotations

import base64
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from numpy.typing import NDArray

from palpate.base.errors import OutputError

INK, MUTED, GRID = "#22303c", "#71808c", "#e6ebef"
FORCE, CELL, DEPTH, CAP = "#c8453b", "#8b98a3", "#1f6f8b", "#b58900"
TOOL, PROXY, SURFACE = "#1f6f8b", "#c8453b", "#e3b7a5"
PHASES = {"approach": "#ffffff", "press": "#f8e7dc", "slide": "#e4f0f1", "leave": "#f3eef7"}
JOINTS = ("#c8453b", "#1f6f8b", "#4f8f4f", "#b58900", "#8767a8", "#d98cb3", "#8a6a4f")

_RC: Any = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 8.0,
    "axes.edgecolor": "#b9c3cb",
    "axes.labelcolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.linewidth": 0.7,
    "grid.color": GRID,
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "legend.fontsize": 7.5,
    "lines.linewidth": 1.1,
    "text.color": INK,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "svg.fonttype": "path",
    "svg.hashsalt": "palpate",  # the same record gives the same page
}


@dataclass(frozen=True)
class Canvas:
    """Page width of a figure."""

    name: str
    width: float
    """Width [inch]; the page shows it about 1.35 times as wide."""

    @property
    def narrow(self) -> bool:
        """True for a telephone, where panels are stacked."""
        return self.width < 6.0

    def points(self) -> int:
        """Largest useful number of points in a curve."""
        return 700 if self.narrow else 1800


CANVASES = (Canvas("narrow", 4.0), Canvas("wide", 10.0))


def style() -> AbstractContextManager[None]:
    """Context manager that applies the report's style."""
    return matplotlib.rc_context(_RC)


def picture(draw: Callable[[Canvas], Figure], alt: str) -> str:
    """A figure for both widths as self-contained HTML.

    Args:
        draw: draws the figure for a canvas.
        alt: description for readers who cannot see the figure.
    """
    with style():
        narrow, wide = (_data_uri(draw(canvas)) for canvas in CANVASES)
    return (
        f'<picture><source media="(max-width: 700px)" srcset="{narrow}">'
        f'<img src="{wide}" alt="{alt}" loading="lazy"></picture>'
    )


def png(draw: Callable[[Canvas], Figure], file: Path) -> None:
    """Write a wide figure for the documentation, small enough for the repository.

    Raises:
        OutputError: the file cannot be written.
    """
    from PIL import Image  # comes with matplotlib

    stream = BytesIO()
    with matplotlib.rc_context(_RC):
        figure = draw(CANVASES[-1])
        figure.dpi = 110
        FigureCanvasAgg(figure).print_png(stream)  # type: ignore[no-untyped-call] # draws once, savefig twice
    try:
        Image.open(stream).convert("RGB").quantize(128, dither=Image.Dither.NONE).save(file, optimize=True)
    except OSError as error:
        why = error.strerror or str(error)
        raise OutputError("the picture cannot be written", where=str(file), why=why) from None


def _data_uri(figure: Figure) -> str:
    stream = BytesIO()
    figure.dpi = 200  # of embedded images
    # Draws once, which also arranges the axes; savefig draws each figure twice.
    canvas = FigureCanvasSVG(figure)
    canvas.print_svg(stream, metadata={"Date": None, "Creator": None})  # type: ignore[no-untyped-call]
    return "data:image/svg+xml;base64," + base64.b64encode(stream.getvalue()).decode()


def plain_ticks(axes: Axes, values: Sequence[float]) -> None:
    """Marks these values on a logarithmic x axis, as plain numbers."""
    axes.set_xticks(list(values), [f"{x:g}" for x in values])
    axes.xaxis.minorticks_off()


def curve(axes: Axes, t: NDArray[Any], y: NDArray[Any], points: int, **style: Any) -> None:
    """Draw y(t); a long curve is reduced to the minimum and maximum of each interval, so that every peak remains."""
    t, y = thin(t, y, points)
    axes.plot(t, y, **style)


def thin(t: NDArray[Any], y: NDArray[Any], points: int) -> tuple[NDArray[Any], NDArray[Any]]:
    """About `points` or fewer points of y(t) (n,) that keep every peak."""
    step = -(-2 * len(t) // points)
    if step <= 2:
        return t, y
    whole = len(t) // step * step
    rows = y[:whole].reshape(-1, step)
    picks = np.sort(np.stack([rows.argmin(axis=1), rows.argmax(axis=1)], axis=1), axis=1)
    index = (picks + np.arange(len(rows))[:, None] * step).reshape(-1)
    index = np.append(index, np.arange(whole, len(t)))
    return t[index], y[index]
