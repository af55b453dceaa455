"""The follower's end as a process: ``palpate serve follower SCENE``."""

from __future__ import annotations

import contextlib
import json
import socket
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256
from typing import Any, Literal, Protocol

import numpy as np

from palpate import __version__, _core, _network
from palpate.base.errors import SceneError
from palpate.scene import held
from palpate.scene.rig import Rig
from palpate.scene.scene import Scene
from palpate.session.network import channel as channels
from palpate.session.network.relay import close, listen
from palpate.session.network.video import Sender, VideoSource
from palpate.session.remote.pump import Pump

PATIENCE = 5.0  # for the first messages of a connection [s]
HOURS = 3600.0  # by which the clocks of both machines may differ [s]


def mode(scene: Scene) -> Literal["model", "passivity", "direct"]:
    """What crosses the network between hand and remote tool."""
    return "model" if scene.remote is None else scene.remote.mode


def digest(scenes: Mapping[str, Scene]) -> str:
    """What both ends must have in common, as 16 hexadecimal digits: of each pair objects, frames, tool and mode."""
    each = {}
    for name, scene in scenes.items():
        each[name] = scene.model_dump(mode="json", include={"objects", "frames", "contact", "arms"})
        each[name]["arms"].pop("leader", None)
        each[name]["mode"] = mode(scene)
        if scene.remote is not None:
            each[name] |= scene.remote.model_dump(mode="json", include={"planes", "hidden"})
    return sha256(json.dumps(each, sort_keys=True).encode()).hexdigest()[:16]


def parts(payload: bytes, pairs: int) -> list[bytes] | None:
    """The bytes of each pair's datagram in a packet; None if they are not those of so many pairs."""
    n = _network.PACKET_SIZE
    return [payload[i * n : (i + 1) * n] for i in range(pairs)] if len(payload) == pairs * n else None


def known(rig: Rig) -> _core.Snapshot:
    """The objects as both ends know them: of the scene, without those that only the simulated site has.

    Raises:
        SceneError: an object to hide does not exist, or the mode has no planes.
    """
    section, scene = rig.scene.remote, rig.scene
    if section is None:
        return rig.snapshot
    names = [obj.name for obj in scene.objects]
    for name in section.hidden:
        if name not in names:
            raise SceneError(f"remote.hidden: no object is named {name!r}", where=scene.where("remote", "hidden"),
                             mend=f"choose from: {', '.join(names)}")  # fmt: skip
    if section.planes and section.mode != "model":
        raise SceneError(f"remote.planes: the mode {section.mode} has no model", where=scene.where("remote", "planes"),
                         mend="choose mode: model, or leave planes out")  # fmt: skip
    return _network.concealed(rig.snapshot, list(section.hidden)) if section.hidden else rig.snapshot


def planes(scene: Scene) -> bool:
    """True if surfaces that the scene does not have are felt as planes."""
    return scene.remote is not None and scene.remote.planes


def world(rig: Rig) -> _core.Snapshot:
    """The objects as the simulated site has them: as the scene, with the errors of its section ``remote``."""
    section = rig.scene.remote
    if section is None:
        return rig.snapshot
    return _network.displaced(rig.snapshot, np.asarray(section.site_shift), section.site_stiffness or 0.0)


class Patient(Protocol):
    """The patient's side: a site and the instrument that follows its goals, in a thread of their own."""

    def start(self) -> None:
        """Begin to follow."""

    def stop(self) -> None:
        """End following."""

    def receive(self, bytes: bytes, at: float, /) -> bool:
        """The bytes of a datagram that arrived at the own time ``at`` [s]; False unless they are valid."""

    def packet(self) -> bytes:
        """The bytes of the datagram that leaves next."""

    def forget_operator(self) -> None:
        """The operator has left, or a new one comes."""

    def state(self) -> Any:
        """The state after the newest tick, with ``largest``: largest force so far [N]."""

    def timing(self) -> dict[str, Any]:
        """Punctuality so far, with ``ticks`` and ``missed_ticks``."""


def simulated(rig: Rig, rate: float) -> _network.Follower:
    """A simulated instrument at the start of the scene's follower; rate: of its loop [Hz]."""
    options = _network.FollowerOptions()
    options.site, options.rate = site_options(rig), rate
    X_WT = rig.arms.X_WB @ rig.arms.follower.fk(rig.arms.q_follower0)
    return _network.Follower(options, known(rig), world(rig), X_WT)


def site_options(rig: Rig) -> _network.SiteOptions:
    """Options of the follower's end for a scene."""
    options = _network.SiteOptions()
    options.radius = rig.scene.contact.radius
    options.mode, options.planes = _network.Mode[mode(rig.scene)], planes(rig.scene)
    return options


@dataclass
class _Master:
    """The connected operator's end."""

    channel: channels.Channel
    name: str
    at: tuple[str, int] | None = None  #: where its packets come from
    heard: float = 0.0  #: when its last packet came [s]


