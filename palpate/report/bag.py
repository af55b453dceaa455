"""The report of a bag: one HTML page on a CRTK session."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

from palpate.base.errors import MissingExtraError
from palpate.record.bags.bag import Bag
from palpate.record.bags.summary import summary_of
from palpate.record.bags.tracks import ArmTracks, Track
from palpate.report.page import write

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from palpate.base.plotting.style import Canvas

_MOST_EVENTS = 300


def write_page(bag: Bag, out: Path | None = None) -> Path:
    """Write the report: ``report.html`` in the bag's folder when `out` is left out.

    Raises:
        MissingExtraError: matplotlib is not installed. OutputError: the page cannot be written.
    """
    folder = bag.path if bag.path.is_dir() else bag.path.parent
    return write(out if out is not None else folder / "report.html", report(bag))


def report(bag: Bag) -> str:
    """The page as text; the same bag gives the same page.

    Raises:
        MissingExtraError: matplotlib is not installed.
    """
    try:
        from palpate.base.plotting.style import picture
    except ImportError as error:
        raise MissingExtraError("the report's figures", "report") from error

    def figure(title: str, text: str, draw: Callable[[Canvas], Figure]) -> str:
        return f"<section><h2>{title}</h2><p>{text}</p>{picture(draw, alt=title)}</section>"

    parts = [
        f"<header><h1>{escape(bag.path.name)}</h1><p>A ROS 2 bag of {bag.duration:.2f} s: "
        f"{', '.join(map(escape, bag.arms))}. Forces are commanded forces, not measured ones.</p></header>",
        *(f'<div class="note"><p>{escape(note)}</p></div>' for note in bag.notes),
        _numbers(bag),
    ]
    for arm in bag.arms.values():
        if len(arm.pose.t) or len(arm.wrench.t):
            words = "Position in the arm's base frame, and the commanded wrench (in the frame named below the plot)."
            parts.append(figure(escape(arm.name), words, partial(_draw, arm)))
    parts += [_events(bag), _topics(bag)]
    css = files("palpate.report").joinpath("page.css").read_text(encoding="utf-8")
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1"><link rel="icon" href="data:,">'
        f"<title>{escape(bag.path.name)}: CRTK session</title><style>{css}</style></head>"
        f"<body><main>{''.join(parts)}</main></body></html>\n"
    )


def _draw(arm: ArmTracks, canvas: Canvas) -> Figure:
    from matplotlib.figure import Figure as Drawn

    from palpate.base.plotting.style import JOINTS, curve

    figure = Drawn(figsize=(canvas.width, 4.4), layout="constrained")
    rows = figure.subplots(2, 1, sharex=True)
    for axes, track, unit, scale in (
        (rows[0], arm.pose, "position [mm]", 1e3),
        (rows[1], arm.wrench, "force [N]", 1.0),
    ):
        for k, axis in enumerate("xyz"):
            if len(track.t):
                curve(axes, track.t, scale * track.values[:, k], canvas.points(), color=JOINTS[k], label=axis)
        axes.set_ylabel(unit)
    if len(arm.pose.t):
        rows[0].legend(ncols=3)
    rows[1].set_xlabel("time [s]; force in the axes of the " + _frame(arm.absolute))
    return figure


def _frame(absolute: Track) -> str:
    found = {bool(x) for x in absolute.values[:, 0]} if len(absolute.t) else {False}
    return "base or of the tip (changed during the session)" if len(found) > 1 else "base" if found == {True} else "tip"


def _numbers(bag: Bag) -> str:
    lines: list[tuple[str, str, str]] = []
    for name, s in summary_of(bag).arms.items():
        if s.wrenches:
            lines.append((f"{name} peak force", f"{s.peak_force_N:.2f} N", "largest commanded force"))
            lines.append((f"{name} held force", f"{s.peak_50ms_N:.2f} N", "largest mean of that force over 50 ms"))
            lines.append((f"{name} steepest force", f"{s.steepest_N_per_s:.0f} N/s", "fastest change of that force"))
            lines.append((f"{name} force left on", f"{s.held_s:.2f} s", _HELD))
        if s.poses:
            lines.append((f"{name} top speed", f"{s.peak_speed_m_s:.3f} m/s", "peak speed of the tip"))
    return _table("Numbers", lines)


_HELD = "time with a force above zero that was not renewed for more than 30 ms: an arm without a timeout keeps pushing"


def _events(bag: Bag) -> str:
    lines = [(f"{e.t:.3f} s", escape(e.topic), escape(e.text)) for e in bag.events[:_MOST_EVENTS]]
    if len(bag.events) > _MOST_EVENTS:
        lines.append(("", "", f"and {len(bag.events) - _MOST_EVENTS} more"))
    return _table("What happened", lines)


def _topics(bag: Bag) -> str:
    lines = []
    for t in bag.topics:
        odd = ", ".join(f"{n} {w}" for n, w in ((t.silent, "with stamp zero"), (t.bad, "not finite")) if n)
        rate = f"{t.count} at {t.rate:.0f} Hz" if t.rate else str(t.count)
        lines.append((escape(t.name), rate, f"{t.type}; longest gap {1e3 * t.gap:.0f} ms{'; ' + odd if odd else ''}"))
    return _table("Topics", lines)


def _table(title: str, lines: list[Any]) -> str:
    body = "".join(f'<tr><td>{a}</td><td class="value">{b}</td><td>{c}</td></tr>' for a, b, c in lines)
    return f'<section><h2>{title}</h2><table class="facts-table">{body}</table></section>'
