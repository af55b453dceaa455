"""`palpate serve relay`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from tyro.conf import arg

from palpate.cli.terminal import HOST


@dataclass
class Command:
    """Pass the packets of a link on through an emulated network: delay, jitter, loss, outages (docs/network.md).

    examples:
      palpate serve relay --to 127.0.0.1:7410 --network netfi-delay-2
      palpate serve relay --to 192.168.1.7:7410 --network my_link.csv --port 7420
    """

    to: Annotated[str, arg(metavar="HOST:PORT")]
    """Address of the follower's end."""
    network: Annotated[str, arg(metavar="NAME")] = "none"
    """The network, by name, or a measured trace: FILE.csv, FILE.pcap."""
    port: int = 7411
    """Port on which it listens; 0: any free one, which is printed."""
    host: str = HOST
    """Address on which it listens."""
    seed: int = 0
    """Seed of delays and losses."""

    def __call__(self) -> int:
        """Relay until Ctrl-C; returns the exit code."""
        from rich.console import Console

        from palpate.base import stop_signals
        from palpate.cli.terminal.output import say
        from palpate.session.network import network
        from palpate.session.network.channel import address
        from palpate.session.network.relay import Relay

        console = Console()
        relay = Relay(self.port, address(self.to), network(self.network), self.seed, self.host)
        say(console, f"listening on {self.host} port {relay.port}; Ctrl-C ends it")
        with stop_signals.deferred(relay.stopped):
            relay.run()
        say(console, f"{relay.passed} packets passed, {relay.lost} lost")
        return 0
