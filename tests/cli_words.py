"""Parses the words of a printed `palpate` command as the command line does."""

from importlib import import_module

import palpate.cli
from palpate.cli._folder import _with_typing_unions, entries


def parse(words):
    """Parse as `palpate.cli` does; raises SystemExit with its message on the standard error."""
    import tyro
    from tyro.conf import FlagCreatePairsOff

    group, left = palpate.cli, words[1:]
    while left and left[0] not in ("-h", "--help", "--version"):
        members = entries(getattr(group, "MEMBERS", (group.__name__,)), getattr(group, "FIRST", ()))
        if left[0] not in members and hasattr(group, "OTHERWISE"):
            left = [group.OTHERWISE, *left]
        assert left[0] in members, f"no command {left[0]!r}"
        group, left = import_module(members[left[0]].module), left[1:]
        if hasattr(group, "Command"):
            if not {"-h", "--help"} & set(left):
                tyro.cli(_with_typing_unions(group.Command), args=left, config=(FlagCreatePairsOff,))
            return
        if hasattr(group, "prepare"):
            group.prepare()
