"""The web server of the viewer: local by default; reports a taken port."""

from __future__ import annotations

import contextlib
import io
import logging
import socket

from palpate.errors import MissingExtraError, PortError
from palpate.viewer import views
from palpate.viewer.stage import Stage

try:
    import viser
except ModuleNotFoundError as missing:
    raise MissingExtraError("the viewer", "viewer") from missing


def open_server(host: str, port: int, stage: Stage) -> viser.ViserServer:
    """A server with the viewer's theme and camera; port 0 takes a free port.

    Raises PortError when the port is taken or not allowed.
    """
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
        server = viser.ViserServer(host=host, port=port, label=f"Palpate - {stage.title}", verbose=False)
    server.gui.configure_theme(dark_mode=False, show_logo=False, show_share_button=False, brand_color=(48, 96, 130))
    views.start_with(server, views.overview(stage))
    return server


def close_server(server: viser.ViserServer) -> None:
    """Closes the port and prints nothing."""
    with contextlib.redirect_stdout(io.StringIO()):
        server.stop()


def url(server: viser.ViserServer) -> str:
    """Address of the server for a browser."""
    return f"http://{server.get_host()}:{server.get_port()}"
