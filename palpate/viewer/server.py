"""The web server of the viewer: for its own page only, behind a token on other addresses; reports a taken port."""

from __future__ import annotations

import contextlib
import errno
import io
import json
import logging
import socket
from html import escape
from weakref import WeakKeyDictionary

from palpate.base.errors import MissingExtraError, PortError
from palpate.devices.webxr import PAGES
from palpate.viewer.gate import Gate

try:
    import viser

    from palpate.viewer.page import own_page, take_in_by
except ModuleNotFoundError as missing:
    raise MissingExtraError("the viewer", "viewer") from missing


_GATES: WeakKeyDictionary[viser.ViserServer, Gate] = WeakKeyDictionary()
NARROW = 1200
"""Width of a window up to which the panels are narrow: half of a wider one is left to the picture [pixels]."""
_STYLE = (  # the panels' contents follow their width: by default they keep 220 pixels, and are cut off
    "<style>"
    ".mantine-ScrollArea-content{min-width:0!important;width:100%!important;display:block!important}"
    ".uplot-container{max-width:100%}"
    # in a narrow panel a slider beside its label and its number would have no length
    f"@media (max-width:{NARROW}px){{"
    ".mantine-Flex-root:has(>div>.mantine-Flex-root>.mantine-Slider-root){flex-direction:column;align-items:stretch!important}"
    "}"
    "</style>"
)
_ONE_PIXEL = "data:image/gif;base64,R0lGODlhAQABAAAAACH5BAEKAAEALAAAAAABAAEAAAICTAEAOw=="


def open_server(host: str, port: int, title: str) -> viser.ViserServer:
    """A server with the viewer's theme; port 0 takes a free port.

    An address other than loopback asks for a random token, which `url` contains.

    Raises PortError when the address or the port cannot be used.
    """
    port = _free(host, port)
    gate = Gate(host)
    server = _viser(host, port, title, gate)
    _GATES[server] = gate
    PAGES.add(id(server))
    return server


def _free(host: str, port: int) -> int:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    with socket.socket(family, socket.SOCK_STREAM) as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((host, port))
        except OSError as error:
            raise _refused(host, port, error) from error
        return int(probe.getsockname()[1])


def _refused(host: str, port: int, error: OSError) -> PortError:
    if error.errno in (errno.EADDRNOTAVAIL, None) or isinstance(error, socket.gaierror):
        return PortError(
            f"{host} is not an address of this machine",
            why=error.strerror or str(error),
            mend="name one of its addresses, or 0.0.0.0 for all of them",
        )
    return PortError(
        f"port {port} cannot be used for the viewer",
        where=f"{host}:{port}",
        why=error.strerror or str(error),
        mend=f"close the other viewer, or choose another port: --port {port + 1}, or --port 0 for a free one",
    )


def _viser(host: str, port: int, title: str, gate: Gate) -> viser.ViserServer:
    logging.getLogger("websockets").setLevel(logging.ERROR)  # a browser that disconnects is not an error
    with contextlib.redirect_stdout(io.StringIO()), own_page(gate):  # the caller prints the address
        server = viser.ViserServer(host=host, port=port, label=f"Palpate - {title}", verbose=False)
    take_in_by(server)
    server.gui.configure_theme(dark_mode=False, show_logo=False, show_share_button=False, brand_color=(48, 96, 130))
    # the page's own title is the widget library's: the only way to set it is a script of an element
    name = json.dumps(f"Palpate - {title}").replace("'", "")
    script = f"document.title={escape(name, False)}"
    server.gui.add_html(f"{_STYLE}<img src='{_ONE_PIXEL}' style='display:none' onload='{script}'>")
    return server


def close_server(server: viser.ViserServer) -> None:
    """Closes the port and prints nothing."""
    _GATES.pop(server, None)
    PAGES.discard(id(server))
    with contextlib.redirect_stdout(io.StringIO()):
        server.stop()


def url(server: viser.ViserServer) -> str:
    """Address of the server for a browser, with the token if it needs one."""
    gate, host, port = _GATES.get(server), server.get_host(), server.get_port()
    if gate is None or not gate.token:
        return f"http://{f'[{host}]' if ':' in host else host}:{port}"
    host = socket.gethostname() if host in ("0.0.0.0", "::") else host
    return f"http://{f'[{host}]' if ':' in host else host}:{port}/?token={gate.token}"
