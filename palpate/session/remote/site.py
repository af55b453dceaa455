"""The follower's end as a process: ``palpate serve follower SCENE``."""

from __future__ import annotations

import contextlib
import json
import socket
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from hashlib import sha256
from typing import Any

import numpy as np

from palpate import __version__, _core, _network
from palpate.network import channel as channels
from palpate.network.relay import listen
from palpate.scene.rig import Rig
from palpate.scene.scene import Scene

PATIENCE = 5.0  # for the first messages of a connection [s]
HOURS = 3600.0  # by which the clocks of both machines may differ [s]
_CATCH_UP = 0.02  # ticks older than this are missed, not made up for [s]


def digest(scene: Scene) -> str:
    """What both ends must have in common: objects, frames and the tool, as 16 hexadecimal digits."""
    parts = scene.model_dump(mode="json", include={"objects", "frames", "contact", "arms"})
    parts["arms"].pop("leader", None)
    return sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:16]


def world(rig: Rig) -> _core.Snapshot:
    """The objects as the simulated site has them: as the scene, with the errors of its section ``remote``."""
    section = rig.scene.remote
    if section is None:
        return rig.snapshot
    return _network.displaced(rig.snapshot, np.asarray(section.site_shift), section.site_stiffness or 0.0)


@dataclass
class _Master:
    """The connected operator's end."""

    channel: channels.Channel
    name: str
    at: tuple[str, int] | None = None  #: where its packets come from
    heard: float = 0.0  #: when its last packet came [s]


class FollowerServer:
    """Listens for one operator's end, and lets a simulated instrument follow it.

    Args:
        rig: the rig of the scene.
        key: the shared key.
        say: takes lines for the user.

    Raises:
        PalpateError: the port is taken.
    """

    def __init__(self, rig: Rig, key: bytes, host: str, port: int, rate: float, say: Callable[[str], None]) -> None:
        self.rig, self._key, self._say, self._dt = rig, key, say, 1.0 / rate
        self._tcp, self._udp = listen(host, port)
        self.port = int(self._tcp.getsockname()[1])  #: the port on which it listens
        options = _network.SiteOptions()
        options.radius = rig.scene.contact.radius
        self._site = _network.Site(options, rig.snapshot)
        self._instrument = _network.Instrument(_network.InstrumentOptions(), options.radius, world(rig), 1)
        self._instrument.place((rig.arms.X_WB @ rig.arms.follower.fk(rig.arms.q_follower0))[:3, 3])
        self.stopped, self._changing = threading.Event(), threading.Lock()  #: the event ends `run`
        self._master: _Master | None = None
        self.ticks = self.missed = self.strangers = 0  #: ticks, ticks that came too late, packets that were refused
        self.cpu = 0.0  #: processor time of the loop [s]

    @property
    def largest(self) -> float:
        """Largest force on the tissue so far [N]."""
        return self._instrument.largest

    def stop(self) -> None:
        """End `run`."""
        self.stopped.set()

    def run(self) -> None:
        """Follow until `stop`."""
        threading.Thread(target=self._accept, name="palpate-accept", daemon=True).start()
        begin, cpu = time.monotonic(), time.thread_time()
        due = begin
        while not self.stopped.is_set():
            now = time.monotonic()
            if now < due:
                time.sleep(due - now)
                now = time.monotonic()
            if now - due > _CATCH_UP:
                self.missed += int((now - due) / self._dt)
                due = now
            self._tick(now)
            self.ticks += 1
            due += self._dt
        self.cpu = time.thread_time() - cpu
        self._tcp.close()
        self._udp.close()

    # -- the loop --------------------------------------------------------------------------------------------------

    def _tick(self, now: float) -> None:
        master = self._master
        self._receive(master)
        goal = self._site.step(self._instrument.measure(now), self._dt)
        self._instrument.step(goal, now, self._dt)
        if master is not None and master.at is not None:
            with contextlib.suppress(OSError):
                self._udp.sendto(master.channel.sealer.seal(_network.encode(self._site.send())), master.at)

    def _receive(self, master: _Master | None) -> None:
        for data, sender in channels.arrived(self._udp):
            payload = None if master is None else master.channel.opener.open(data)
            datagram = None if payload is None else _network.decode(payload)
            if master is None or datagram is None:
                self.strangers += 1
                continue
            master.heard = time.monotonic()
            master.at = sender  # the newest authentic packet tells where the operator's end is
            self._site.receive(datagram, time.monotonic())

    # -- the reliable channel --------------------------------------------------------------------------------------

    def _accept(self) -> None:
        while not self.stopped.is_set():
            try:
                connection, peer = self._tcp.accept()
            except OSError:
                return
            threading.Thread(target=self._attend, args=(connection, peer), daemon=True).start()

    def _attend(self, connection: socket.socket, peer: tuple[str, int]) -> None:
        """Serve one connection until it ends."""
        master = None
        try:
            connection.settimeout(PATIENCE)
            channel = channels.shake_hands(connection, self._key, operator=False)
            hello = channel.receive()
            if hello is None:
                return
            fault = self._fault(hello)
            with self._changing:
                before = self._master
                if fault is None and before is not None and time.monotonic() - before.heard < PATIENCE:
                    fault = f"another operator drives this follower: {before.name}"
                if fault is None:
                    master = self._master = _Master(channel, f"{peer[0]}:{peer[1]}", heard=time.monotonic())
                    self._site.forget_operator()
            if fault is not None:
                channel.send({"error": fault})
                return
            channel.send({"ok": True})
            self._say(f"operator at {peer[0]}:{peer[1]}")
            connection.settimeout(None)
            while channel.receive() is not None:
                pass
        except (OSError, ValueError, channels.RefusedError) as error:
            if not isinstance(error, OSError):
                self._say(f"refused {peer[0]}:{peer[1]}: {str(error).splitlines()[0]}")
        finally:
            with self._changing:
                if master is not None and self._master is master:
                    self._master = None
                    self._say("the operator has left; the tool holds")
            connection.close()

    def _fault(self, hello: dict[str, Any]) -> str | None:
        """Why an operator's end may not connect; None if it may."""
        if hello.get("version") != __version__:
            return f"this end has Palpate {__version__}, the other one {hello.get('version')}"
        mine = digest(self.rig.scene)
        if hello.get("scene") != mine:
            both = f"{mine}, the other one {hello.get('scene')}"
            return f"this end has another scene ({both}): objects, contact or follower differ"
        apart = time.time() - float(hello.get("time", 0.0))
        if not abs(apart) <= HOURS:
            return f"the clocks of both machines differ by {apart / 3600.0:.1f} h"
        return None
