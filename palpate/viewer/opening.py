"""The page before its scene is ready: it opens at once and lists what is being loaded."""

from __future__ import annotations

import time
from html import escape

from palpate.viewer.server import close_server, open_server, url


class Opening:
    """A viewer's page with lines about the progress of loading.

    Args:
        title: title of the scene.
        host: address to bind to.
        port: 0 takes a free one.

    Raises:
        PortError: the port cannot be used.
    """

    def __init__(self, title: str, host: str = "127.0.0.1", port: int = 8080) -> None:
        self.server = open_server(host, port, title)
        self.url = url(self.server)
        self._began = time.perf_counter()
        self._lines: list[str] = []
        self._text = self.server.gui.add_html("")
        self.say("loading the scene")

    def say(self, line: str) -> None:
        """Add a line with the time since the page opened."""
        self._lines.append(f"{time.perf_counter() - self._began:4.1f} s &nbsp; {escape(line)}")
        shown = "<br>".join(self._lines)
        self._text.content = f'<div style="padding:8px 10px;font-size:13px" id="palpate-loading">{shown} ...</div>'

    def close(self) -> None:
        """Close the server: loading failed."""
        close_server(self.server)

    def done(self) -> None:
        """Remove the lines."""
        self._text.remove()
