"""Progress of a soak: lines at equal shares of its actions."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from rich.console import Console

from palpate.cli.terminal.output import say

Counts = TypeVar("Counts")


def lines(
    console: Console, most: int, whole: int, done: Callable[[Counts], int], words: Callable[[Counts], str]
) -> Callable[[Counts], None]:
    """A function that prints about `most` lines over `whole` actions.

    Args:
        console: where the lines are printed.
        most: number of lines [-].
        whole: number of actions of the whole soak [-].
        done: number of actions in the counts so far [-].
        words: the line for the counts so far.
    """
    printed = 0

    def progress(so_far: Counts) -> None:
        nonlocal printed
        if done(so_far) * most >= printed * whole:
            printed += 1
            say(console, words(so_far))

    return progress
