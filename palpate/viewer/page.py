"""The page of the viewer: the library's own, with a script in front of it that adapts the picture to the browser."""

from __future__ import annotations

import shutil
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.resources import files
from pathlib import Path
from typing import Any

import viser
from viser import infra

_LOCK = threading.Lock()


def write_page(folder: Path) -> None:
    """Writes the page into a folder: the library's file with `picture.js` before its first script."""
    page = (Path(viser.__file__).parent / "client" / "build" / "index.html").read_text(encoding="utf-8")
    script = files("palpate.viewer").joinpath("picture.js").read_text(encoding="utf-8")
    (folder / "index.html").write_text(page.replace("<head>", f"<head><script>{script}</script>", 1), encoding="utf-8")


@contextmanager
def own_page() -> Iterator[None]:
    """Servers made meanwhile send our page. The library has no argument for it: only its web server takes a folder."""

    class Server(infra.WebsockServer):  # type: ignore[misc, unused-ignore]
        """The library's web server with another folder of files, which it reads at the first request."""

        def __init__(self, *args: Any, **kwargs: Any) -> None:
            self._folder = Path(tempfile.mkdtemp(prefix="palpate-viewer-"))
            write_page(self._folder)
            super().__init__(*args, **(kwargs | {"http_server_root": self._folder}))

        def stop(self) -> None:
            super().stop()
            shutil.rmtree(self._folder, ignore_errors=True)

    with _LOCK:
        given = infra.WebsockServer
        infra.WebsockServer = Server  # type: ignore[misc]
        try:
            yield
        finally:
            infra.WebsockServer = given  # type: ignore[misc]
