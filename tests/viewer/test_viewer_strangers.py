"""The viewer answers its own page alone: real sockets with forged headers, and a page of another origin in Chromium."""

import http.server
import socket
import threading
import time
from contextlib import closing, contextmanager, suppress
from urllib.parse import urlsplit

import msgspec
import pytest
import viser
from browser import CHROMIUM, FLAGS
from test_viewer_gate import OTHER, cookie_of, get
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from palpate.viewer.gate import MOST_CLIENTS
from palpate.viewer.page import MOST_MESSAGE, MOST_SOCKETS
from palpate.viewer.server import close_server, open_server, url

PROTOCOL = {"subprotocols": [f"viser-v{viser.__version__}"]}


@pytest.fixture(scope="module")
def server():
    opened = open_server("127.0.0.1", 0, "scene")
    yield opened
    close_server(opened)


def raw_answer(port, *lines, host="127.0.0.1"):
    """First line of the answer to a request of these lines."""
    with socket.create_connection((host, port), timeout=20) as peer:
        peer.sendall("\r\n".join([*lines, "", ""]).encode("latin-1"))
        return peer.recv(4096).split(b"\r\n", 1)[0].decode()


def upgrade(port, hosts, origins):
    """Status of a web socket's request with these headers."""
    lines = [f"Host: {one}" for one in hosts] + [f"Origin: {one}" for one in origins]
    more = [
        *("Upgrade: websocket", "Connection: Upgrade", "Sec-WebSocket-Version: 13"),
        *("Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==", f"Sec-WebSocket-Protocol: viser-v{viser.__version__}"),
    ]
    return int(raw_answer(port, "GET / HTTP/1.1", *lines, *more).split()[1])


@pytest.mark.parametrize("name", ["127.0.0.1", "localhost", "127.0.0.3", "sub.localhost", "[::1]"])
def test_the_page_itself_is_served_by_each_name_of_this_machine(server, name):
    port = server.get_port()
    for host in (f"{name}:{port}", f"{name}:9000", name):  # a tunnel has a port of its own
        assert upgrade(port, [host], [f"http://{host}"]) == 101
        assert upgrade(port, [host], [f"https://{host}"]) == 101
        assert " 200 " in raw_answer(port, "GET / HTTP/1.1", f"Host: {host}")
    assert upgrade(port, [f"{name}:{port}"], []) == 101, "a program is no web page"


@pytest.mark.parametrize(
    "origin",
    ["http://evil.example", "https://127.0.0.1.evil.example:{port}", "null", "http://127.0.0.1:1", "http://localhost:{port}",
     "http://127.0.0.1", "file://", "http://127.0.0.1:{port}@evil.example", "http://127.0.0.1:{port}/", "", "chrome-extension://a"],
)  # fmt: skip
def test_a_page_of_another_origin_is_refused(server, origin):
    port = server.get_port()
    own, other = f"127.0.0.1:{port}", origin.format(port=port)
    assert upgrade(port, [own], [other]) == 403
    assert " 403 " in raw_answer(port, "GET / HTTP/1.1", f"Host: {own}", f"Origin: {other}")


@pytest.mark.parametrize(
    "hosts",
    [["evil.example:{port}"], ["127.0.0.1.nip.example:{port}"], ["0.0.0.0:{port}"], ["192.168.1.7:{port}"], [],
     ["127.0.0.1:{port}", "evil.example"], ["evil@127.0.0.1:{port}"], ["127.0.0.1:{port}/x"],
     ["localhost.evil.example"]],
)  # fmt: skip
def test_another_name_is_refused_as_of_a_rebound_domain(server, hosts):
    port = server.get_port()
    names = [one.format(port=port) for one in hosts]
    assert upgrade(port, names, [f"http://{name}" for name in names[:1]]) in (400, 403)
    assert raw_answer(port, "GET / HTTP/1.1", *(f"Host: {one}" for one in names)).split()[1] in ("400", "403")


