"""`palpate ros setup`."""

from __future__ import annotations

from dataclasses import dataclass

from palpate.cli.terminal.output import console_for, say


@dataclass
class Command:
    """Find ROS 2 and PyKDL, compile Palpate's nodes and messages once, and print where they are kept.

    examples:
      palpate ros setup
      source /opt/ros/jazzy/setup.bash && palpate ros setup

    A sourced ROS 2 takes precedence over the wheels of palpate[ros]. The other commands compile on their first use.
    """

    def __call__(self) -> int:
        """Find, compile, print."""
        from palpate.ros import build, pykdl, where

        console = console_for(None)
        say(console, where.find().words)
        built = build.build(lambda text: say(console, text))
        for name, prefix in built.messages.items():
            say(console, f"{name}: {'compiled by Palpate' if built.ours(name) else 'part of ROS 2'}, {prefix}")
        say(console, f"nodes: {built.extension}")
        say(console, pykdl.link())
        say(console, f"compiled in {built.seconds:.0f} s" if built.seconds else "everything was compiled already")
        return 0
