"""The report of a run as one self-contained HTML file: numbers, figures, text."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from palpate.arm import Arm
from palpate.base.errors import MissingExtraError, PalpateError
from palpate.record.reader import Record
from palpate.record.ticks import STATUS
from palpate.report import elements, energy, imperfections, rates, tracked
from palpate.report.assumptions import FAST_FORCE, SlowMotion, slow_motion_of
from palpate.report.diagram import diagram, signal_table
from palpate.report.grasp import grasp_of
from palpate.report.page import write
from palpate.report.run import Run
from palpate.report.soft import soft_law
from palpate.report.summary import given, rows, summary_of
from palpate.report.words import GLOSSARY
from palpate.session.recorded import recorded_scene
from palpate.session.summary import Summary

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from palpate.base.plotting.style import Canvas


def write_report(record: str | Path, out: str | Path | None = None) -> Path:
    """Write the report of a record.

    Args:
        record: the record's file.
        out: the HTML file to write; ``report.html`` next to the record when left out.

    Returns:
        The file written.

    Raises:
        RecordError: the record cannot be read. MissingExtraError: matplotlib is not installed.
        OutputError: the page cannot be written.
    """
    return report_of(Run(Record.open(record)), out)


def report_of(run: Run, out: str | Path | None = None) -> Path:
    """Write the report of an opened run; otherwise as `write_report`."""
    page = Path(out) if out is not None else run.record.path.with_name("report.html")
    return write(page, _page(run))


def report(record: Record) -> str:
    """The page as HTML text; the same record gives the same page. Raises MissingExtraError without matplotlib."""
    return _page(Run(record))


def _page(run: Run) -> str:
    try:
        from palpate.base.plotting.style import picture
        from palpate.report import figures, remote, views
    except ImportError as error:
        raise MissingExtraError("the report's figures", "report") from error

    record, digest = run.record, run.digest
    summary = summary_of(record, digest.totals)
    slow = slow_motion_of(digest, float(run.setting("torque", "fast_force") or FAST_FORCE))

    def figure(title: str, text: str, draw: Callable[[Run, Canvas], Figure]) -> str:
        image = picture(partial(draw, run), alt=f"{title}. {text}".replace('"', "'"))
        return section(title, text, image)

    frames = run.tracked_frames
    timed = not record.deterministic and len(digest.times["cycle_us"].values) > 0
    parts = [
        _head(run),
        _facts(summary),
        *_notes(run, slow),
        figure("What the hand felt", _story_words(run), figures.story),
        *([figure("Across the network", remote.words(run), remote.figure)] if remote.crossed(run) else []),
        figure("Where the tool went", _VIEWS + ("" if run.surface else _NO_SURFACE), views.path),
        figure("Force over penetration", _stiffness_words(run), figures.stiffness),
        *([figure("What the jaws held", held.words(), figures.grasp)] if (held := grasp_of(run)) else []),
        section("The loop that ran", _LOOP, f"{diagram(run)}{_details('All recorded signals', signal_table(run))}"),
        figure("The two terms of the torque (Eq 13)", _TORQUE, figures.torques),
        section("The sphere's springs and dampers", _ELEMENTS, elements.table(run.ticks)),
        section("What touched what", _TOUCHES, digest.touched.table(run.sphere_names, run.object_names, record.rate)),
        *([section("Tracked frames", tracked.WORDS, digest.tracked.table(frames, record.rate))] if frames else []),
        figure("The same force in two frames", _FRAMES, figures.frames),
        figure("Energy ledger", energy.words(run), figures.energy),
        *([figure("Time", _timing_words(run, summary), figures.timing)] if timed else []),
        section("Rates", rates.WORDS, rates.table(rates.rates_of(run))),
        _numbers(run, summary, slow),
        imperfections.section(record),
        _scene(run),
        _glossary(),
        _foot(record, summary),
    ]
    return page_of(run.title, "".join(parts))


def section(title: str, text: str, body: str) -> str:
    """A section of the page: heading, paragraph and body (HTML)."""
    return f"<section><h2>{title}</h2><p>{text}</p>{body}</section>"


def _details(summary: str, body: str) -> str:
    return f"<details><summary>{summary}</summary>{body}</details>"


def page_of(title: str, body: str) -> str:
    """The whole page as HTML text."""
    css = files("palpate.report").joinpath("page.css").read_text(encoding="utf-8")
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        '<link rel="icon" href="data:,">'
        f"<title>{escape(title)}: palpation report</title><style>{css}</style></head>"
        f"<body><main>{body}</main></body></html>\n"
    )


_VIEWS = (
    "The tool tip (blue) and the proxy that stays on the surface (red), in the world frame W. Where the two differ, "
    "the tool is inside the object and the spring pulls it back along the red lines."
)
_NO_SURFACE = " The mesh of the scene is not available any more, so only the paths are drawn."
_LOOP = (
    "The paper's Fig 3: motion flows from the hand to the tool (blue), force flows back (red). Every symbol is a "
    "recorded channel with its unit; point at it to read its meaning."
)
_TORQUE = (
    "Commanded motor torques. One term renders the force on the hand, the other compensates the arm's weight, so that "
    "the hand feels the organ and not the arm. Joint 4 has its own position controller, as on the real arm."
)
_TOUCHES = (
    "Each pair of a tool sphere and an object, with the spring force along the normal. This force acts at the tool, "
    "before force scale, damping, filters and force cap, so it can exceed the force on the hand. The sphere at the tip "
    "is the spherical proxy region (SPR); <code>contact.whole_tool</code> and <code>contact.spheres</code> add spheres "
    "on jaws and shaft."
)
_ELEMENTS = (
    "The paper's Fig 7: along each axis of the world frame, a spring and a damper connect the tool to the sphere at "
    "its tip, the spherical proxy region (SPR). The table shows their compression and force at the deepest contact."
)
_FRAMES = (
    "Both plots show the same force. A rotation of the wrist changes its components in the handle's frame, but not "
    "those in the base frame. The paper draws the base-frame force green and the handle-frame force red."
)


def _story_words(run: Run) -> str:
    if not run.touches:
        return "Nothing was touched in this run."
    from palpate.report.figures import SHADED

    touches = len(run.touches)
    phases = "The background shows the phases press, slide and leave, found from the motion. "
    return (
        f"{'One touch' if touches == 1 else f'{touches} touches'}. "
        f"{phases if len(run.phases) <= SHADED else ''}"
        "The load cell differs from the rendered force by the arm's friction and inertia."
    )


def _stiffness_words(run: Run) -> str:
    if run.stiffness is None:
        return "Nothing was touched, so there is no stiffness to show."
    soft = soft_law(run)
    if soft is not None:
        return (
            f"The lines are Sneddon's solution for a sphere of {1e3 * soft.radius:g} mm on a half-space of this "
            "tissue, before and after relaxation. An organ departs from them by its shape, supports and large strain."
        )
    scale = float(run.setting("mapping", "scale") or 1.0) * float(run.setting("mapping", "force_scale") or 1.0)
    felt = f"{run.stiffness * scale:.0f} N/m"
    if abs(scale - 1.0) < 1e-9:
        words = f"The hand feels {felt}, as motion and force together are not scaled."
    else:
        words = f"The hand feels {felt}: motion scale times force scale is {scale:g}."
    return f"The line is the spring at the tool, {run.stiffness:.0f} N/m. {words} Deviations from the line are damping."


def _timing_words(run: Run, summary: Summary) -> str:
    scheduler = (run.record.timing or {}).get("scheduler")
    how = f" Scheduling: {escape(str(scheduler))}." if scheduler else ""
    missed = f"{summary.missed_ticks} of {summary.missed_ticks + summary.ticks} ticks were missed"
    return f"Real-time run at {run.record.rate:g} Hz: {missed}. Both axes are logarithmic.{how}"


def _head(run: Run) -> str:
    record = run.record
    mode = "lockstep (deterministic)" if record.deterministic else "real time"
    seed = f", seed {record.seed}" if record.seed is not None else ""
    return (
        f"<header><h1>{escape(run.title)}</h1><p>Palpation report. {record.duration:.2f} s at {record.rate:g} Hz, "
        f"{mode}{seed}. Hand, arms and load cell are simulated.</p></header>"
    )


def _facts(s: Summary) -> str:
    facts = [
        (f"{s.peak_force_N:.2f} N", f"peak force on the hand; {s.peak_50ms_N:.2f} N over 50 ms"),
        (f"{1e3 * s.max_penetration_m:.2f} mm", "deepest penetration"),
        (f"{s.contact_s:.2f} s", f"in contact, of {s.duration_s:.2f} s"),
        (f"{1e3 * s.energy_J:.1f} mJ", "energy taken from the hand" if s.energy_J >= 0 else f"energy {given(s)}"),
    ]
    return f'<div class="facts">{"".join(f"<div class=fact><b>{v}</b><span>{k}</span></div>" for v, k in facts)}</div>'


def fault_notes(record: Record, pair: str = "") -> list[str]:
    """What the page says of a record that is not whole, and of each fault; with the name of its pair."""
    of = f"<b>{escape(pair)}:</b> " if pair else ""
    notes = [f'<div class="note bad"><p>{of}{escape(record.note)}</p></div>'] if record.note else []
    return notes + [f'<div class="note bad"><p><b>Fault.</b> {of}{escape(fault)}</p></div>' for fault in record.faults]


def _notes(run: Run, slow: SlowMotion) -> list[str]:
    notes = fault_notes(run.record)
    why = (
        "The controller (Eq 13) assumes slow motion: it renders the force and compensates the arm's weight, but not "
        "the arm's inertia and Coriolis forces, which the hand feels. The cycle estimates them from its own model. "
        "The limit is the smallest force that a hand notices on top of a few newtons. The impedance law neglects less, "
        "the admittance law nothing."
    )
    kind, title = ("note", "Assumption holds.") if slow.kept else ("note warn", "Assumption violated.")
    notes.append(f'<div class="{kind}"><p><b>{title}</b> {escape(slow.words)}</p><p>{escape(why)}</p></div>')
    return notes


def _leader(run: Run) -> Arm | None:
    """The leader of a run; None when the record holds no scene or the arm's file is missing."""
    try:
        return recorded_scene(run.record).arm("leader")
    except PalpateError:
        return None


