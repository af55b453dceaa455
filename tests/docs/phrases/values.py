"""Types of the phrases, and formats that several pages use."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, NamedTuple

from palpate.base.arrays.intervals import proportion

RESULTS = Path(__file__).resolve().parents[3] / "docs" / "results"
Result = dict[str, Any]
Maker = Callable[[Result], list[str]]


class Tie(NamedTuple):
    """A page, the kept result that it quotes, and what computes phrases of the page from the result."""

    page: str
    result: str
    makers: tuple[Maker, ...]


def kept(name: str) -> Result:
    """The kept result of this name."""
    found: Result = json.loads((RESULTS / f"{name}.json").read_text(encoding="utf-8"))
    return found


def control(name: str) -> str:
    """The speed of the machine when this result was made."""
    return f"an import of numpy: {kept(name)['control_numpy_import_s']:.2f} s"


def mj(joules: float) -> str:
    """An energy in mJ with three significant digits."""
    return f"{float(f'{1e3 * joules:.3g}'):,.{max(0, 2 - int(math.log10(abs(1e3 * joules)) // 1))}f}"


def percent(share: float, sign: str = "") -> str:
    """A share in whole percent, without the sign of zero."""
    return f"{round(100.0 * share) + 0:{sign}d}"


def least(k: int, n: int) -> str:
    """Lower 95 % limit of k of n (Clopper and Pearson)."""
    return f"{100.0 * proportion(k / n, n)[0]:.1f} %"


def most(k: int, n: int, digits: int = 1) -> str:
    """Upper 95 % limit of k of n (Clopper and Pearson)."""
    return f"{100.0 * proportion(k / n, n)[1]:.{digits}f} %"


def both(k: int, n: int) -> str:
    """95 % interval of k of n (Clopper and Pearson)."""
    low, high = proportion(k / n, n)
    return f"{100.0 * low:.1f} to {100.0 * high:.1f} %"


def rows_by(rows: Iterable[Result], *keys: str) -> dict[Any, Result]:
    """The rows by the values of their keys."""
    return {tuple(row[key] for key in keys) if len(keys) > 1 else row[keys[0]]: row for row in rows}
