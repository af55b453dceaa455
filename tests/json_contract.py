"""The keys that the pages of docs/json document, read from the pages themselves."""

import re
from pathlib import Path

PAGES = sorted((Path(__file__).resolve().parents[1] / "docs" / "json").glob("*.md"))


def keys(command: str) -> set[str]:
    """First column of the table of a command."""
    section = _section(command)
    return {key for row in re.findall(r"^\| (`[^|]*) \|", section, re.M) for key in re.findall(r"`(\w+)`", row)}


def keys_of(command: str, start: str) -> set[str]:
    """Keys of the paragraph with this start in a command's section."""
    paragraph = next(p for p in _section(command).split("\n\n") if p.startswith(start))
    return set(re.findall(r"`(\w+)`", paragraph.removeprefix(start))) - {"control_"}


def _section(command: str) -> str:
    sections = [section for page in PAGES for section in page.read_text(encoding="utf-8").split("\n## ")[1:]]
    (found,) = (s for s in sections if f"`palpate {command}`" in s.splitlines()[0])
    return found
