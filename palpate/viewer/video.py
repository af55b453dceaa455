"""The picture of the remote camera beside the 3-D scene, with its own delay."""

from __future__ import annotations

import base64
from collections.abc import Callable

import viser

_TEXT = (
    '<div style="padding:4px 10px"><img alt="remote camera" style="width:100%;border-radius:4px" '
    'src="data:image/jpeg;base64,{data}">'
    '<div id="palpate-video" style="font-size:12px;opacity:.8">remote camera, delay {delay:.0f} ms</div></div>'
)


class VideoPanel:
    """Shows the newest picture of the remote camera; without a camera it takes no room."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._gui = gui
        self._html: viser.GuiHtmlHandle | None = None
        self._shown: bytes | None = None

    def show(self, video: Callable[[], tuple[bytes, float] | None] | None) -> None:
        """Show the picture that is newest now, with the time since its capture."""
        found = None if video is None else video()
        if found is None or found[0] is self._shown:
            return
        if self._html is None:
            self._html = self._gui.add_html("", order=-1.0)
        self._shown, delay = found
        self._html.content = _TEXT.format(data=base64.b64encode(self._shown).decode(), delay=1e3 * delay)
