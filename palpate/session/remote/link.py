"""The operator's end: it runs in the loop of a session, and a thread beside it exchanges packets with a follower."""

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
from palpate.base.errors import PalpateError
from palpate.scene import held
from palpate.scene.remote import UNKNOWN
from palpate.session.network import channel as channels
from palpate.session.network.video import Picture, received
from palpate.session.pairs import PairsSession
from palpate.session.remote.pump import Pump
from palpate.session.remote.site import PATIENCE, digest, known, mode, parts, planes
from palpate.session.session import Session

MENDS = {
    "another operator": "end the other session, or wait until it has ended",
    "another scene": "use the same scene file on both machines",
    "Palpate": "install the same version on both machines",
    "packets": "install the same version on both machines",
    "clocks": "set the clocks of both machines, e.g. by NTP",
}
"""What to do about a refusal, by a part of its words."""
_IP_MTU = 14  # of the socket options of IP, on Linux
_HEADERS = 28  # of IPv4 and UDP [bytes]


class _Hand:
    """One pair of a session at the operator's end."""

    def __init__(self, session: Session, mode: str) -> None:
        self.session, options = session, _network.LoopEndOptions()
        options.radius = session.rig.scene.contact.radius
        options.mode, options.planes = _network.Mode[mode], planes(session.scene)
        self.end = _network.LoopEnd(options, known(session.rig))

    def plane(self) -> _network.ModelEstimate | None:
        """The plane that the hand feels where the scene has no object; None before the site has touched one."""
        models = self.end.state().models
        return models[-1] if len(models) and any(models[-1].normal) else None

    def figures(self) -> dict[str, Any]:
        """What the link has measured of this pair; keys as in docs/json/run.md."""
        now, names = self.end.state(), [obj.name for obj in self.session.rig.snapshot.objects]
        names += [UNKNOWN] * (len(now.models) - len(names))
        models = [
            {"object": name, "stiffness_N_per_m": model.K, "shift_m": [float(x) for x in model.shift],
             "margin_N": model.margin, "normal": [float(x) for x in model.normal] if any(model.normal) else None}
            for name, model in zip(names, now.models, strict=True)
        ]  # fmt: skip
        return {
            "received": int(now.received),
            "age_p50_ms": 1e3 * now.p50,
            "age_p99_ms": 1e3 * now.p99,
            "age_p999_ms": 1e3 * now.p999,
            "round_trip_ms": 2e3 * now.bound,
            "play_delay_ms": 1e3 * now.newest.play_delay,
            "clock_offset_s": now.offset,
            "clock_drift_ppm": 1e6 * now.drift,
            "clock_bound_ms": 1e3 * now.bound,
            "outages": now.outages,
            "held_s": now.held,
            "force_site_N": float(np.linalg.norm(now.newest.F)),
            "tank_mJ": 1e3 * now.tank,
            "paid_mJ": 1e3 * now.paid,
            "models": models,
        }