def _numbers(run: Run, summary: Summary, slow: SlowMotion) -> str:
    lines = rows(summary)
    lines.append(("inertia", f"{slow.peak_inertia:.2f} N", "largest inertia and Coriolis force of the arm on the hand"))
    leader = _leader(run)
    if leader is not None and leader.n >= 3:
        condition = elements.conditioning(run.ticks[run.digest.even], leader)
        words = "condition number of the 3x3 Jacobian of the wrist centre, median and worst: 1 is isotropic"
        lines.append(("leader's Jacobian", f"{np.median(condition):.2f} / {condition.max():.2f}", words))
    for name, (_, words) in STATUS.items():
        count = run.digest.status[name]
        if count:
            lines.append((name.replace("_", " "), f"{count / run.record.rate:.3f} s", words))
    body = "".join(
        f'<tr><td>{escape(k)}</td><td class="value">{escape(v)}</td><td>{escape(m)}</td></tr>' for k, v, m in lines
    )
    return f'<section><h2>Numbers</h2><table class="facts-table">{body}</table></section>'


def _scene(run: Run) -> str:
    lines = []
    objects = run.setting("objects")
    for obj in objects if isinstance(objects, list) else []:
        if isinstance(obj, dict):
            made = obj.get("shape") or Path(str(obj.get("mesh", ""))).name
            lines.append((f"object {obj.get('name') or made}", str(made), "shape or mesh of the object"))
            lines += [
                (f"{key} of {obj.get('name') or made}", f"{_plain(obj[key])}{unit}", words)
                for key, unit, words in (
                    ("stiffness", " N/m", "force over penetration; one number per axis of W"),
                    ("damping", " N s/m", "force over speed"),
                    ("friction", "", "tangential force over normal force"),
                )
                if key in obj
            ]
    for place, unit, words in (
        (("contact", "radius"), " m", "radius of the sphere at the tool tip that touches the objects"),
        (("mapping", "scale"), "", "tool motion over hand motion"),
        (("stability", "force_cap"), " N", "largest force allowed on the hand"),
        (("stability", "rate_cap"), " N/s", "fastest allowed change of the force"),
        (("rates", "haptic"), " Hz", "rate of the haptic cycle"),
        (("rates", "plant"), " Hz", "step rate of the simulated arm"),
        (("loop_delay",), " s", "simulated delay between command and torque"),
    ):
        value = run.setting(*place)
        if value is not None:
            lines.append((" ".join(place).replace("_", " "), f"{_plain(value)}{unit}", words))
    body = "".join(
        f'<tr><td>{escape(k)}</td><td class="value">{escape(v)}</td><td>{escape(m)}</td></tr>' for k, v, m in lines
    )
    yaml = f"<details><summary>The scene file as resolved</summary><pre>{escape(run.record.scene)}</pre></details>"
    return f'<section><h2>Scene</h2><table class="facts-table">{body}</table>{yaml}</section>'


def _plain(value: object) -> str:
    if isinstance(value, list):
        return _plain(value[0]) if len(set(map(str, value))) == 1 else ", ".join(_plain(v) for v in value)
    return f"{value:g}" if isinstance(value, int | float) else str(value)


def _glossary() -> str:
    words = list(GLOSSARY.items())
    half = (len(words) + 1) // 2
    columns = "".join(
        "<dl>" + "".join(f"<dt>{escape(k)}</dt><dd>{escape(v)}</dd>" for k, v in part) + "</dl>"
        for part in (words[:half], words[half:])
    )
    return f'<section><h2>Words</h2><div class="two">{columns}</div></section>'


def _foot(record: Record, summary: Summary) -> str:
    version = f"palpate {record.version}, " if record.version else ""
    return (
        f"<footer>{escape(version)}record {escape(record.path.name)}, SHA-256 {summary.record_sha256}. "
        "The record opens in Foxglove, PlotJuggler and rosbag2.</footer>"
    )
