"""The picture of the remote camera beside the 3-D scene, with its own delay."""

from __future__ import annotations

import base64
from collections.abc import Callable

import viser

_PICTURE = (
    '<div style="padding:4px 10px 0"><img alt="remote camera" style="width:100%;border-radius:4px" '
    'src="data:image/jpeg;base64,{}"></div>'
)
_WORDS = '<div id="palpate-video" style="padding:0 10px 4px;font-size:12px;opacity:.8">remote camera, {}</div>'
STILL = 1.0
"""Age from which a picture is said to stand still [s]."""


class VideoPanel:
    """Shows the newest picture of the remote camera; without a camera it takes no room."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._gui = gui
        self._html: tuple[viser.GuiHtmlHandle, viser.GuiHtmlHandle] | None = None  # picture and words
        self._shown: bytes | None = None
        self._told = 0.0  # age that the words say [s]

    def show(self, video: Callable[[], tuple[bytes, float] | None] | None) -> None:
        """Show the picture that is newest now, with the time since its capture; one that stands still is told."""
        found = None if video is None else video()
        if found is None:
            return
        picture, age = found
        still = picture is self._shown
        if still and age < max(STILL, self._told + 0.5 * STILL):
            return
        if self._html is None:
            self._html = self._gui.add_html("", order=-1.0), self._gui.add_html("", order=-0.9)
        self._told = age
        if not still:
            self._shown = picture
            self._html[0].content = _PICTURE.format(base64.b64encode(picture).decode())
        self._html[1].content = _WORDS.format(
            f"no new picture for {age:.0f} s" if age >= STILL else f"delay {1e3 * age:.0f} ms"
        )