def test_with_a_token_the_cookie_alone_does_not_let_another_page_in():
    server = open_server(OTHER, 0, "scene")
    try:
        address = urlsplit(url(server))
        headers = {"Cookie": cookie_of(address)}
        socket_url = f"ws://{address.netloc}/"
        for origin in ("http://evil.example", f"http://{OTHER}:1", "null"):  # a page on another port shares the cookies
            with pytest.raises(InvalidStatus) as refused:
                connect(socket_url, additional_headers=headers, origin=origin, **PROTOCOL)
            assert refused.value.response.status_code == 403
        with connect(socket_url, additional_headers=headers, origin=f"http://{address.netloc}", **PROTOCOL) as opened:
            assert opened.recv(timeout=20)
    finally:
        close_server(server)


def test_no_page_may_show_the_viewer_in_a_frame(server):
    status, headers, _ = get(urlsplit(url(server)), "/")
    assert status == 200
    assert headers["X-Frame-Options"] == "DENY"
    assert headers["Content-Security-Policy"] == "frame-ancestors 'none'"


def opened(server):
    return connect(f"ws://127.0.0.1:{server.get_port()}", max_size=None, **PROTOCOL)


def test_number_of_clients_is_bounded_and_those_that_leave_make_room(server):
    held = []
    try:
        for _ in range(MOST_CLIENTS):
            held.append(opened(server))
            assert held[-1].recv(timeout=20)
        with pytest.raises(InvalidStatus) as refused:
            opened(server)
        assert refused.value.response.status_code == 503
    finally:
        for one in held:
            one.close()
    with closing(served_again(server)) as one:
        assert one.recv(timeout=20)


def drain(one):
    while True:
        one.recv(timeout=20)


def served_again(server):
    end = time.monotonic() + 20.0
    while True:
        try:
            return opened(server)
        except (InvalidStatus, OSError, EOFError):
            if time.monotonic() > end:
                raise
            time.sleep(0.05)


def test_connections_that_say_nothing_are_bounded(server):
    silent = [socket.create_connection(("127.0.0.1", server.get_port()), timeout=20) for _ in range(MOST_SOCKETS + 8)]
    try:
        closed = 0
        for one in silent:
            one.settimeout(0.05)
            try:
                closed += one.recv(1) == b""
            except TimeoutError:
                pass
            except ConnectionError:
                closed += 1
        assert closed >= 8
    finally:
        for one in silent:
            one.close()
    with closing(served_again(server)) as one:
        assert one.recv(timeout=20)


@pytest.mark.parametrize("size", [MOST_MESSAGE + 1, 4 * MOST_MESSAGE])
def test_a_long_message_ends_the_connection(server, size):
    with opened(server) as one:
        assert one.recv(timeout=20)
        with suppress(ConnectionClosed):
            one.send(bytes(size))
        with pytest.raises(ConnectionClosed):
            drain(one)
        assert one.close_code == 1009


def send(one, **message):
    one.send(msgspec.msgpack.encode(message))


@pytest.mark.parametrize("junk", [b"", b"\xff", b"\xc1" * 40, msgspec.msgpack.encode({"type": "NoSuchMessage"})])
def test_bytes_that_are_no_message_end_one_connection_and_print_nothing(server, junk, capfd):
    with opened(server) as one:
        one.recv(timeout=20)
        one.send(junk)
        with pytest.raises(ConnectionClosed):
            drain(one)
    with opened(server) as other:
        assert other.recv(timeout=20)
    said = capfd.readouterr()
    assert said.out + said.err == ""


