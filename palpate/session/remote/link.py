"""The operator's end: a thread beside a session that exchanges packets with a follower, and updates the local model."""

from __future__ import annotations

import contextlib
import math
import socket
import threading
import time
from types import TracebackType
from typing import Any, Self

import numpy as np

from palpate import __version__, _network
from palpate.arrays import Array
from palpate.errors import PalpateError
from palpate.network import channel as channels
from palpate.session.live import LiveSession
from palpate.session.remote.site import PATIENCE, digest

UPDATE = 0.02  # period at which a changed model is handed to the loop [s]
MENDS = {
    "another operator": "end the other session, or wait until it has ended",
    "another scene": "use the same scene file on both machines",
    "Palpate": "install the same version on both machines",
    "clocks": "set the clocks of both machines, e.g. by NTP",
}
"""What to do about a refusal, by a part of its words."""
_IP_MTU = 14  # of the socket options of IP, on Linux
_HEADERS = 28  # of IPv4 and UDP [bytes]


class RemoteLink:
    """The link of a session to a follower's end.

    Args:
        session: the session whose hand feels the local model; it runs in real time.
        at: address of the follower's end, or of a relay to it.
        key: the shared key.
        rate: packets per second [Hz].

    Raises:
        PalpateError: nobody listens there, the other end refuses, or a packet does not fit through the network.
    """

    def __init__(self, session: LiveSession, at: tuple[str, int], key: bytes, rate: float = 1000.0) -> None:
        self._session, self._at, self._dt = session, at, 1.0 / rate
        self._model = _network.LocalModel(_network.UpdateOptions(), session.rig.snapshot)
        self._radius = session.rig.scene.contact.radius
        self._peer = _network.Peer()
        self._udp = _packets_to(at)
        self.port = int(self._udp.getsockname()[1])  #: port to which the packets of the follower come
        self._channel = self._connect(key)
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="palpate-remote", daemon=True)
        self._linked, self._port = False, _network.Port()
        self._last: tuple[float, Array] | None = None
        self._V = np.zeros(3)
        self.sent = self.received = 0  #: packets
        self.cpu = 0.0  #: processor time of the thread [s]
        self.lost_s = 0.0  #: time without link after the first [s]

    def _connect(self, key: bytes) -> channels.Channel:
        host, port = self._at
        try:
            connection = socket.create_connection(self._at, PATIENCE)
        except OSError as error:
            raise PalpateError(f"no follower answers at {host}:{port}", why=str(error),
                               mend="start it there: palpate serve follower SCENE") from None  # fmt: skip
        try:
            channel = channels.shake_hands(connection, key, operator=True)
            channel.send({"version": __version__, "scene": digest(self._session.rig.scene), "time": time.time()})
            answer = channel.receive()
        except OSError as error:
            raise PalpateError(f"the follower at {host}:{port} does not answer", why=str(error),
                               mend="is it a follower of Palpate?") from None  # fmt: skip
        if answer is None:
            raise channels.RefusedError("the follower has ended the connection",
                                        why="it has another key, or was stopped",
                                   mend="copy the same key file to both machines (palpate keys)")  # fmt: skip
        if "error" in answer:
            words = str(answer["error"])
            raise channels.RefusedError(words, mend=next((m for part, m in MENDS.items() if part in words), ""))
        connection.settimeout(None)
        return channel

    def __enter__(self) -> Self:
        """Begin to exchange packets."""
        self.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop, and tell the follower."""
        self.close()

    # -- running ---------------------------------------------------------------------------------------------------

    def start(self) -> None:
        """Begin to exchange packets; the hand feels nothing until the link stands."""
        self._session.change(hold_all=True)
        self._thread.start()

    def close(self) -> None:
        """Stop, and tell the follower."""
        self._stop.set()
        if self._thread.is_alive():
            self._thread.join()
        self._channel.close()
        self._udp.close()

    def _run(self) -> None:
        cpu, due, updated = time.thread_time(), time.monotonic(), 0.0
        while not self._stop.is_set():
            wait = due - time.monotonic()
            if wait > 0.0:
                time.sleep(wait)
            now = time.monotonic()
            due = max(due + self._dt, now - 0.02)
            self._receive()
            self._peer.step(now)
            tick = self._session.latest()
            p, v = self._motion(tick)
            self._learn(p, v, float(tick["t"]), now)
            self._hold_or_follow()
            self._send(tick, p, v, now)
            if now - updated > UPDATE:
                updated = now
                self._session.set_model(self._model.scene)
        self.cpu = time.thread_time() - cpu

    def _receive(self) -> None:
        for data, _ in channels.arrived(self._udp):
            payload = self._channel.opener.open(data)
            datagram = None if payload is None else _network.decode(payload)
            if datagram is None:
                continue
            self.received += 1
            if self._peer.receive(datagram, time.monotonic()):
                self._model.take(datagram.model)

    def _motion(self, tick: Any) -> tuple[Array, Array]:
        """Position [m] and velocity [m/s] of the local tool, which the remote one follows."""
        t, p = float(tick["t"]), np.array(tick["p_WT"], float)
        if self._last is not None and t > self._last[0]:
            self._V = (p - self._last[1]) / (t - self._last[0])
        if self._last is None or t > self._last[0]:
            self._last = (t, p)
        return p, self._V

    def _learn(self, p: Array, v: Array, t: float, now: float) -> None:
        newest = self._peer.newest
        ahead = self._peer.peer_time(now) + newest.play_delay - t
        self._model.synchronise(ahead)
        self._model.step(p, v, self._radius, t, self._dt)

    def _hold_or_follow(self) -> None:
        """Hold the hand's tool while the link is down; the loop's own ramps end and begin the force."""
        peer = self._peer
        aligned = peer.known and bool(peer.newest.flags & _network.FLAG_ALIGNED)
        linked = peer.known and not peer.lost and (self._linked or aligned)
        self.lost_s += self._dt * (not linked and self.received > 0)
        if linked != self._linked or (not linked and not self._session.controls.hold_all):
            self._linked = linked
            self._session.change(hold_all=not linked)

    def _send(self, tick: Any, p: Array, v: Array, now: float) -> None:
        d = _network.Datagram()
        X = np.eye(4)
        X[:3, 3] = p
        d.X, d.v, d.F = X, v, np.array(tick["F_T_W"], float)
        self._port.step(d.F, p)
        d.energy_in, d.energy_out = self._port.taken, self._port.given
        d.flags = _network.FLAG_ENGAGED
        self._peer.stamp(d, now)
        with contextlib.suppress(OSError):
            self._udp.send(self._channel.sealer.seal(_network.encode(d)))
            self.sent += 1

    # -- results ---------------------------------------------------------------------------------------------------

    def figures(self) -> dict[str, Any]:
        """What the link has measured; keys as in docs/json/run.md."""
        peer, clock, ages = self._peer, self._peer.clock, self._peer.arrivals
        objects = self._session.rig.snapshot.objects
        models = [
            {"object": obj.name, "stiffness_N_per_m": u.now.K, "shift_m": [float(x) for x in u.now.shift],
             "margin_N": u.now.margin} for obj, u in zip(objects, self._model.updates, strict=True)
        ]  # fmt: skip
        return {
            "at": f"{self._at[0]}:{self._at[1]}",
            "sent": self.sent,
            "received": self.received,
            "refused": self._channel.opener.refused,
            "age_p50_ms": 1e3 * ages.p50,
            "age_p99_ms": 1e3 * ages.p99,
            "round_trip_ms": 2e3 * clock.bound,
            "play_delay_ms": 1e3 * peer.newest.play_delay,
            "clock_bound_ms": 1e3 * clock.bound,
            "outages": ages.outages,
            "held_s": self.lost_s,
            "cpu_s": self.cpu,
            "force_site_N": float(np.linalg.norm(peer.newest.F)),
            "models": models,
        }

    def words(self) -> str:
        """One line about the link and what it has learnt."""
        f = self.figures()
        learnt = "; ".join(
            f"{m['object']}: {m['stiffness_N_per_m']:.0f} N/m, moved by {1e3 * math.hypot(*m['shift_m']):.1f} mm"
            for m in f["models"]
        )
        ages = f"newest packet {f['age_p50_ms']:.0f} ms old (99 %: {f['age_p99_ms']:.0f})"
        counts = f"{f['received']} packets received, {f['outages']} outages"
        return f"remote {f['at']}: round trip {f['round_trip_ms']:.0f} ms, {ages}, {counts}; {learnt}"


def _packets_to(at: tuple[str, int]) -> socket.socket:
    """A socket for packets to this address.

    Raises:
        PalpateError: a packet does not fit through the network there.
    """
    udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        udp.connect(at)
        mtu = udp.getsockopt(socket.IPPROTO_IP, _IP_MTU)
    except OSError as error:
        udp.close()
        raise PalpateError(f"{at[0]} cannot be reached", why=str(error), mend="is the network up?") from None
    needed = channels.DATAGRAM + _HEADERS
    if mtu < needed:
        udp.close()
        raise PalpateError(f"the network to {at[0]} passes packets of {mtu} bytes",
                           why=f"motion and force need {needed}",
                           mend="raise the MTU of the interface")  # fmt: skip
    udp.setblocking(False)
    return udp
