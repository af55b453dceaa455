"""The page of the viewer: the library's own, with a script in front of it that adapts the picture to the browser.

Its web server lets a `Gate` decide about each request, and takes in only the messages that our page sends.
"""

from __future__ import annotations

import asyncio
import functools
import logging
import math
import shutil
import tempfile
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib.resources import files
from pathlib import Path
from typing import Any

import viser
import websockets.asyncio.server
from viser import _messages, infra
from websockets.asyncio.server import ServerConnection

from palpate.viewer import xr
from palpate.viewer.gate import MOST_CLIENTS, Gate, with_headers

MOST_MESSAGE = 4 << 20
"""Largest message of a browser [bytes]: a picture that it drew is the largest one that we ask for."""
MOST_SOCKETS = 4 * MOST_CLIENTS
"""Most connections at a time, of which some ask for files and some send nothing."""
_UNUSED = (  # we offer no uploads, forms and commands; a shared address would open the viewer to the internet
    _messages.FileTransferStartUpload,
    _messages.FileTransferPart,
    _messages.GuiFormSubmitMessage,
    _messages.GuiFormDirtyMessage,
    _messages.CommandTriggerMessage,
    _messages.ShareUrlRequest,
    _messages.ShareUrlDisconnect,
)
_LOCK = threading.Lock()


def write_page(folder: Path) -> None:
    """Writes the page into a folder: the library's file with our scripts before its first one."""
    page = (Path(viser.__file__).parent / "client" / "build" / "index.html").read_text(encoding="utf-8")
    texts = [
        files("palpate.viewer").joinpath(name).read_text(encoding="utf-8")
        for name in ("picture.js", "tone.js", "xr.js")
    ]
    scripts = "".join(f"<script>{text}</script>" for text in texts)
    (folder / "index.html").write_text(page.replace("<head>", f"<head>{scripts}", 1), encoding="utf-8")


@contextmanager
def own_page(gate: Gate) -> Iterator[None]:
    """Servers made meanwhile send our page, and ask the gate. The library has no arguments for it."""

    class Server(infra.WebsockServer):  # type: ignore[misc, unused-ignore]
        """The library's web server with another folder of files, which it reads at the first request."""

        def __init__(self, *args: Any, **kwargs: Any) -> None:
            self._folder = Path(tempfile.mkdtemp(prefix="palpate-viewer-"))
            write_page(self._folder)
            self.controls: Mapping[str, Any] = {}
            super().__init__(*args, **(kwargs | {"http_server_root": self._folder}))

        def register_handler(self, message_cls: Any, callback: Any) -> None:
            if message_cls not in _UNUSED:
                super().register_handler(message_cls, callback)

        async def _handle_incoming_message(self, client_id: Any, message: Any) -> None:
            if is_sound(message, self.controls):
                await super()._handle_incoming_message(client_id, message)

        def stop(self) -> None:
            super().stop()
            shutil.rmtree(self._folder, ignore_errors=True)

    with _LOCK:
        given, serve = infra.WebsockServer, websockets.asyncio.server.serve
        infra.WebsockServer = Server  # type: ignore[misc]
        websockets.asyncio.server.serve = functools.partial(_serve, serve, gate)  # type: ignore[misc, assignment]
        try:
            yield
        finally:
            infra.WebsockServer = given  # type: ignore[misc]
            websockets.asyncio.server.serve = serve  # type: ignore[misc]


def _serve(serve: Any, gate: Gate, handler: Any, *args: Any, process_request: Any, **kwargs: Any) -> Any:
    """The library's server with the gate in front of it, and limits of messages, clients and connections."""
    sockets: set[ServerConnection] = set()

    class Connection(ServerConnection):
        def connection_made(self, transport: Any) -> None:
            sockets.add(self)
            super().connection_made(transport)
            if len(sockets) > MOST_SOCKETS:
                transport.abort()

        def connection_lost(self, exc: Exception | None) -> None:
            sockets.discard(self)
            super().connection_lost(exc)

    def ask(connection: ServerConnection, request: Any) -> Any:
        refused = gate.answer(connection, request)
        if refused is not None:
            return refused
        response = process_request(connection, request)
        return None if response is None else with_headers(response)

    async def handle(connection: ServerConnection) -> None:
        if connection.request is not None and connection.request.path == xr.PATH:  # beside the page's own web socket
            await xr.serve(connection)
            return
        gate.clients += 1
        try:
            await handler(connection)
        except Exception as error:  # bytes that are no message of the page: the connection ends
            logging.getLogger("palpate.viewer").debug("a browser's connection ended: %s", error)
        finally:
            gate.clients -= 1

    asyncio.get_running_loop().set_exception_handler(_note)  # of messages that the library cannot take in
    limits = {"max_size": MOST_MESSAGE, "max_queue": 4, "open_timeout": 10.0}
    return serve(
        handle, *args, **{**kwargs, **limits}, process_request=ask, create_connection=Connection,
        logger=_quiet(logging.getLogger("palpate.viewer.requests")),
    )  # fmt: skip


def _note(loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
    logging.getLogger("palpate.viewer").debug("%s: %s", context.get("message"), context.get("exception"))


def _quiet(logger: logging.Logger) -> logging.Logger:
    """A logger that does not write to the terminal: requests of strangers are no events of a run."""
    logger.propagate = False
    if not logger.handlers:
        logger.addHandler(logging.NullHandler())
    return logger


def take_in_by(server: viser.ViserServer) -> None:
    """Let a server made by `own_page` compare the values that browsers send with the ranges of its controls."""
    server._websock_server.controls = server.gui._gui_input_handle_from_uuid  # type: ignore[attr-defined]


def is_sound(message: Any, controls: Mapping[str, Any]) -> bool:
    """True for a message that our page may send: its numbers are finite, the value of a control is in its range.

    The library sets any attribute of a control that a message names.
    """
    if not _is_finite(vars(message)):
        return False
    if not isinstance(message, _messages.GuiUpdateMessage):
        return True
    control, value = controls.get(message.uuid), message.updates.get("value")
    if control is None or set(message.updates) - {"value"}:
        return False
    if hasattr(control, "options"):
        return value in control.options
    low, high = getattr(control, "min", None), getattr(control, "max", None)
    if isinstance(low, int | float) and isinstance(high, int | float):
        return isinstance(value, int | float) and low <= value <= high
    return isinstance(value, bool) if isinstance(control.value, bool) else True


def _is_finite(value: Any) -> bool:
    if isinstance(value, float):
        return math.isfinite(value)
    if isinstance(value, dict):
        return all(map(_is_finite, value.values()))
    if isinstance(value, list | tuple):
        return all(map(_is_finite, value))
    return True
