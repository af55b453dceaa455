"""The report of a run of several pairs: one page with all hands, and a link to the report of each pair."""

from __future__ import annotations

from functools import partial
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from palpate.base.errors import MissingExtraError, RecordError, SceneError
from palpate.record.reader import Record
from palpate.report.html import fault_notes, page_of, section, write_report
from palpate.report.page import write
from palpate.report.rates import WORDS, rates_of, table
from palpate.report.run import Run
from palpate.report.summary import rows, summary_of
from palpate.scene import text
from palpate.session.run_folder import SCENE

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from palpate.base.plotting.style import Canvas

_STORY = "Force on each hand over time; below, the force with which the instruments push each other."
_MEETING = "How close the instruments and the handles came. The forces of two instruments on each other are opposite."


def pair_records(folder: Path) -> dict[str, Path]:
    """The records of a run of several pairs by the name of the pair, in the order of the scene; empty for other paths.

    The order decides the colours of the pairs, which are those of the running session.

    Raises:
        RecordError: the folder holds several runs: only the scene beside its records makes them one run.
    """
    if not folder.is_dir() or (folder / "record.mcap").exists():
        return {}
    found = {path.parent.name: path for path in sorted(folder.glob("*/record.mcap"))}
    named = _names_in_scene(folder / SCENE)
    if not set(found) <= set(named):
        what = f"the folder holds records ({', '.join(found)}), and no {SCENE} with pairs of these names"
        mend = f"give each run of its own, such as {folder / next(iter(found))}"
        raise RecordError(what, where=str(folder), why="it is not the folder of one run", mend=mend)
    return {name: found[name] for name in dict.fromkeys(named) if name in found}


def _names_in_scene(file: Path) -> list[str]:
    """Names of the pairs in a scene file, in its order; empty if it cannot be read."""
    try:
        pairs = text.parse(text.read(file), str(file))[0].get("pairs")
    except SceneError:
        return []
    return [str(name) for name in pairs] if isinstance(pairs, dict) else []


def write_pairs_report(folder: Path, out: Path | None = None, each: bool = True) -> Path:
    """Write the report of a run of several pairs.

    Args:
        folder: folder of the run.
        out: the HTML file; ``report.html`` in the folder when left out.
        each: True also writes the report of each pair, next to its record.

    Raises:
        RecordError: a record cannot be read. MissingExtraError: matplotlib is not installed.
        OutputError: a page cannot be written.
    """
    paths = pair_records(folder)
    for path in paths.values() if each else ():
        write_report(path)
    runs = {name: Run(Record.open(path)) for name, path in paths.items()}
    return write(folder / "report.html" if out is None else out, _text(folder, runs))


def _text(folder: Path, runs: dict[str, Run]) -> str:
    try:
        from palpate.base.plotting.style import picture
    except ImportError as error:
        raise MissingExtraError("the report's figures", "report") from error
    links = ", ".join(
        f'<a href="{escape(name)}/report.html">{escape(name)}</a>' for name in runs if (folder / name).is_dir()
    )
    title = next(iter(runs.values())).title if len(runs) == 1 else folder.name
    rates = [row for name, run in runs.items() for row in rates_of(run, name)]
    image = picture(partial(_story, runs), alt=f"Force on each hand. {_STORY}")
    parts = [
        f"<header><h1>{escape(title)}</h1><p>{len(runs)} pairs; the report of each: {links}</p></header>",
        *(note for name, run in runs.items() for note in fault_notes(run.record, name)),
        section("What the hands felt", _STORY, image),
        section("Numbers", "The summary of each pair.", _numbers(runs)),
        section("Meetings", _MEETING, _meetings(runs)),
        section("Rates", WORDS, table(rates)),
    ]
    return page_of(title, "".join(parts))


def _numbers(runs: dict[str, Run]) -> str:
    summaries = {name: summary_of(run.record, run.digest.totals) for name, run in runs.items()}
    each = {name: {key: value for key, value, _ in rows(summary)} for name, summary in summaries.items()}
    keys = list(dict.fromkeys(key for values in each.values() for key in values))
    head = "<tr><th></th>" + "".join(f"<th>{escape(name)}</th>" for name in each) + "</tr>"
    body = "".join(
        f"<tr><td>{escape(key)}</td>"
        + "".join(f'<td class="value">{escape(values.get(key, "-"))}</td>' for values in each.values())
        + "</tr>"
        for key in keys
    )
    return f'<div class="scroll"><table class="signals">{head}{body}</table></div>'


def _meetings(runs: dict[str, Run]) -> str:
    lines = []
    for name, run in runs.items():
        closest, push = run.digest.closest, np.linalg.norm(run.ticks["F_instrument_W"], axis=1)
        lines.append(
            f"<tr><td>{escape(name)}</td><td>{1e3 * closest['instrument_gap']:.1f} mm</td>"
            f"<td>{float(push.max()):.2f} N</td><td>{run.digest.pushed / run.record.rate:.2f} s</td>"
            f"<td>{1e3 * closest['handle_gap']:.0f} mm</td></tr>"
        )
    head = (
        "<tr><th>pair</th><th>closest instrument</th><th>largest push</th><th>in contact</th>"
        "<th>closest handle</th></tr>"
    )
    return f'<div class="scroll"><table class="signals">{head}{"".join(lines)}</table></div>'


def _story(runs: dict[str, Run], canvas: Canvas) -> Figure:
    from matplotlib.figure import Figure as NewFigure

    from palpate.base.plotting.style import JOINTS, curve

    figure = NewFigure(figsize=(canvas.width, 4.2), layout="constrained")
    force, push = figure.subplots(2, 1, sharex=True, height_ratios=[2.0, 1.0])
    for k, (name, run) in enumerate(runs.items()):
        ticks, color = run.ticks, JOINTS[k % len(JOINTS)]
        t = ticks["t"]
        curve(force, t, np.linalg.norm(ticks["F_H_L"], axis=1), canvas.points(), color=color, label=name)
        curve(push, t, np.linalg.norm(ticks["F_instrument_W"], axis=1), canvas.points(), color=color)
    force.set_ylabel("on the hand [N]")
    force.set_ylim(bottom=0.0)
    force.legend(ncols=len(runs), loc="upper left")
    push.set_ylabel("of instruments [N]")
    push.set_ylim(0.0, max(0.1, 1.1 * push.get_ylim()[1]))
    push.set_xlabel("time [s]")
    return figure
