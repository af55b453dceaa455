"""Terminal output of ``palpate study registration``: each figure beside what was asked of it."""

from __future__ import annotations

import numpy as np
from rich.table import Table

from palpate_lab.studies.registration.result import Chained, Found, Real, Registered, Touched


def table(found: Found) -> Table:
    """All figures with their requirements."""
    shown = Table(title="registration, simulated", title_justify="left", box=None, pad_edge=False)
    for head in ("figure", "reached", "required"):
        shown.add_column(head, justify="left" if head == "figure" else "right")
    for row in [
        *_fiducials(found),
        *_surfaces(found),
        *_views(found),
        _touched(found["touched"]),
        *_chained(found["chain"]),
        *_registered(found["session"]),
    ]:
        shown.add_row(*row)
    return shown


def _fiducials(found: Found) -> list[tuple[str, str, str]]:
    rows = []
    for kind, one in found["predicted"].items():
        rows += [
            (f"TRE p95, {one['layouts']} layouts, {kind}, largest", f"{1e3 * one['largest_p95_m']:.3f} mm", "0.5 mm"),
            (f"predicted against simulated TRE, {kind}, largest", f"{100 * one['largest_error']:.1f} %", "10 %"),
        ]
        if one["largest_from_closed_form"] is not None:
            rows.append(("against Fitzpatrick's closed form", f"{100 * one['largest_from_closed_form']:.2g} %", ""))
        if one["largest_from_horn"] is not None:
            rows.append(("pose against Horn's quaternions", f"{one['largest_from_horn']:.1g}", ""))
    for fle, matched in found["unknown"].items():
        rows.append((f"unknown correspondence found, FLE {fle}", _percent(matched["right"]), ">= 99 %"))
    for fle, marked in found["wrong_marker"].items():
        rows += [
            (f"marker 3 mm off found, FLE {fle}", _percent(marked["found"]), ">= 99 %"),
            (f"false alarms, FLE {fle}", _percent(marked["false_alarms"]), "<= 1 %"),
        ]
    return rows


def _surfaces(found: Found) -> list[tuple[str, str, str]]:
    rows = []
    for kind, one in found["surface"].items():
        if one["converged"] is not None and one["p95_m"] is not None:
            asked = ">= 95 %" if kind == "rough" else ""
            rows.append((f"liver, start {kind}: converged, {one['trials']} views", _percent(one["converged"]), asked))
            if kind == "rough":
                rows.append(("liver, rms error of its points, p95", f"{1e3 * one['p95_m']:.2f} mm", ""))
                rows.append(("right answers that are trusted", _percent(one["right_trusted"]), ""))
    wrong = sum(one["wrong"] for one in found["surface"].values())
    rows.append((f"wrong answers told as wrong, of {wrong}", _percent(found["wrong_told"]), ">= 99 %"))
    return rows


def _views(found: Found) -> list[tuple[str, str, str]]:
    return [
        (
            f"hand-eye, camera {'on the arm' if mount == 'arm' else 'beside it'}, p95",
            f"{1e3 * one['position_p95_m']:.2f} mm, {np.degrees(one['rotation_p95_rad']):.2f} deg",
            "0.5 mm, 0.2 deg",
        )
        for mount, one in found["handeye"].items()
    ]


def _touched(one: Touched) -> tuple[str, str, str]:
    reached = f"{1e3 * one['simulated_m']:.2f} mm rms, predicted {1e3 * one['predicted_m']:.2f} mm"
    return f"TRE from 8 landmarks touched by the simulated hand, {one['trials']} runs", reached, ""


def _chained(one: Chained) -> list[tuple[str, str, str]]:
    tip = f"{1e3 * one['tip_median_m']:.2f} mm, largest {1e3 * one['tip_largest_m']:.2f} mm"
    felt = f"{_percent(one['felt_within_1mm'])}, largest {1e3 * one['felt_largest_m']:.2f} mm"
    return [
        (f"tracker, two PSMs, camera, {one['trials']} set-ups: tip to surface, median", tip, "1 mm"),
        ("the same: felt contact within 1 mm of the seen surface, 20 places each", felt, "all"),
    ]


def _registered(found: dict[str, Registered]) -> list[tuple[str, str, str]]:
    one, wrong = found["right"], [row for name, row in found.items() if name != "right"]
    told = sum(row["told"] * row["trials"] for row in wrong) / max(sum(row["trials"] for row in wrong), 1)
    rows = [
        (f"sessions that end as met, of {one['trials']}", _percent(1.0 - one["told"]), ""),
        ("of these: every target within its bound", _percent(one["right"]), ">= 95 %"),
        ("wrong set-ups told (moved, tip off, mirrored, other scan)", _percent(told), ""),
        ("touch check: right registrations passed", _percent(one["check_passed"]), ""),
        ("touch check: registrations 3 mm off failed", _percent(one["off_failed"]), ""),
    ]
    if one["error_m"] is not None and one["predicted_m"] is not None:
        reached = f"{1e3 * one['error_m']:.2f} mm rms, predicted {1e3 * one['predicted_m']:.2f} mm"
        rows.insert(2, ("error at the worst target of each session", reached, ""))
    return rows


def _percent(share: float | None) -> str:
    return "none" if share is None else f"{100 * share:.1f} %"


def line_of_real(real: Real | None) -> str:
    """The real pair of clouds in one line."""
    if real is None:
        return "real pair of clouds: skipped, the data are absent (PALPATE_DATA)"
    return (
        f"real Kinect pair, moved by {1e3 * real['moved_m']:.0f} mm: {100 * real['explained']:.0f} % of "
        f"{real['points']} points explained, {1e3 * real['rms_m']:.1f} mm rms; "
        f"{1e3 * real['from_small_gicp_m']:.1f} mm and {np.degrees(real['from_small_gicp_rad']):.2f} deg "
        "from small_gicp's GICP"
    )
