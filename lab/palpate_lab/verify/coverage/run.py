"""Runs the trials of all estimates, and the table of what they show."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Protocol, cast

import numpy as np
from rich.console import Console

from palpate.base.arrays.intervals import proportion
from palpate.base.errors import MissingExtraError, PalpateError
from palpate.base.sweep import Axis, sweep
from palpate.base.sweep.grid import Point
from palpate_lab.verify.coverage import estimates
from palpate_lab.verify.coverage.trial import RIGHT, Trial

if TYPE_CHECKING:
    from rich.table import Table

ASKED = 0.93, 0.97
"""Asked share of intervals that hold the truth, in the right form."""
TOLD = 0.9
"""Asked share of wrong forms that are told, if they bias by more than one stated standard deviation."""


class Estimate(Protocol):
    """A file in `estimates`."""

    COMMAND: str
    """Command that prints the estimate."""
    FORMS: dict[str, str]
    """Forms of the data with their descriptions, `RIGHT` first."""

    def trial(self, form: str, rng: np.random.Generator) -> Trial:
        """One estimate from data of this form.

        Raises:
            PalpateError: the estimate refuses the data.
        """
        ...


def names() -> tuple[str, ...]:
    """Names of all estimates."""
    return tuple(sorted(one.name for one in pkgutil.iter_modules(estimates.__path__)))


def estimate(name: str) -> Estimate:
    """The estimate of this name.

    Raises:
        PalpateError: there is none.
    """
    if name not in names():
        raise PalpateError(f"there is no estimate {name!r}", mend=f"choose of {', '.join(names())}")
    return cast("Estimate", importlib.import_module(f"{estimates.__name__}.{name}"))


def judged(point: Point, seed: int) -> dict[str, float]:
    """One trial, for a sweep; a refusal counts as told.

    Raises:
        MissingExtraError: a package is missing, which says nothing about the data.
    """
    one = estimate(str(point["estimate"]))
    try:
        trial = one.trial(str(point["form"]), np.random.default_rng(seed))
    except MissingExtraError:
        raise
    except PalpateError:
        return {"inside": np.nan, "square": np.nan, "told": 1.0, "possible": np.nan}
    return {"inside": trial.inside, "square": trial.square, "told": float(trial.told), "possible": trial.possible}


@dataclass(frozen=True)
class Row:
    """One form of one estimate. The fields are the documented contract of ``--json``."""

    estimate: str
    command: str
    form: str
    description: str
    trials: int
    cover: float | None
    """Share of the answers whose interval or ellipsoid holds the truth; None if all were refused."""
    cover_95: tuple[float, float] | None
    """Its 95 % confidence interval (Clopper and Pearson 1934)."""
    bias: float | None
    """Root of the mean squared error over the stated variance, less one: 0 in the right form [standard deviations]."""
    told: float
    """Share of the trials that were refused, doubted or partly left out: false alarms in the right form."""
    possible: float | None
    """Share that the most powerful test would tell; None where no bound is known."""
    met: bool
    """The asked figures are met, as far as this number of trials can tell."""


def run(
    chosen: Sequence[str], trials: int, seed: int = 0, workers: int | None = None, folder: Path | None = None,
    console: Console | None = None,
) -> list[Row]:  # fmt: skip
    """Run the trials of some estimates.

    Args:
        chosen: their names.
        trials: number of trials of each form.
        seed: seed of all trials.
        workers: number of processes; default: one per core. 0: in this process.
        folder: journals of finished trials, from which a stopped run continues.
        console: for the progress.
    """
    rows = []
    for name in chosen:
        one = estimate(name)
        grid = {"estimate": Axis([name]), "form": Axis(list(one.FORMS)), "trial": Axis(range(trials))}
        swept = sweep(
            judged, grid, seed, "serial" if workers == 0 else "local", workers=workers or None, console=console,
            title=name, resume=None if folder is None else folder / f"{name}-{trials}.journal",
        )  # fmt: skip
        data = {
            key: np.asarray(swept.array(key), dtype=np.float64)[0] for key in ("inside", "square", "told", "possible")
        }
        for k, (form, description) in enumerate(one.FORMS.items()):
            rows.append(_row(name, one.COMMAND, form, description, *(data[key][k] for key in data)))
    return rows


def _row(
    name: str, command: str, form: str, description: str, inside: np.ndarray, square: np.ndarray, told: np.ndarray,
    possible: np.ndarray,
) -> Row:  # fmt: skip
    answered = np.isfinite(inside)
    cover = float(inside[answered].mean()) if answered.any() else None
    interval = None if cover is None else proportion(cover, int(answered.sum()))
    bias = float(np.sqrt(max(float(square[answered].mean()) - 1.0, 0.0))) if answered.any() else None
    share, bounded = float(told.mean()), possible[np.isfinite(possible)]
    bound = float(bounded.mean()) if len(bounded) else None
    if form == RIGHT:
        met = interval is not None and interval[0] <= ASKED[1] and interval[1] >= ASKED[0]
    else:
        met = bias is None or bias <= 1.0 or proportion(share, len(told))[1] >= TOLD
    return Row(name, command, form, description, len(told), cover, interval, bias, share, bound, met)


def table(rows: Sequence[Row]) -> Table:
    """The rows for a terminal."""
    from rich.table import Table

    out = Table(box=None, pad_edge=False)
    for head in ("estimate", "form", "n", "cover (95 %)", "bias [sd]", "told", ""):
        out.add_column(head, justify="left" if head in ("estimate", "form", "") else "right")
    for row in rows:
        cover = "refused" if row.cover is None else f"{row.cover:.3f}"
        if row.cover_95 is not None:
            cover += " ({:.3f}-{:.3f})".format(*row.cover_95)
        bias = "-" if row.bias is None else f"{row.bias:.2g}"
        told = f"{row.told:.3f}" if row.possible is None else f"{row.told:.3f} of {row.possible:.3f}"
        out.add_row(row.estimate, row.description, str(row.trials), cover, bias, told, "" if row.met else "not met")
    return out
