"""Prints the list of commands without the option parser, whose import alone takes longer than the whole list."""

from __future__ import annotations

import os
import textwrap
from collections.abc import Mapping

_WIDEST = 120  # columns


def overview(prog: str, description: str, members: Mapping[str, str]) -> str:
    """The help text of a group of commands.

    Args:
        prog: text that the user types before the name of a command.
        description: purpose of the group.
        members: first line of each command's help text, by name.
    """
    column = max(map(len, members), default=0) + 4
    width = min(_columns(), _WIDEST)
    lines = [f"usage: {prog} [-h] COMMAND ...", "", description.strip(), "", "commands:"]
    for name, summary in members.items():
        lead = f"  {name}".ljust(column)
        lines += textwrap.wrap(summary, width, initial_indent=lead, subsequent_indent=" " * column) or [lead.rstrip()]
    return "\n".join([*lines, "", f"Options of a command: {prog} COMMAND --help"])


def _columns() -> int:
    try:
        return os.get_terminal_size().columns
    except OSError:  # the standard output is not a terminal
        return _WIDEST
