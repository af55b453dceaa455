"""Serves the viewer from the command line: on this machine only, on the first free port, until Ctrl-C."""

from __future__ import annotations

import importlib.util
import socket
from typing import TYPE_CHECKING

from palpate.console.output import say
from palpate.errors import MissingExtraError, PortError

if TYPE_CHECKING:
    from rich.console import Console

    from palpate.record.reader import Record
    from palpate.record.ticks import Ticks
    from palpate.session import Session
    from palpate.viewer.stage import Stage

HOST = "127.0.0.1"
_TRIES = 20


def require_viewer() -> None:
    """Check before the run that the viewer is installed.

    Raises:
        MissingExtraError: the viewer is not installed.
    """
    if importlib.util.find_spec("viser") is None:
        raise MissingExtraError("the 3-D viewer", "viewer")


def free_port(wanted: int) -> int:
    """The wanted port, or the next free one above it.

    Raises:
        PortError: the number is not a port, or this port and the next ones are all taken.
    """
    if not 0 < wanted < 65536:
        raise PortError(f"port {wanted} does not exist", mend="choose one from 1024 to 65535, e.g. --port 8080")
    last = min(wanted + _TRIES, 65536) - 1
    for port in range(wanted, last + 1):
        with socket.socket() as s:
            s.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                s.bind((HOST, port))
            except OSError:
                continue
            return port
    raise PortError(
        f"ports {wanted} to {last} are all taken or not allowed",
        where=HOST,
        mend="stop another viewer, or choose a port with --port",
    )


def serve(shown: Session | Record | tuple[Stage, Ticks], port: int, console: Console) -> None:
    """Serve a session (live), a record, or a stage with its ticks until Ctrl-C."""
    from palpate import viewer

    free = free_port(port)
    if free != port:
        say(console, f"port {port} is taken; using {free}")
    try:
        viewer.serve(
            shown, host=HOST, port=free, on_ready=lambda url: say(console, f"viewer: {url}   (Ctrl-C ends it)")
        )
    except KeyboardInterrupt:
        say(console, "viewer closed")
