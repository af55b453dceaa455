"""`palpate ros graph`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import arg

from palpate.base.errors import PalpateError
from palpate.cli.terminal.output import console_for, require_writable, say, write_json


@dataclass
class Command:
    """Show the nodes and topics of the ROS 2 network, with the measured rate and age of every topic.

    examples:
      palpate ros graph
      palpate ros graph --json graph.json --figure graph.png
    """

    seconds: float = 3.0
    """Time during which each topic is listened to [s]."""
    network: bool = False
    """Look at other machines too; otherwise only at this one."""
    figure: Annotated[Path | None, arg(metavar="FILE.png")] = None
    """Draw the graph: publishers, topics with rates and ages, subscribers."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the graph as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Measure and print the graph; the exit code is 1 if two nodes share a name or a topic."""
        from palpate.ros import graph

        if not 0.1 <= self.seconds <= 60.0:
            raise PalpateError(f"--seconds {self.seconds:g}: must be 0.1 to 60 s", mend="e.g. --seconds 3")
        console = console_for(self.json)
        for file in (self.json, self.figure):
            require_writable(file)

        def progress(n: int) -> None:
            most = min(n, graph.AT_ONCE)
            wall = self.seconds * -(-n // graph.AT_ONCE)
            say(console, f"listening to {n} topics, {most} at a time, {self.seconds:g} s each: {wall:.0f} s")

        found = graph.measure(self.seconds, self.network, progress)
        for one in found.topics:
            ends = f"{', '.join(one.publishers) or 'nobody'} > {', '.join(one.subscribers) or 'nobody'}"
            say(console, f"{one.name}  {one.measured}  {ends}")
        say(console, f"{len(found.nodes)} nodes, {len(found.topics)} topics, {self.seconds:g} s")
        for name in found.duplicate_nodes:
            say(console, f"several nodes are named {name}", "fault:", "red")
        for name in found.shared_topics:
            say(console, f"several nodes publish {name}", "fault:", "red")
        if self.figure is not None:
            drawn = graph.draw(found, self.figure)
            say(console, f"{self.figure}, {drawn} topics", "figure:")
        write_json(self.json, found)
        return 1 if found.duplicate_nodes or found.shared_topics else 0
