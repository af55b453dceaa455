"""A relay between both ends: packets pass through the emulator of the studies, the reliable channel passes as it is."""

from __future__ import annotations

import contextlib
import errno
import heapq
import select
import socket
import threading
import time

from palpate import _network
from palpate.base.errors import PalpateError
from palpate.session.network.channel import arrived
from palpate.session.network.conditions import Network

_WAIT = 1e-3  # longest wait for a packet [s]


class Relay:
    """Listens on one port, and passes everything on to another address.

    Args:
        port: port of UDP and TCP on 127.0.0.1, or on `host`; 0: any free one.
        to: address of the follower's end.
        link: what happens to the packets of both directions.

    Raises:
        PalpateError: the port is taken.
    """

    def __init__(self, port: int, to: tuple[str, int], link: Network, seed: int = 0, host: str = "127.0.0.1") -> None:
        self._to, self.stopped = to, threading.Event()  #: ends `run`
        self._links = (_network.Link(link.to_site, seed + 1), _network.Link(link.to_operator, seed + 2))
        self._tcp, self._front = listen(host, port)
        self.port = int(self._tcp.getsockname()[1])  #: the port on which it listens
        self._back = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._back.setblocking(False)
        self._master: tuple[str, int] | None = None
        self._flight: list[tuple[float, int, bool, bytes]] = []
        self.passed = self.lost = 0  #: packets

    def run(self) -> None:
        """Pass packets on until `stop`."""
        threading.Thread(target=self._accept, name="palpate-relay", daemon=True).start()
        begin = time.monotonic()
        while not self.stopped.is_set():
            now = time.monotonic() - begin
            wait = min(max(self._flight[0][0] - now, 0.0), _WAIT) if self._flight else _WAIT
            for ready in select.select([self._front, self._back], [], [], wait)[0]:
                self._take(ready, begin)
            self._send(time.monotonic() - begin)
        close(self._tcp, self._front, self._back)

    def stop(self) -> None:
        """End `run`."""
        self.stopped.set()

    def _take(self, ready: socket.socket, begin: float) -> None:
        forwards = ready is self._front
        for data, sender in arrived(ready):
            if forwards:
                self._master = sender
            now = time.monotonic() - begin  # after its reading: no packet is delayed by less than the link's delay
            arrivals = self._links[0 if forwards else 1].send(now, len(data))
            self.lost += not arrivals
            for at in arrivals:
                self.passed += 1
                heapq.heappush(self._flight, (at, self.passed, forwards, data))

    def _send(self, now: float) -> None:
        while self._flight and self._flight[0][0] <= now:
            _, _, forwards, data = heapq.heappop(self._flight)
            try:
                if forwards:
                    self._back.sendto(data, self._to)
                elif self._master is not None:
                    self._front.sendto(data, self._master)
            except OSError:
                self.lost += 1

    def _accept(self) -> None:
        while not self.stopped.is_set():
            try:
                near, _ = self._tcp.accept()
            except OSError:
                continue
            try:
                far = socket.create_connection(self._to, 5.0)
            except OSError:  # nobody is there: the operator's end is told at once
                near.close()
                continue
            far.settimeout(None)
            for one, other in ((near, far), (far, near)):
                threading.Thread(target=_pump, args=(one, other), daemon=True).start()


def _pump(source: socket.socket, sink: socket.socket) -> None:
    try:
        while data := source.recv(65536):
            sink.sendall(data)
    except OSError:
        pass
    finally:
        _end(source, sink)


def _end(*sockets: socket.socket) -> None:
    for each in sockets:
        with contextlib.suppress(OSError):
            each.shutdown(socket.SHUT_RDWR)


def close(*sockets: socket.socket) -> None:
    """Close sockets on which other threads may wait in accept or recv, which only shutdown ends."""
    _end(*sockets)
    for each in sockets:
        each.close()


def listen(host: str, port: int) -> tuple[socket.socket, socket.socket]:
    """Sockets of TCP and UDP on the same port; 0: any that is free for both.

    Raises:
        PalpateError: the port is taken, or the host has no such address.
    """
    tcp = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    tcp.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        tcp.bind((host, port))
        udp.bind((host, tcp.getsockname()[1]))
    except (OSError, OverflowError, UnicodeError) as error:
        tcp.close()
        udp.close()
        raise _unusable(host, port, error) from None
    tcp.listen(8)
    udp.setblocking(False)
    return tcp, udp


def _unusable(host: str, port: int, error: Exception) -> PalpateError:
    """Why nothing can listen there."""
    every = "give an address of this machine, or --host 0.0.0.0 for all of them"
    if isinstance(error, (socket.gaierror, UnicodeError)):
        return PalpateError(f"--host {host[:80]}: the name does not resolve", why=str(error), mend=every)
    if isinstance(error, OSError) and error.errno == errno.EADDRNOTAVAIL:
        return PalpateError(f"--host {host}: this machine has no such address", mend=every)
    return PalpateError(f"port {port} of {host} cannot be used", why=str(error),
                        mend="give another --port or --host, or end what uses it")  # fmt: skip
