"""`palpate certify`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from rich.markup import escape
from rich.table import Table

from palpate.certificate.scene import Touched, touched, worst_of
from palpate.certificate.words import number
from palpate.cli.output import console_for, require_writable, say, write_json
from palpate.scene import Scene

if TYPE_CHECKING:
    from palpate.certificate import Certificate
    from palpate.cli.commands import Certify

_COLOURS = {"stable": "green", "marginal": "yellow", "unstable": "red"}


def certify(o: Certify) -> int:
    """Tell which of a scene's objects are stable, and by how much; returns the exit code."""
    from palpate.certificate import certify_all

    console = console_for(o.json)
    for file in (o.json, o.figure):
        require_writable(file)
    scene = Scene.load(o.scene)
    things = touched(scene)
    found = certify_all(scene)
    console.print(_table(things, found))
    worst = worst_of(found)
    hands = ", ".join(f"{name} {number(k)}" for name, k in worst.hands.items())
    say(console, worst.reason, f"{worst.name}:", f"bold {_COLOURS[worst.verdict or 'stable']}")
    say(console, f"stable below {hands} N/m", "with other hands:", "bold")
    if o.figure is not None:
        _draw(scene, things, found, o.figure)
        say(console, str(o.figure), "picture")
    write_json(o.json, {**worst.to_json(), "objects": [{"name": one.name, **one.to_json()} for one in found]})
    return 0


def _table(things: list[Touched], found: list[Certificate]) -> Table:
    out = Table(box=None, pad_edge=False, title="stiffness on the tool's side", title_justify="left")
    for column in (
        "object",
        "K [N/m]",
        "B [N s/m]",
        "stable below [N/m]",
        "passive below [N/m]",
        "swings at [Hz]",
        "verdict",
    ):
        out.add_column(escape(column), justify="left" if column in ("object", "verdict") else "right")
    for thing, one in zip(things, found, strict=True):
        passive = one.bounds["colgate_brown_with_hand"]
        out.add_row(thing.name, f"{thing.K:g}", f"{one.B:g}", number(one.k_max), number(passive),
                    f"{one.frequency:.3g}", one.verdict, style=_COLOURS[one.verdict or "stable"])  # fmt: skip
    return out


def _draw(scene: Scene, things: list[Touched], found: list[Certificate], path: Path) -> None:
    from palpate.certificate.figure import Point, draw

    points = [
        Point(thing.name, one.B, thing.K, one.verdict or "stable") for thing, one in zip(things, found, strict=True)
    ]
    draw(worst_of(found), points, f"{scene.title}: stable below the line", path)
