"""The report of an experiment as one self-contained HTML file."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from palpate.base.errors import MissingExtraError
from palpate.experiment.analysis import Effect, Power, means
from palpate.experiment.model import MEASURES, ConditionSection
from palpate.experiment.outcome import Found
from palpate.experiment.study import MANIFEST, read_manifest
from palpate.report.html import page_of, section
from palpate.report.page import write

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from palpate.base.plotting.style import Canvas

_SIMULATED = (
    "<strong>Simulated.</strong> All participants are simulated hands (docs/operators.md). They exercise the whole "
    "experiment and show how arm, cycle and conditions act on hands with these traits; they say nothing about people."
)


def write_report(found: Found, file: Path) -> Path:
    """Write the report; returns its file.

    Raises:
        MissingExtraError: matplotlib is not installed. OutputError: the page cannot be written.
    """
    experiment = found.study.experiment
    head = f"<header><h1>{escape(experiment.title)}</h1></header>"
    banner = f'<section class="note"><p>{_SIMULATED}</p></section>' if found.study.simulated else ""
    parts = [head, banner, _design(found), _people(found), _effects(found), _figure(found), _sensitivity(found)]
    parts += [_answers(found)] if found.asked else []
    parts += [_power(found)] if found.power else []
    return write(file, page_of(experiment.title, "".join([*parts, _origin(found)])))


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table as HTML; the cells are texts."""
    cells = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    names = "".join(f"<th>{escape(name)}</th>" for name in head)
    return f"<table><thead><tr>{names}</tr></thead><tbody>{cells}</tbody></table>"


def _design(found: Found) -> str:
    e = found.study.experiment
    order = "a Latin square balanced for carry-over" if e.order == "latin-square" else "drawn for each participant"
    words = (
        f"{len(found.study.people)} participants, {len(e.conditions)} conditions, {len(e.tasks)} tasks, "
        f"{e.repetitions} repetitions after {e.familiarisation} trials of each task that do not count. Order of the "
        f"conditions: {order}, fixed beforehand with seed {e.seed}. Reference: {next(iter(e.conditions))}. Primary "
        f"measure, declared beforehand: {_name(e.measures[0])}."
    )
    rows = [(name, one.words or _in_words(one)) for name, one in e.conditions.items()]
    tasks = [(name, one.words or "-", f"{one.time_limit:g} s") for name, one in e.tasks.items()]
    body = table(("condition", "what it is"), rows) + table(("task", "instruction", "time limit"), tasks)
    return section("What was compared", escape(words), body)


def _in_words(one: ConditionSection) -> str:
    values = one.model_dump(mode="json", exclude_defaults=True, exclude={"words"})
    return ", ".join(f"{k}: {v}" for k, v in values.items()) or "the scene as it is"


def _people(found: Found) -> str:
    rows = [
        (r["participant"], f"{r['ended']} of {r['planned']}", str(r["aborted"]), str(r["lost"])) for r in found.state
    ]
    wins = [row["success"] for row in found.rows]
    share = f"{100 * np.mean(wins):.0f} % of {len(wins)} trials that count were successful. " if wins else ""
    words = share + "Aborted and lost attempts were repeated, and count in no figure; their records are kept."
    return section("Trials", words, table(("participant", "trials ended", "aborted", "lost to a kill"), rows))


def _effects(found: Found) -> str:
    words = (
        "Difference of each condition from the reference: mean over participants with its 95 % interval, the same over "
        "its standard deviation (d<sub>z</sub>), and the probability by a mixed model with the participant as random "
        "effect, corrected for all tests of the table (Holm)."
    )
    return section("Differences", words, _effect_table(found.effects))


def _effect_table(effects: Sequence[Effect]) -> str:
    head = ("measure", "condition", "n", "mean", "difference [95 %]", "d_z [95 %]", "p", "p (Holm)")
    rows = [
        (
            _name(one.measure), one.condition, str(one.participants), _number(one.mean),
            f"{_number(one.difference)} [{_number(one.low)}, {_number(one.high)}]",
            f"{_number(one.dz)} [{_number(one.dz_low)}, {_number(one.dz_high)}]", _p(one.p), _p(one.p_holm),
        )
        for one in effects
    ]  # fmt: skip
    return table(head, rows)


def _figure(found: Found) -> str:
    try:
        from palpate.base.plotting.style import picture
    except ImportError as error:
        raise MissingExtraError("the report's figures", "report") from error
    measures = found.study.experiment.measures
    words = "Each grey line is a participant, averaged over tasks and repetitions; the red points are the means."
    alt = f"Participants' means by condition. {words}"
    return section("Participants", words, picture(lambda canvas: _draw(found, measures, canvas), alt=alt))


