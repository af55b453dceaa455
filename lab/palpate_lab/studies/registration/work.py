"""The work of ``palpate study registration``: the sweeps, and their summaries."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from palpate_lab.studies._command import Sweeper
from palpate_lab.studies.registration import chain, fiducials, sessions, surfaces, touches, views
from palpate_lab.studies.registration.result import Chained, Found, Marked, Matched, Predicted, Registered, Seen, Viewed

_FLE = ("estimated", "stated")
_ERRORS = ("isotropic", "anisotropic")
Row = dict[str, Any]


def run(
    sweep: Sweeper, layouts: int, trials: int, clouds: int, touched: int, chains: int, registered: int, seed: int
) -> Found:
    """The whole study.

    Args:
        sweep: runs a function over a grid.
        layouts: number of layouts of markers.
        trials: number of trials with markers and with views of a board, each.
        clouds: number of partial views.
        touched: number of runs of the touching hand.
        chains: number of set-ups of the whole chain.
        registered: number of sessions.
        seed: seed of all trials.
    """
    drawn = sweep(fiducials.predicted, {"anisotropic": (0, 1), "layout": range(layouts)}, seed, title="layouts").rows()
    unknown = sweep(fiducials.unknown, {"known": (0, 1), "trial": range(trials)}, seed, title="unknown").rows()
    wrong = sweep(fiducials.wrong, {"known": (0, 1), "trial": range(trials)}, seed, title="wrong").rows()
    seen = sweep(views.judged, {"mount": (0, 1), "trial": range(trials)}, seed, title="views").rows()
    grid = {"kind": range(len(surfaces.KINDS)), "trial": range(clouds)}
    viewed = sweep(surfaces.judged, grid, seed, title="surfaces", where=lambda p: _taken(p, clouds)).rows()
    linked = sweep(chain.judged, {"trial": range(chains)}, seed, title="chains").rows()
    grid = {"kind": range(len(sessions.KINDS)), "trial": range(registered)}
    done = sweep(sessions.judged, grid, seed, title="sessions", where=lambda p: _counted(p, registered)).rows()
    by_error = dict(zip(_ERRORS, _split(drawn, "anisotropic", 2), strict=True))
    return {
        "simulated": True,
        "seed": seed,
        "predicted": {name: _predicted(rows) for name, rows in by_error.items()},
        "unknown": {name: _matched(rows) for name, rows in zip(_FLE, _split(unknown, "known", 2), strict=True)},
        "wrong_marker": {name: _marked(rows) for name, rows in zip(_FLE, _split(wrong, "known", 2), strict=True)},
        "surface": {
            name: _viewed(rows)
            for name, rows in zip(surfaces.KINDS, _split(viewed, "kind", len(surfaces.KINDS)), strict=True)
        },
        "wrong_told": _told(viewed),
        "handeye": {name: _seen(rows) for name, rows in zip(views.MOUNTS, _split(seen, "mount", 2), strict=True)},
        "touched": touches.run(touched),
        "chain": _chained(list(linked)),
        "session": {
            name: _registered(rows)
            for name, rows in zip(sessions.KINDS, _split(done, "kind", len(sessions.KINDS)), strict=True)
        },
        "real": surfaces.real(),
        "layouts": by_error,
    }


def _taken(point: Row, clouds: int) -> bool:
    """Searches without a start take longer, so a fifth of the trials are of this kind."""
    return surfaces.KINDS[point["kind"]] != "none" or bool(point["trial"] < max(1, clouds // 5))


def _counted(point: Row, registered: int) -> bool:
    """A fifth of the sessions for each wrong kind."""
    return sessions.KINDS[point["kind"]] == "right" or bool(point["trial"] < max(1, registered // 5))


def _split(rows: Iterable[Row], key: str, n: int) -> list[list[Row]]:
    listed = list(rows)
    return [[row for row in listed if int(row[key]) == k] for k in range(n)]


def _column(rows: Sequence[Row], key: str) -> Any:
    return np.array([row[key] for row in rows])


def _mean(values: Any) -> float | None:
    return float(values.mean()) if len(values) else None


def _predicted(rows: list[Row]) -> Predicted:
    reference = _column(rows, "closed_form_m")
    isotropic = bool((reference > 0.0).all())
    closed = np.abs(_column(rows, "predicted_m") / np.maximum(reference, 1e-12) - 1.0)
    return {
        "layouts": len(rows),
        "p95_m": float(_column(rows, "p95_m").mean()),
        "largest_p95_m": float(_column(rows, "p95_m").max()),
        "largest_error": float(np.abs(_column(rows, "error")).max()),
        "largest_from_closed_form": float(closed.max()) if isotropic else None,
        "largest_from_horn": float(_column(rows, "from_horn").max()) if isotropic else None,
    }


def _matched(rows: list[Row]) -> Matched:
    right, refused = _column(rows, "right"), _column(rows, "refused")
    return {"trials": len(rows), "right": float(right.mean()), "refused": float(refused.mean())}


def _marked(rows: list[Row]) -> Marked:
    found, alone, alarm = (float(_column(rows, key).mean()) for key in ("found", "alone", "alarm"))
    return {"trials": len(rows), "found": found, "alone": alone, "false_alarms": alarm}


def _viewed(rows: list[Row]) -> Viewed:
    wrong, trusted, error = (_column(rows, key) for key in ("wrong", "trusted", "error_m"))
    solvable = bool((error < 1.0).any())
    right = wrong == 0
    return {
        "trials": len(rows),
        "wrong": int(wrong.sum()),
        "converged": float(right.mean()) if solvable else None,
        "median_m": float(np.median(error)) if solvable else None,
        "p95_m": float(np.quantile(error, 0.95)) if solvable else None,
        "wrong_told": _mean(1.0 - trusted[~right]),
        "right_trusted": _mean(trusted[right]),
        "mean_nees": _mean(_column(rows, "nees")[right]),
    }


def _told(rows: Iterable[Row]) -> float | None:
    """Share of all wrong answers that are not trusted."""
    return _mean(np.array([1.0 - row["trusted"] for row in rows if row["wrong"]]))


def _chained(rows: list[Row]) -> Chained:
    return {
        "trials": len(rows),
        "tip_median_m": float(np.median(_column(rows, "tip_median_m"))),
        "tip_largest_m": float(_column(rows, "tip_largest_m").max()),
        "felt_median_m": float(np.median(_column(rows, "felt_median_m"))),
        "felt_largest_m": float(_column(rows, "felt_largest_m").max()),
        "felt_within_1mm": float(_column(rows, "felt_within").mean()),
    }


def _registered(rows: list[Row]) -> Registered:
    told, error = _column(rows, "told"), _column(rows, "error_m")
    met = told == 0.0

    def mean(key: str) -> float | None:
        values = _column(rows, key)[met]
        return _mean(values[np.isfinite(values)])

    return {
        "trials": len(rows),
        "told": float(told.mean()),
        "right": mean("right"),
        "predicted_m": float(np.sqrt(np.square(_column(rows, "predicted_m")[met]).mean())) if met.any() else None,
        "error_m": float(np.sqrt(np.square(error[met]).mean())) if met.any() else None,
        "largest_m": float(error[met].max()) if met.any() else None,
        "touches": mean("touches"),
        "seconds": mean("seconds"),
        "check_passed": mean("passed"),
        "off_failed": mean("off_failed"),
    }


def _seen(rows: list[Row]) -> Seen:
    return {
        "trials": len(rows),
        "position_p95_m": float(np.quantile(_column(rows, "position_m"), 0.95)),
        "rotation_p95_rad": float(np.quantile(_column(rows, "rotation_rad"), 0.95)),
        "mean_nees": float(_column(rows, "nees").mean()),
    }
