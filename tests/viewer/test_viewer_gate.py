"""A viewer on an address other than loopback is closed without its token: real requests, with and without it."""

import http.client
from urllib.parse import urlsplit

import pytest
import viser
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from palpate.base.errors import PortError
from palpate.viewer.gate import Gate
from palpate.viewer.server import close_server, open_server, url

OTHER = "127.0.0.2"
"""Also this machine alone, but not the viewer's default address: treated as any network address."""


@pytest.fixture(scope="module")
def address():
    server = open_server(OTHER, 0, "scene")
    yield urlsplit(url(server))
    close_server(server)


def get(address, target, **headers):
    connection = http.client.HTTPConnection(address.hostname, address.port, timeout=20)
    connection.request("GET", target, headers=headers)
    answer = connection.getresponse()
    return answer.status, dict(answer.getheaders()), answer.read()


def cookie_of(address):
    return get(address, f"/?{address.query}")[1]["Set-Cookie"].partition(";")[0]


def test_address_with_the_token_opens_the_page(address):
    status, headers, _ = get(address, f"/?{address.query}")
    assert status == 303
    assert headers["Location"] == "/", "the token leaves the address bar"
    assert {"HttpOnly", "SameSite=Lax"} <= set(headers["Set-Cookie"].split("; "))
    status, _, page = get(address, "/", Cookie=headers["Set-Cookie"].partition(";")[0])
    assert status == 200
    assert b"<html" in page.lower()
    status, _, _ = get(address, "/", Cookie=f"theme=dark; {cookie_of(address)}; other=1")
    assert status == 200


@pytest.mark.parametrize("target", ["/", "/?token=", "/?token=wrong", "/index.html", "/?tokens={token}"])
def test_without_the_token_nothing_is_served(address, target):
    status, headers, body = get(address, target.format(token=address.query.partition("=")[2]))
    assert status == 401
    assert "Set-Cookie" not in headers
    assert body.startswith(b"Open the viewer by the whole address")
    assert int(headers["Content-Length"]) == len(body)


def test_wrong_cookies_are_refused(address):
    name, _, token = cookie_of(address).partition("=")
    for wrong in (
        f"{name}={token[:-1]}",
        f"{name}=",
        f"other={token}",
        f"{name}={token}x",
        "\xff=;;",
        f"{name}\u00e9=1",
    ):
        assert get(address, "/", Cookie=wrong)[0] == 401


def test_web_socket_needs_the_cookie(address):
    socket = f"ws://{address.netloc}/"
    known = {"subprotocols": [f"viser-v{viser.__version__}"]}
    with pytest.raises(InvalidStatus) as refused:
        connect(socket, **known)
    assert refused.value.response.status_code == 401
    with connect(socket, additional_headers={"Cookie": cookie_of(address)}, **known) as opened:
        assert len(opened.recv(timeout=20)) > 0


def test_garbage_and_long_heads_end_the_connection_and_the_next_request_is_served(address):
    import socket

    for garbage in (b"\r\n\r\n", b"\x00\xff" * 400 + b"\r\n\r\n", b"GET / HTTP/1.1\r\nX: " + b"a" * 70_000):
        with socket.create_connection((address.hostname, address.port), timeout=20) as raw:
            raw.sendall(garbage)
            raw.shutdown(socket.SHUT_WR)
            try:
                answer = raw.recv(100)
            except ConnectionError:
                answer = b""
            assert b"200 OK" not in answer
    assert get(address, f"/?{address.query}")[0] == 303


def test_tokens_are_random_and_long():
    tokens = {Gate(OTHER).token for _ in range(3)}
    assert len(tokens) == 3
    assert min(map(len, tokens)) >= 32


def test_loopback_stays_without_a_token():
    server = open_server("127.0.0.1", 0, "scene")
    try:
        assert "token" not in url(server)
        assert get(urlsplit(url(server)), "/")[0] == 200
    finally:
        close_server(server)


def test_strange_address_and_taken_port_are_named():
    with pytest.raises(PortError, match=r"192\.0\.2\.7 is not an address of this machine"):
        open_server("192.0.2.7", 0, "scene")
    server = open_server(OTHER, 0, "scene")
    try:
        with pytest.raises(PortError, match=f"port {server.get_port()} cannot be used"):
            open_server(OTHER, server.get_port(), "scene")
    finally:
        close_server(server)
