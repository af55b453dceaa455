"""`palpate soak`."""

from __future__ import annotations

from pathlib import Path

from palpate.cli.output import console_for, require_writable, say, write_json
from palpate.errors import PalpateError
from palpate.verify.soak import Soak, run, table

LINES = 50  # of progress, over the whole run


def soak(passes: int, method: str, seed: int, json: Path | None) -> int:
    """Poke, print the count, write the JSON contract. Returns 1 when a pass went through."""
    console = console_for(json)
    require_writable(json)
    told = 0

    def progress(so_far: Soak) -> None:
        nonlocal told
        if so_far.passes * LINES >= told * passes:
            told += 1
            say(console, f"{so_far.passes:,} passes, {so_far.popped:,} popped through, {so_far.seconds:.0f} s")

    try:
        done = run(passes, method, seed, progress)
    except ValueError as error:
        raise PalpateError(str(error)) from error
    console.print(table(done))
    write_json(json, done.as_json())
    return 1 if done.popped else 0
