"""Sets controls of the page from the program."""

from typing import Any

import viser


def set_value(handle: Any, value: Any) -> None:
    """Sets a control from the program (viser's setter takes more than its getter gives: mypy cannot follow)."""
    handle.value = value


def time_slider(gui: viser.GuiApi, first: float, last: float) -> viser.GuiSliderHandle[float]:
    """Slider from the first to the last instant of a record [s]; it cannot be moved if the record is one instant."""
    step = 1e-3
    if last - first < step:
        return gui.add_slider("time [s]: a single tick", first, first + 1.0, step, first, disabled=True)
    return gui.add_slider("time [s]", first, last, step, first)
