"""`palpate serve follower`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, arg

from palpate.console import HOST


@dataclass
class Command:
    """Let a simulated instrument follow an operator across the network (docs/network.md).

    examples:
      palpate serve follower remote
      palpate serve follower my.yaml --host 192.168.1.7 --port 7410 --key link.key

    The operator's end is `palpate run SCENE --remote HOST:PORT` with the same scene and the same key. Ctrl-C ends it.
    """

    scene: Positional[Path]
    """Scene file (YAML), or the name of a shipped scene."""
    port: int = 7410
    """Port of UDP and TCP; 0: any free one, which is printed."""
    host: str = HOST
    """Address on which it listens: 127.0.0.1 for this machine only."""
    key: Annotated[Path | None, arg(metavar="FILE")] = None
    """The shared key; default: that of `palpate keys`."""

    def __call__(self) -> int:
        """Serve until Ctrl-C; returns the exit code."""
        from rich.console import Console

        from palpate import stop_signals
        from palpate.console.output import say
        from palpate.network.keys import default_path, read_key, require_cryptography
        from palpate.scene import Scene
        from palpate.scene.rig import build
        from palpate.session.remote.site import FollowerServer

        require_cryptography()
        key, console = read_key(self.key or default_path()), Console()
        rig = build(Scene.load(self.scene))
        rate = rig.scene.remote.rate if rig.scene.remote is not None else 1000.0
        server = FollowerServer(rig, key, self.host, self.port, rate, lambda line: say(console, line))
        say(console, f"listening on {self.host} port {server.port}; Ctrl-C ends it")
        with stop_signals.deferred(server.stopped):
            server.run()
        counts = f"{server.ticks} ticks, {server.missed} missed, {server.sent} packets sent, {server.strangers} refused"
        say(console, f"{counts}, largest force {server.largest:.2f} N, {server.cpu:.2f} s of processor time")
        return 0