def _draw(found: Found, measures: Sequence[str], canvas: Canvas) -> Figure:
    from matplotlib.figure import Figure

    from palpate.base.plotting.style import CELL, FORCE

    names = list(found.study.experiment.conditions)
    columns = 1 if canvas.narrow else min(3, len(measures))
    rows = -(-len(measures) // columns)
    figure = Figure(figsize=(canvas.width, 2.4 * rows), layout="constrained")
    for k, measure in enumerate(measures):
        axes = figure.add_subplot(rows, columns, k + 1)
        _, values = means(found.rows, measure, names)
        if len(values):
            axes.plot(range(len(names)), values.T, color=CELL, lw=0.6, alpha=0.7)
            axes.plot(
                range(len(names)), np.nanmean(values, axis=0) if np.isfinite(values).any() else [], "o", color=FORCE
            )
        axes.set_xticks(range(len(names)), names)
        axes.set_title(_name(measure))
        axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
    return figure


def _sensitivity(found: Found) -> str:
    """The score of force sensitivity by task and condition, and whether it follows the duration of a trial."""
    e, rows = found.study.experiment, []
    for task in e.tasks:
        some = [row for row in found.rows if row["task"] == task and row["force_sensitivity"] is not None]
        if not some:
            continue
        by = [[row["force_sensitivity"] for row in some if row["condition"] == c] for c in e.conditions]
        times = [[row["time_s"] for row in some if row["condition"] == c] for c in e.conditions]
        rho = [_rank_correlation(v, t) for v, t in zip(by, times, strict=True)]
        mean = float(np.mean([r for r in rho if np.isfinite(r)] or [np.nan]))
        rows.append((task, *(f"{np.mean(v):.0f}" if v else "-" for v in by), "-" if mean != mean else f"{mean:.2f}"))
    words = (
        "Mean score from 0 to 100 from the true force of contact (docs/metrics.md). The last column is its rank "
        "correlation with the duration, the mean over the conditions: the score shall not follow the pace."
    )
    body = table(("task", *e.conditions, "with duration"), rows) if rows else "<p>No task has a contact.</p>"
    return section("Force sensitivity", words, body)


def _rank_correlation(a: Sequence[float], b: Sequence[float]) -> float:
    if len(a) < 3 or len(set(a)) < 2 or len(set(b)) < 2:
        return float("nan")
    from scipy.stats import spearmanr

    return float(spearmanr(a, b).statistic)


def _answers(found: Found) -> str:
    words = "Answers after each condition, compared as the measures are. tlx: mean of the six scales, low is good."
    drawn = " Simulated participants answer at random around the duration and the force error." * found.study.simulated
    body = _effect_table(found.answered)
    if any(found.preferred.values()):
        body += table(("condition", "preferred by"), [(k, str(v)) for k, v in found.preferred.items()])
    return section("Questionnaires", words + drawn, body)


def _power(found: Found) -> str:
    names = list(found.study.experiment.conditions)[1:]
    people = list(dict.fromkeys(one.participants for one in found.power))
    by = {(one.participants, one.condition): one for one in found.power}

    def cell(one: Power) -> str:
        return f"{one.power:.2f} [{one.low:.2f}, {one.high:.2f}]"

    rows = [(str(n), *(cell(by[n, name]) for name in names)) for n in people]
    words = (
        f"Share of experiments with this number of participants that find a difference from the reference in "
        f"{_name(found.study.experiment.measures[0])}, drawn from the simulated participants. People scatter "
        "otherwise: take the number for 80 % as a lower bound."
    )
    return section("Power", words, table(("participants", *names), rows))


def _origin(found: Found) -> str:
    manifest = read_manifest(found.study.folder / MANIFEST)
    rows = [(k, str(manifest[k])) for k in ("palpate", "python", "seed", "sha256")]
    rows += [(f"scene {k}", v) for k, v in manifest["scenes"].items()]
    return section("Origin", "Frozen before the first trial.", table(("what", "value"), rows))


def _name(measure: str) -> str:
    words, unit = MEASURES.get(measure, (measure.replace("_", " "), ""))
    return f"{words} [{unit}]" if unit else words


def _number(value: float) -> str:
    return "-" if value != value else f"{value:.3g}"


def _p(value: float) -> str:
    return "-" if value != value else "< 0.001" if value < 0.001 else f"{value:.3f}"
