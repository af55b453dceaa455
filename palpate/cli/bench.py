"""`palpate bench`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from palpate.cli.output import console_for, require_writable, say, write_json
from palpate.errors import PalpateError

if TYPE_CHECKING:
    from palpate.cli.commands import Bench


def bench(o: Bench) -> int:
    """Measure, print the table, write the JSON contract."""
    what, json, huge, quick = o.what, o.json, o.huge, o.quick
    console = console_for(json)
    require_writable(json)
    if what == "loop":
        from palpate.verify.bench import loop

        figures = loop.run(on_progress=lambda text: say(console, text))
        say(console, loop.table(figures))
        write_json(json, figures)
    elif what == "sweep":
        from palpate.verify.bench import sweep

        measured = sweep.run(on_progress=lambda text: say(console, text))
        console.print(sweep.table(measured))
        write_json(json, measured)
    elif what == "guidance":
        from palpate.verify.bench import guidance

        found = guidance.run(on_progress=lambda text: say(console, text))
        console.print(guidance.table(found))
        write_json(json, found)
    elif what == "ros":
        from palpate.verify.bench import ros

        if not 1.0 <= o.duration <= 86400.0 or not 50.0 <= o.rate <= 5000.0:
            raise PalpateError(
                "--duration: 1 to 86400 s; --rate: 50 to 5000 Hz", mend="e.g. --duration 600 --rate 1000"
            )
        answered = ros.run(o.duration, o.rate, on_progress=lambda text: say(console, text))
        if o.sim:
            answered |= ros.of_sim()
            words = f"{answered['sim_rate_hz']:.0f} Hz reached, {answered['sim_cores']:.2f} cores"
            say(console, f"palpate ros sim with four arms: {words}")
        console.print(ros.table(answered))
        write_json(json, answered)
    else:
        from palpate.verify.bench import contact

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
