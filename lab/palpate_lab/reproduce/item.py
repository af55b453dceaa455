"""An item of the paper (figure, table, equation or algorithm), and the outcome of making it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from palpate.base.plotting.style import Canvas

Verdict = Literal["agrees", "differs", "not testable without the robot", "not made"]
"""agrees: the claim holds within the stated tolerance; differs: it does not, and `why` says the reason; not made: a
program or package that the item needs is absent."""

VERDICTS: tuple[Verdict, ...] = ("agrees", "differs", "not testable without the robot", "not made")

Values = Mapping[str, Any]
"""Plain values by name; the names contain the units."""


@dataclass(frozen=True)
class Work:
    """What an item gets for its computation."""

    seed: int
    """Seed of all random numbers."""
    folder: Path
    """Folder for intermediate files; removed afterwards."""
    workers: int | None = None
    """Processes of sweeps; None: one per core."""


@dataclass(frozen=True)
class Drawing:
    """A picture of an item, written as PNG and SVG."""

    name: str
    """Suffix of the file name, empty for the only picture."""
    caption: str
    draw: Callable[[Canvas], Figure]


@dataclass(frozen=True)
class Outcome:
    """The result of an item."""

    verdict: Verdict
    value: Values
    """Our figures."""
    paper: Values | str
    """What the paper prints, in the same terms."""
    why: str
    """One or two sentences: why this verdict."""
    data: Sequence[Mapping[str, Any]] = ()
    """Rows of the CSV file."""
    drawings: Sequence[Drawing] = ()
    table: str = ""
    """Additional HTML for the page: a table or a diagram."""
    lacks: str = ""
    """A program or package that was absent and replaced; the next run makes the item anew. Empty: none was."""


@dataclass(frozen=True)
class Item:
    """A claim of the paper, and the function that makes our side of it."""

    name: str
    title: str
    section: str
    """Section and number in the paper."""
    claim: str
    """What the paper shows or says, in our words."""
    make: Callable[[Work], Outcome]
    rows: tuple[str, ...] = ()
    """Rows of docs/requirements.md that it shows."""
    reading: str = ""
    """The reading taken where the paper is ambiguous; empty if it is not."""
    code: tuple[str, ...] = ()
    """Files of the repository that hold the computation."""
    later: str = ""
    """What the authors' later published code adds; empty if nothing."""