class FollowerServer:
    """Listens for one operator's end, and lets an instrument follow each of its hands.

    Sites and instruments run in threads of their own; the thread of `run` exchanges packets with the network.

    Args:
        rigs: the rig of a scene of one pair, or those of all pairs by name.
        key: the shared key.
        rate: packets per second [Hz].
        say: takes lines for the user.
        patients: what follows each pair; simulated instruments when left out.
        video: the camera whose pictures the operator sees.

    Raises:
        PalpateError: the port is taken, or the scene has bodies.
    """

    def __init__(
        self, rigs: Rig | Mapping[str, Rig], key: bytes, host: str, port: int, rate: float, say: Callable[[str], None],
        patients: Sequence[Patient] = (), video: VideoSource | None = None,
    ) -> None:  # fmt: skip
        self.rigs = {"": rigs} if isinstance(rigs, Rig) else dict(rigs)  #: of all pairs, by name
        for rig in self.rigs.values():
            held.refuse(rig.scene, "across a network")
        self._key, self._say = key, say
        self._tcp, self._udp = listen(host, port)
        self.port = int(self._tcp.getsockname()[1])  #: the port on which it listens
        made = patients or [simulated(rig, rate) for rig in self.rigs.values()]
        self.followers: tuple[Patient, ...] = tuple(made)  #: site and instrument of each pair
        self._pump = Pump(self._udp, rate, self._receive, self._send)
        self.stopped, self._changing = self._pump.stopped, threading.Lock()  #: the event ends `run`
        self._master: _Master | None = None
        self.video = None if video is None else Sender(video, self._show, tell=say)  #: sends the pictures
        self.strangers = 0  #: packets that were refused
        self.sent = 0  #: packets
        self.cpu = 0.0  #: processor time of the process while it ran [s]

    @property
    def attended(self) -> bool:
        """True while an operator's end is connected."""
        return self._master is not None

    @property
    def largest(self) -> float:
        """Largest force on the tissue so far [N]."""
        return max(float(one.state().largest) for one in self.followers)

    @property
    def ticks(self) -> int:
        """Ticks of all loops so far."""
        return sum(int(one.timing()["ticks"]) for one in self.followers)

    @property
    def missed(self) -> int:
        """Ticks that the loops have missed so far."""
        return sum(int(one.timing()["missed_ticks"]) for one in self.followers)

    def stop(self) -> None:
        """End `run`."""
        self.stopped.set()

    def run(self) -> None:
        """Follow until `stop`."""
        threading.Thread(target=self._accept, name="palpate-accept", daemon=True).start()
        if self.video is not None:
            threading.Thread(target=self.video.run, name="palpate-video", daemon=True).start()
        begin = time.process_time()
        for one in self.followers:
            one.start()
        try:
            self._pump.run()
        finally:
            if self.video is not None:
                self.video.stop()
            for one in self.followers:
                one.stop()
            self.cpu = time.process_time() - begin
            close(self._tcp, self._udp)

    # -- packets ---------------------------------------------------------------------------------------------------

    def _receive(self) -> None:
        master = self._master
        for data, sender in channels.arrived(self._udp):
            now = time.monotonic()  # after its reading: no packet arrives before it left
            payload = None if master is None else master.channel.opener.open(data)
            if master is None or payload is None or not self._taken(payload, now):
                self.strangers += 1
                continue
            master.heard = now
            master.at = sender  # the newest authentic packet tells where the operator's end is

    def _taken(self, payload: bytes, now: float) -> bool:
        """Give each follower its part of a packet; False unless all are valid."""
        states = parts(payload, len(self.followers))
        return states is not None and all(
            one.receive(state, now) for one, state in zip(self.followers, states, strict=True)
        )

    def _send(self) -> None:
        master = self._master
        if master is None or master.at is None:
            return
        with contextlib.suppress(OSError):
            self._udp.sendto(master.channel.sealer.seal(b"".join(one.packet() for one in self.followers)), master.at)
            self.sent += 1

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
                    channel.send({"ok": True})  # before any picture
                    if self.video is not None:
                        self.video.forget()
                    master = self._master = _Master(channel, f"{peer[0]}:{peer[1]}", heard=time.monotonic())
                    for one in self.followers:
                        one.forget_operator()
            if fault is not None:
                channel.send({"error": fault})
                return
            self._say(f"operator at {peer[0]}:{peer[1]}")
            connection.settimeout(None)
            while (message := channel.receive()) is not None:
                if self.video is not None and master is not None and self._master is master:
                    self.video.seen(message.get("seen"))
        except (OSError, ValueError, channels.RefusedError) as error:
            if not isinstance(error, OSError):
                self._say(f"refused {peer[0]}:{peer[1]}: {str(error).splitlines()[0]}")
        finally:
            with self._changing:
                if master is not None and self._master is master:
                    self._master = None
                    for one in self.followers:
                        one.forget_operator()
                    self._say("the operator has left; the tool holds")
            connection.close()

    def _show(self, message: dict[str, Any]) -> bool:
        """Send a picture to the operator's end, if there is one."""
        master = self._master
        if master is not None:
            master.channel.send(message)
        return master is not None

    def _fault(self, hello: dict[str, Any]) -> str | None:
        """Why an operator's end may not connect, in words for that end; None if it may."""
        if (theirs := hello.get("packets", 1)) != _network.PACKET_VERSION:
            return f"the follower has packets of version {_network.PACKET_VERSION}, this end of version {theirs}"
        if hello.get("version") != __version__:
            return f"the follower has Palpate {__version__}, this end {hello.get('version')}"
        mine = digest({name: rig.scene for name, rig in self.rigs.items()})
        if hello.get("scene") != mine:
            both = f"{mine}, this end {hello.get('scene')}"
            return f"the follower has another scene ({both}): objects, contact, follower or mode differ"
        try:
            apart = time.time() - float(hello.get("time", 0.0))
        except (TypeError, ValueError, OverflowError):
            return f"the other end states its time as {str(hello['time'])[:40]!r}, which is no number of seconds"
        if not abs(apart) <= HOURS:
            return f"the clocks of both machines differ by {apart / 3600.0:.1f} h"
        return None
