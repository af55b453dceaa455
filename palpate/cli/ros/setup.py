"""`palpate ros setup`."""

from __future__ import annotations

from dataclasses import dataclass

from palpate.console.output import console_for, say


@dataclass
class Command:
    """Find ROS 2 and compile what runs on it, once; says what is used and where it is kept.

    examples:
      palpate ros setup
      source /opt/ros/jazzy/setup.bash && palpate ros setup

    A sourced ROS 2 wins over the wheels of palpate[ros]. The other commands do the same on their first use.
    """

    def __call__(self) -> int:
        """Do it."""
        from palpate.ros import build, where

        console = console_for(None)
        say(console, where.find().words)
        built = build.build(lambda text: say(console, text))
        for name, prefix in built.messages.items():
            say(console, f"{name}: {'our definitions' if built.ours(name) else 'of ROS 2'}, {prefix}")
        say(console, f"nodes: {built.extension}")
        say(console, f"compiled in {built.seconds:.0f} s" if built.seconds else "all of it was there")
        return 0
