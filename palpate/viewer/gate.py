"""Who may talk to the viewer: only its own page, in a browser that knows the token where one is asked for.

A browser lets any web page open connections to this machine, but it says from which page they come (`Origin`) and by
which name the page reached the server (`Host`). A page of another origin, and a name that is not this machine's (DNS
rebinding), are refused. On an address other than loopback the first request carries a token in its address and gets a
cookie; the page and its web socket then come with the cookie. Without encryption: a token keeps strangers out, but not
those who can read the network's traffic.
"""

from __future__ import annotations

import hmac
import secrets
from collections.abc import Sequence
from http import HTTPStatus
from http.cookies import CookieError, SimpleCookie
from ipaddress import ip_address
from typing import TYPE_CHECKING, Protocol
from urllib.parse import parse_qs, urlsplit

if TYPE_CHECKING:
    from websockets.asyncio.server import ServerConnection
    from websockets.http11 import Request, Response

LOOPBACK = ("127.0.0.1", "localhost", "::1")
"""Addresses that only this machine can reach."""
MOST_CLIENTS = 16
"""Most web sockets at a time."""
_ASK = "Open the viewer by the whole address that Palpate printed, with its token.\n"
_ELSEWHERE = (
    "The viewer answers only its own page: this request comes from another page, or by another name than {names}.\n"
    "Open the address that Palpate printed; through a proxy of another name, run with --host and its token.\n"
)
_FULL = f"{MOST_CLIENTS} browsers watch already; close one of them.\n"
_HEADERS = (  # no other page may show the viewer in a frame and let the user click on it unseen
    ("X-Frame-Options", "DENY"),
    ("Content-Security-Policy", "frame-ancestors 'none'"),
    ("X-Content-Type-Options", "nosniff"),
    ("Referrer-Policy", "no-referrer"),
    ("Cross-Origin-Resource-Policy", "same-origin"),
)


class _Headers(Protocol):
    def get_all(self, key: str) -> Sequence[str]:
        """All values of a header."""
        ...


class Gate:
    """The check of each request.

    Args:
        host: address at which the server listens.
    """

    def __init__(self, host: str) -> None:
        self.token = "" if host in LOOPBACK else secrets.token_urlsafe(24)
        """Empty if no token is asked for."""
        self.clients = 0
        """Web sockets that are open."""
        self._cookie = f"palpate_{secrets.token_hex(4)}"  # browsers share cookies between the ports of a host

    def answer(self, connection: ServerConnection, request: Request) -> Response | None:
        """The answer to a request that is refused, or that brings the token; None for one that may go on."""
        headers = request.headers
        if not self._is_own(headers):
            return _respond(connection, HTTPStatus.FORBIDDEN, _ELSEWHERE.format(names=", ".join(LOOPBACK)))
        if self.token and not self._knows_cookie(headers):
            if not self._knows_token(request.path):
                return _respond(connection, HTTPStatus.UNAUTHORIZED, _ASK)
            welcome = _respond(connection, HTTPStatus.SEE_OTHER, "")
            welcome.headers["Location"] = "/"  # the token leaves the address bar
            welcome.headers["Set-Cookie"] = f"{self._cookie}={self.token}; Path=/; HttpOnly; SameSite=Lax"
            return welcome
        if "Upgrade" in headers and self.clients >= MOST_CLIENTS:
            return _respond(connection, HTTPStatus.SERVICE_UNAVAILABLE, _FULL)
        return None

    def _is_own(self, headers: _Headers) -> bool:
        """True if the request reached the server by its own name, and comes from its own page or from no page."""
        hosts, origins = headers.get_all("Host"), headers.get_all("Origin")
        if len(hosts) != 1 or len(origins) > 1:
            return False
        if not self.token and not _is_loopback(hosts[0]):
            return False  # with a token the name is free: a page by another name does not have the cookie
        return not origins or origins[0].lower() in (f"http://{hosts[0].lower()}", f"https://{hosts[0].lower()}")

    def _knows_token(self, path: str) -> bool:
        return self._is_token(parse_qs(urlsplit(path).query).get("token", [""])[-1])

    def _knows_cookie(self, headers: _Headers) -> bool:
        for value in headers.get_all("Cookie"):
            try:
                found = SimpleCookie(value).get(self._cookie)
            except CookieError:
                continue
            if found is not None and self._is_token(found.value):
                return True
        return False

    def _is_token(self, given: str) -> bool:
        """Compares in a time that does not depend on the number of right characters."""
        return hmac.compare_digest(given.encode("utf-8", "replace"), self.token.encode())


def _is_loopback(host: str) -> bool:
    """True for a `Host` that names this machine by its loopback address, with any port (a tunnel has its own)."""
    try:
        parts = urlsplit(f"//{host}")
        name = parts.hostname or ""
        _ = parts.port
        if parts.netloc != host or "@" in host:
            return False
    except ValueError:
        return False
    if name == "localhost" or name.endswith(".localhost"):
        return True
    try:
        return ip_address(name).is_loopback
    except ValueError:
        return False


def _respond(connection: ServerConnection, status: HTTPStatus, text: str) -> Response:
    response = connection.respond(status, text)
    response.headers["Cache-Control"] = "no-store"
    return with_headers(response)


def with_headers(response: Response) -> Response:
    """The response with the headers that forbid other pages to frame or read it."""
    for name, value in _HEADERS:
        if name not in response.headers:
            response.headers[name] = value
    return response
