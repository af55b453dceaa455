"""`palpate bench`."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from palpate.cli.output import console_for, require_writable, say, write_json


def bench(what: Literal["loop", "contact", "sweep", "guidance"], json: Path | None, huge: bool, quick: bool) -> int:
    """Measure, print the table, write the JSON contract."""
    console = console_for(json)
    require_writable(json)
    if what == "loop":
        from palpate.bench import loop

        figures = loop.run(on_progress=lambda text: say(console, text))
        say(console, loop.table(figures))
        write_json(json, figures)
    elif what == "sweep":
        from palpate.bench import sweep

        measured = sweep.run(on_progress=lambda text: say(console, text))
        console.print(sweep.table(measured))
        write_json(json, measured)
    elif what == "guidance":
        from palpate.bench import guidance

        found = guidance.run(on_progress=lambda text: say(console, text))
        console.print(guidance.table(found))
        write_json(json, found)
    else:
        from palpate.bench import contact

        def told(row: contact.Row) -> None:
            case = f"{row['shape']} {row['triangles']:,} {row['path']} {row['method']}"
            say(console, f"{case}: p50 {row['p50_us']:.2f} us")

        sizes = (contact.HUGE,) if huge else contact.SIZES[:1] if quick else contact.SIZES
        rows = contact.run(sizes=sizes, on_row=told)
        if not (huge or quick):
            rows += contact.run(("sphere", "torus", "box"), sizes=(100_000,), paths=("tool",), on_row=told)
        console.print(contact.table(rows))
        write_json(json, rows)
    return 0