def test_forged_values_of_controls_are_not_taken_in(server):
    """Only the value of a control, of its type and in its range; no attribute of the server's own objects."""
    slider = server.gui.add_slider("forged", 0.0, 3.0, 0.1, 1.0)
    choice = server.gui.add_dropdown("choice", ("a", "b"), initial_value="a")
    box = server.gui.add_checkbox("box", False)
    with opened(server) as one:
        one.recv(timeout=20)
        for control, value in (
            (slider, 1e9), (slider, -0.1), (slider, float("nan")), (slider, float("inf")), (slider, "2"),
            (slider, None), (slider, [1.0]), (choice, "c"), (choice, 7), (choice, {}), (box, "x"), (box, 5),
        ):  # fmt: skip
            send(one, type="GuiUpdateMessage", uuid=control._impl.uuid, updates={"value": value})
        send(one, type="GuiUpdateMessage", uuid=slider._impl.uuid, updates={"update_cb": []})
        send(one, type="GuiUpdateMessage", uuid=slider._impl.uuid, updates={"value": 2.0, "is_button": True})
        send(one, type="GuiUpdateMessage", uuid=slider._impl.uuid, updates={"value": 2.5})
        end = time.monotonic() + 20.0
        while slider.value == 1.0 and time.monotonic() < end:
            time.sleep(0.02)
    assert (slider.value, choice.value, box.value) == (2.5, "a", False)
    assert not slider._impl.is_button


def test_uploads_and_a_shared_address_are_not_offered(server):
    import viser._messages as messages

    held = server._websock_server._incoming_handlers
    for kind in ("FileTransferStartUpload", "FileTransferPart", "ShareUrlRequest", "GuiFormDirtyMessage"):
        assert not held.get(getattr(messages, kind)), kind
    uuid = server.gui.add_checkbox("any", False)._impl.uuid
    with opened(server) as one:
        one.recv(timeout=20)
        send(one, type="FileTransferStartUpload", source_component_uuid=uuid, transfer_uuid="u", filename="f",
             mime_type="m", part_count=10**9, size_bytes=10**12)  # fmt: skip
        send(
            one, type="FileTransferPart", source_component_uuid=uuid, transfer_uuid="u", part_index=0, content=bytes(9)
        )
        time.sleep(0.3)
    assert not server.gui._current_file_upload_states


PAGE = """<!doctype html><title>waiting</title><script>
const done = [];
function tell(what) { done.push(what); document.title = done.join(" "); }
for (const name of ["127.0.0.1", "localhost"]) {
  const one = new WebSocket(`ws://${name}:PORT`, ["viser-vVERSION"]);
  one.onmessage = () => tell("heard");
  one.onclose = (e) => tell("closed");
}
fetch("http://127.0.0.1:PORT/").then((r) => r.text()).then(() => tell("read"), () => tell("hidden"));
const frame = document.createElement("iframe");
frame.onload = () => setTimeout(() => tell(frame.contentDocument === null ? "framed-or-error" : "empty"), 500);
frame.src = "http://127.0.0.1:PORT/";
addEventListener("DOMContentLoaded", () => document.body.append(frame));
</script><body></body>"""


@contextmanager
def web_page(text):
    """Address of a page on another port of this machine: another origin."""

    class Handler(http.server.BaseHTTPRequestHandler):
        def do_GET(self):
            self.send_response(200)
            self.send_header("Content-Type", "text/html")
            self.end_headers()
            self.wfile.write(text.encode())

        def log_message(self, *arguments):
            pass

    site = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    threading.Thread(target=site.serve_forever, daemon=True).start()
    try:
        yield f"http://localhost:{site.server_address[1]}/"
    finally:
        site.shutdown()
        site.server_close()


def test_a_real_page_of_another_origin_hears_reads_and_frames_nothing(server):
    if CHROMIUM is None:
        pytest.skip("Chromium is not installed (Debian: apt-get install chromium), so no real page was tried")
    api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed (uv sync --group test)")
    text = PAGE.replace("PORT", str(server.get_port())).replace("VERSION", viser.__version__)
    seen = server._websock_server._live_connections
    with web_page(text) as address, api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        page = browser.new_page()
        page.set_default_timeout(90_000)
        page.goto(address)
        page.wait_for_function("document.title.split(' ').length >= 4")
        said = page.title().split()
        frames = [frame.url for frame in page.frames[1:]]
        own = browser.new_page()
        own.goto(url(server))
        own.wait_for_function("document.title.startsWith('Palpate')", timeout=90_000)
        browser.close()
    assert said.count("closed") == 2
    assert "heard" not in said
    assert "hidden" in said
    assert frames in (["chrome-error://chromewebdata/"], [])
    assert not seen or all(seen.values())
