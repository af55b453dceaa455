"""The web server of the viewer: local by default; reports a taken port."""

from __future__ import annotations

import contextlib
import io
import json
import logging
import socket
from html import escape

from palpate.errors import MissingExtraError, PortError

try:
    import viser
except ModuleNotFoundError as missing:
    raise MissingExtraError("the viewer", "viewer") from missing


_LOCAL = ("127.0.0.1", "localhost", "::1")
_ONE_PIXEL = "data:image/gif;base64,R0lGODlhAQABAAAAACH5BAEKAAEALAAAAAABAAEAAAICTAEAOw=="


def open_server(host: str, port: int, title: str) -> viser.ViserServer:
    """A server with the viewer's theme; port 0 takes a free port.

    Raises PortError when the port is taken or not allowed, or when the address is not one of this machine alone.
    """
    if host not in _LOCAL:
        raise PortError(
            f"the viewer does not serve on {host}",
            why="it has no password, and whoever opens it moves the hand",
            mend=f"from another machine use a tunnel: ssh -L {port or 8080}:127.0.0.1:{port or 8080} THIS_MACHINE",
        )
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((host, port))
        except OSError as error:
            raise PortError(
                f"port {port} cannot be used for the viewer",
                where=f"{host}:{port}",
                why=error.strerror or str(error),
                mend=f"close the other viewer, or choose another port: --port {port + 1}, or --port 0 for a free one",
            ) from error
        port = probe.getsockname()[1]
    logging.getLogger("websockets").setLevel(logging.ERROR)  # a browser that disconnects is not an error
    with contextlib.redirect_stdout(io.StringIO()):  # the caller prints the address
        server = viser.ViserServer(host=host, port=port, label=f"Palpate - {title}", verbose=False)
    server.gui.configure_theme(dark_mode=False, show_logo=False, show_share_button=False, brand_color=(48, 96, 130))
    # the page's own title is the widget library's: the only way to set it is a script of an element
    name = json.dumps(f"Palpate - {title}").replace("'", "")
    server.gui.add_html(f"<img src='{_ONE_PIXEL}' style='display:none' onload='document.title={escape(name, False)}'>")
    return server


def close_server(server: viser.ViserServer) -> None:
    """Closes the port and prints nothing."""
    with contextlib.redirect_stdout(io.StringIO()):
        server.stop()


def url(server: viser.ViserServer) -> str:
    """Address of the server for a browser."""
    return f"http://{server.get_host()}:{server.get_port()}"
