"""Makes docs/requirements.md from docs/requirements.yaml: `python tools/requirements.py`.

A test fails when a command of the table does not run (tests/docs/test_requirement_commands.py), another one when a
command, test or page does not exist (tests/docs/test_requirements.py).
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parents[1]
TABLE = ROOT / "docs" / "requirements.yaml"
PAGE = ROOT / "docs" / "requirements.md"
STATES = ("done", "part", "robot", "open")

_HEAD = """\
# Which of the paper's systems, equations and plans work?

{counts}. R1 to R65 are the paper's (Munawar and Fischer 2016), B1 to B12 go beyond it; everything is simulated unless a
page says otherwise. `part`: some is open; `robot`: needs the robot. [paper.md](paper.md) sets the figures beside the
paper. Made by `python tools/requirements.py`; tests run each command in its shortest form and look for each test and
page.

|row|what|state|`palpate`|test|page|
|-|-|-|-|-|-|
"""


@dataclass(frozen=True)
class Requirement:
    """A row of the table; an open one has no command, test and page."""

    row: str
    what: str
    state: str
    command: str = ""
    test: str = ""
    page: str = ""


def rows() -> list[Requirement]:
    """All rows, in the order of the file."""
    data = yaml.safe_load(TABLE.read_text(encoding="utf-8"))
    return [Requirement(name, *map(str, values)) for name, values in data.items()]


def page() -> str:
    """Text of the page."""
    found = rows()
    counts = Counter(one.state for one in found)
    words = ", ".join(f"{counts[state]} {state}" for state in STATES if counts[state])
    return _HEAD.format(counts=f"{len(found)} rows: {words}") + "".join(f"{_line(one)}\n" for one in found)


def _line(r: Requirement) -> str:
    if not r.command:
        return f"|{r.row}|{r.what}|{r.state}||||"
    return f"|{r.row}|{r.what}|{r.state}|`{r.command}`|[{Path(r.test).stem}](../tests/{r.test})|[{r.page}]({r.page})|"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    print(PAGE)
