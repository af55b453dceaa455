"""The page of a measured device."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from pathlib import Path

from palpate.devices.accuracy import Accuracy
from palpate.devices.bench import AxisBench, Bench
from palpate.devices.judge import Check
from palpate.devices.published import Stated
from palpate.report.html import page_of, section
from palpate.report.page import write

_AXES = (
    "Noise at rest, step of the measured position, and the model mass x'' + damping x' + friction sign(x') = "
    "F(t - delay), fitted to a push to and fro; each with half the width of its 95 % interval."
)
_WALL = (
    "The stiffest wall without damping that is stable on this device, as measured, and at the unsafe end of all "
    "intervals."
)
_FORCE = "The force on the handle over the commanded one, by a known weight or spring, free of friction."
_STATED = "What the driver states, which may be the vendor's figure, beside what was measured."
_PUBLISHED = (
    "What the vendor is quoted with beside what was measured; the largest force is the one that the driver commands."
)
_TESTED = "The checks of `palpate device test` before the first push."


def write_device_page(
    out: Path, found: Bench, compared: Sequence[Accuracy], stated: Sequence[Stated], published: Sequence[Stated] = (),
    checks: Sequence[Check] = (),
) -> Path:  # fmt: skip
    """Write the page; returns its path."""
    head = ("axis", "noise [um]", "step [um]", "mass [kg]", "damping [N s/m]", "friction [N]", "delay [ms]")
    parts = [
        f"<h1>{escape(found.name)}</h1>",
        section("Rate", f"{found.rate_Hz:.0f} Hz; 99 % of the intervals are below {found.interval_p99_us:.0f} us.", ""),
        section("Axes", _AXES, _table(head, [_cells(axis) for axis in found.axes])),
    ]
    if found.pushed:
        limit, unsafe = found.limits()
        rows = [("as measured", f"{limit:.0f} N/m"), ("at the unsafe end", f"{unsafe:.0f} N/m")]
        parts.append(section("Stable wall", _WALL, _table(("", "stiffness"), rows)))
    if compared:
        forces = [(one.by, f"{one.given:g}", f"{one.gain:.4f} +-{one.reach:.2g}", one.in_words()) for one in compared]
        parts.append(section("Force", _FORCE, _table(("by", "given [kg, N/m]", "gain [-]", ""), forces)))
    parts.append(section("As stated?", _STATED, _figures(stated)))
    if published:
        parts.append(
            section("As published?", f"{_PUBLISHED} Source: {escape(published[0].source)}.", _figures(published))
        )
    if checks:
        tested = [(check.name, "ok" if check.passed else "failed", check.value) for check in checks]
        parts.append(section("Driver", _TESTED, _table(("check", "", "found"), tested)))
    doubts = "".join(f"<li>{escape(doubt)}</li>" for doubt in found.doubts())
    parts.append(section("Doubts", "What the model does not explain.", f"<ul>{doubts}</ul>") if doubts else "")
    return write(out, page_of(f"Device {found.name}", "".join(parts)))


def _cells(axis: AxisBench) -> tuple[str, ...]:
    step = "none seen" if axis.resolution_m is None else f"{1e6 * axis.resolution_m:.3g}"
    f = axis.fit
    if f is None:
        return (axis.axis, f"{1e6 * axis.noise_m:.3g}", step, "-", "-", "-", "-")
    values = [
        f"{getattr(f, key):.3g} +-{f.student * getattr(f.deviations, key):.1g}"
        for key in ("mass", "damping", "friction")
    ]
    delay = f"{1e3 * f.delay:.3g} +-{1e3 * f.student * f.deviations.delay:.1g}"
    return (axis.axis, f"{1e6 * axis.noise_m:.3g}", step, *values, delay)


def _figures(rows: Sequence[Stated]) -> str:
    cells = [
        (row.name, f"{row.stated:.4g}", f"{row.measured:.4g}", row.unit, "yes" if row.agrees else "no") for row in rows
    ]
    return _table(("figure", "stated", "measured", "unit", "agrees"), cells)


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    top = "".join(f"<th>{escape(cell)}</th>" for cell in head)
    body = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>"
