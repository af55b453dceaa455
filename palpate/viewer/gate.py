"""Lets only browsers with a token reach the viewer from other machines: a relay in front of the viewer's local server.

The first request carries the token in its address and gets a cookie; the page, its files and its web socket then come
with the cookie. A relay, because the viewer's server offers no place for a check. Without encryption: a token keeps
strangers out, but not those who can read the network's traffic.
"""

from __future__ import annotations

import asyncio
import contextlib
import hmac
import secrets
import threading
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qs, urlsplit

_HEAD = 32_768  # largest head of a request [bytes]
_PATIENCE = 10.0  # time for the head of a request [s]
_BLOCK = 65_536
_WORDS = b"Open the viewer by the whole address that Palpate printed, with its token.\n"
_REFUSED = (
    b"HTTP/1.1 401 Unauthorized\r\nContent-Type: text/plain; charset=utf-8\r\nConnection: close\r\n"
    b"Cache-Control: no-store\r\nContent-Length: %d\r\n\r\n%s" % (len(_WORDS), _WORDS)
)


class Gate:
    """A relay from an address of this machine to a server on loopback, for requests with a token.

    Args:
        host: address to bind to.
        port: port to bind to; 0 for a free one.
        inner: port of the server on 127.0.0.1.

    Raises:
        OSError: the address cannot be used.
    """

    def __init__(self, host: str, port: int, inner: int) -> None:
        self.token = secrets.token_urlsafe(24)
        self.host = host
        self._inner = inner
        self._loop = asyncio.new_event_loop()
        self._tasks: set[asyncio.Task[None]] = set()
        try:
            self._server = self._loop.run_until_complete(asyncio.start_server(self._serve, host, port, limit=_HEAD))
        except OSError:
            self._loop.close()
            raise
        self.port = int(self._server.sockets[0].getsockname()[1])
        self._cookie = f"palpate_{self.port}"  # browsers share cookies between the ports of a host
        self._thread = threading.Thread(target=self._loop.run_forever, name="palpate-gate", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Frees the port and ends all connections."""

        async def end() -> None:
            self._server.close()
            for task in self._tasks:
                task.cancel()
            await asyncio.gather(*self._tasks, return_exceptions=True)

        asyncio.run_coroutine_threadsafe(end(), self._loop).result(timeout=5.0)
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(timeout=5.0)
        self._loop.close()

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        task = asyncio.current_task()
        assert task is not None
        self._tasks.add(task)
        try:
            head = await asyncio.wait_for(reader.readuntil(b"\r\n\r\n"), _PATIENCE)
            if self._knows_cookie(head):
                await self._relay(head, reader, writer)
            else:
                writer.write(self._welcome() if self._knows_token(head) else _REFUSED)
                await writer.drain()
        except (OSError, asyncio.IncompleteReadError, asyncio.LimitOverrunError, TimeoutError, asyncio.CancelledError):
            pass  # the browser went away, sent no request, or the viewer closes
        finally:
            self._tasks.discard(task)
            writer.close()

    async def _relay(self, head: bytes, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Both directions until either end closes; later requests of the same connection come from the same browser."""
        inner_reader, inner_writer = await asyncio.open_connection("127.0.0.1", self._inner)
        inner_writer.write(head)
        ways = [asyncio.create_task(_copy(reader, inner_writer)), asyncio.create_task(_copy(inner_reader, writer))]
        try:
            await asyncio.wait(ways, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for way in ways:
                way.cancel()
            await asyncio.gather(*ways, return_exceptions=True)
            inner_writer.close()

    def _welcome(self) -> bytes:
        """Sets the cookie, and leads to an address without the token."""
        cookie = f"{self._cookie}={self.token}; Path=/; HttpOnly; SameSite=Lax"
        return (
            "HTTP/1.1 303 See Other\r\nLocation: /\r\nContent-Length: 0\r\nConnection: close\r\n"
            f"Cache-Control: no-store\r\nReferrer-Policy: no-referrer\r\nSet-Cookie: {cookie}\r\n\r\n"
        ).encode()

    def _knows_token(self, head: bytes) -> bool:
        words = head.split(b"\r\n", 1)[0].split(b" ")
        if len(words) != 3 or words[0] != b"GET":
            return False
        given = parse_qs(urlsplit(words[1].decode("latin-1")).query).get("token", [""])[-1]
        return self._is_token(given)

    def _knows_cookie(self, head: bytes) -> bool:
        for line in head.split(b"\r\n")[1:]:
            name, _, value = line.partition(b":")
            if name.strip().lower() != b"cookie":
                continue
            with contextlib.suppress(CookieError):
                found = SimpleCookie(value.strip().decode("latin-1")).get(self._cookie)
                if found is not None and self._is_token(found.value):
                    return True
        return False

    def _is_token(self, given: str) -> bool:
        """Compares in a time that does not depend on the number of right characters."""
        return hmac.compare_digest(given.encode(), self.token.encode())


async def _copy(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    with contextlib.suppress(OSError):
        while data := await reader.read(_BLOCK):
            writer.write(data)
            await writer.drain()