class RemoteLink:
    """The link of a session to a follower's end. All pairs of the session share it: each packet has all their states.

    Args:
        session: the session, of one pair or of several, whose hands feel the remote site; it runs in real time.
        at: address of the follower's end, or of a relay to it.
        key: the shared key.
        rate: packets per second [Hz].

    Raises:
        PalpateError: the scene has bodies, nobody listens there, the other end refuses, or a packet does not fit
        through the network.
    """

    def __init__(self, session: Session | PairsSession, at: tuple[str, int], key: bytes, rate: float = 1000.0) -> None:
        self._session, self._at = session, at
        held.refuse(session.scene, "across a network")
        self.mode = mode(session.scene)  #: what the hands feel
        self._hands = {name: _Hand(one, self.mode) for name, one in _sessions(session).items()}
        self._udp = _packets_to(at, len(self._hands))
        self.port = int(self._udp.getsockname()[1])  #: port to which the packets of the follower come
        self._channel = self._connect(key)
        self._pump = Pump(self._udp, rate, self._receive, self._send)
        self._thread = threading.Thread(target=self._pump.run, name="palpate-remote", daemon=True)
        self.sent = 0  #: packets
        self._picture: Picture | None = None  # the newest one of the remote camera
        self._listener = threading.Thread(target=self._listen, name="palpate-channel", daemon=True)

    def _connect(self, key: bytes) -> channels.Channel:
        host, port = self._at
        try:
            connection = socket.create_connection(self._at, PATIENCE)
        except OSError as error:
            raise PalpateError(f"no follower answers at {host}:{port}", why=str(error),
                               mend="start it there: palpate serve follower SCENE") from None  # fmt: skip
        try:
            channel = channels.shake_hands(connection, key, operator=True)
            channel.send(
                {
                    "version": __version__,
                    "packets": _network.PACKET_VERSION,
                    "scene": digest({name: hand.session.rig.scene for name, hand in self._hands.items()}),
                    "time": time.time(),
                }
            )
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
        """Begin to exchange packets; the loop holds until the link stands."""
        for hand in self._hands.values():
            hand.session.linked = True
            hand.session.attach(hand.end)
            hand.session.video, hand.session.plane = self.video, hand.plane
        self._thread.start()
        self._listener.start()

    def close(self) -> None:
        """Stop, and tell the follower."""
        self._pump.stopped.set()
        if self._thread.is_alive():
            self._thread.join()
        for hand in self._hands.values():
            hand.session.video = hand.session.plane = None
            if not hand.session.running:
                hand.session.attach(None)
        self._channel.close()
        if self._listener.is_alive():
            self._listener.join()
        self._udp.close()

    def _receive(self) -> None:
        for data, _ in channels.arrived(self._udp):
            now = time.monotonic()  # after its reading: no packet arrives before it left
            payload = self._channel.opener.open(data)
            states = None if payload is None else parts(payload, len(self._hands))
            for hand, state in zip(self._hands.values(), states or (), strict=False):
                hand.end.receive(state, now)

    def _listen(self) -> None:
        """Take the pictures of the remote camera until the connection ends."""
        with contextlib.suppress(OSError, ValueError, channels.RefusedError):
            while (message := self._channel.receive()) is not None:
                if "video" not in message:
                    continue
                self._channel.send({"seen": message["video"]})
                self._picture = received(message) or self._picture

    def video(self) -> tuple[bytes, float] | None:
        """The newest JPEG picture of the remote camera, and how long ago it was captured [s]; None before the first.

        The delay is measured by the synchronised clocks, so its error is at most half of the round trip.
        """
        picture, now = self._picture, self.state
        if picture is None or not now.known:
            return None
        return picture.jpeg, time.monotonic() - (picture.t - now.offset)

    def _send(self) -> None:
        with contextlib.suppress(OSError):
            self._udp.send(self._channel.sealer.seal(b"".join(hand.end.packet() for hand in self._hands.values())))
            self.sent += 1

    # -- results ---------------------------------------------------------------------------------------------------

    @property
    def state(self) -> _network.LinkState:
        """State of the link after the newest tick, of the first pair."""
        return next(iter(self._hands.values())).end.state()

    def figures(self, pair: str = "") -> dict[str, Any]:
        """What the link has measured of a pair, or of a session of one; keys as in docs/json/run.md."""
        return {
            "at": f"{self._at[0]}:{self._at[1]}",
            "mode": self.mode,
            "sent": self.sent,
            "refused": self._channel.opener.refused,
            "cpu_s": self._pump.cpu,
            **self._hands[pair].figures(),
        }

    def words(self, pair: str = "") -> str:
        """One line about the link and what a pair has learnt."""
        f = self.figures(pair)
        learnt = "".join(_learnt(m) for m in f["models"] if self.mode == "model")
        ages = f"newest packet {f['age_p50_ms']:.0f} ms old (99 %: {f['age_p99_ms']:.0f})"
        counts = f"{f['received']} packets received, {f['outages']} outages"
        of = f" of {pair}" if pair else ""
        return f"remote {f['at']}{of}: round trip {f['round_trip_ms']:.0f} ms, {ages}, {counts}{learnt}"


def _learnt(model: dict[str, Any]) -> str:
    """What was learnt of an object, or of the plane where the scene has none."""
    name, K = model["object"], model["stiffness_N_per_m"]
    if name != UNKNOWN:
        return f"; {name}: {K:.0f} N/m, moved by {1e3 * math.hypot(*model['shift_m']):.1f} mm"
    return "" if model["normal"] is None else f"; {name}: a plane of {K:.0f} N/m"


def _sessions(session: Session | PairsSession) -> dict[str, Session]:
    """The session of each pair by its name; that of one pair has the name ''."""
    return dict(session.pairs) if isinstance(session, PairsSession) else {"": session}


def _packets_to(at: tuple[str, int], pairs: int) -> socket.socket:
    """A socket for packets of so many pairs to this address.

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
    needed = channels.size(pairs) + _HEADERS
    if mtu < needed:
        udp.close()
        raise PalpateError(f"the network to {at[0]} passes packets of {mtu} bytes",
                           why=f"motion and force need {needed}",
                           mend="raise the MTU of the interface")  # fmt: skip
    udp.setblocking(False)
    return udp
