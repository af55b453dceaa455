"""The keys that docs/json.md promises, read from the page itself."""

import re
from pathlib import Path

PAGE = Path(__file__).resolve().parents[1] / "docs" / "json.md"


def keys(command: str) -> set[str]:
    """First column of the table of a command."""
    section = _section(command)
    return {key for row in re.findall(r"^\| (`[^|]*) \|", section, re.M) for key in re.findall(r"`(\w+)`", row)}


def keys_of(command: str, start: str) -> set[str]:
    """Keys of the paragraph of a command's section that starts so."""
    paragraph = next(p for p in _section(command).split("\n\n") if p.startswith(start))
    return set(re.findall(r"`(\w+)`", paragraph.removeprefix(start))) - {"control_"}


def _section(command: str) -> str:
    return next(s for s in PAGE.read_text().split("\n## ") if f"`palpate {command}`" in s.splitlines()[0])
