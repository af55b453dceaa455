"""Pages that count successes of n trials state the interval that n allows (Clopper and Pearson)."""

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGES = [*sorted((ROOT / "docs").glob("*.md")), ROOT / "README.md"]
#: Pages whose counts are of everything there is, or no trials.
WHOLE = {
    "demonstrations.md": "episodes before a kill",
    "paper.md": "all items of the paper",
    "platforms.md": "files of the sources",
}
_UNIT = r"(?:m|s|N|Pa|kPa|mm|ms|g|kg|Hz|cm|deg|um|MB|GB|mJ)"
_COUNT = re.compile(
    rf"\b(?:\d[\d,]*|[Nn]one|[Nn]o|[Aa]ll) of (?:the |these |all )?(\d[\d,]*)\b(?! {_UNIT}\b)(?![.:/]\d)"
)


def counts_without_interval(text: str) -> list[str]:
    """Counts of ten or more trials in a text that names no interval of a proportion."""
    if "Clopper" in text:
        return []
    return [found[0] for found in _COUNT.finditer(text) if int(found[1].replace(",", "")) >= 10]


def test_pages_with_counts_have_their_intervals():
    bad = {page.name: counts_without_interval(page.read_text(encoding="utf-8")) for page in PAGES}
    assert {name for name, found in bad.items() if found} == set(WHOLE)


def test_a_count_without_interval_is_found():
    assert counts_without_interval("It found 26 of 30 lumps.") == ["26 of 30"]
    assert counts_without_interval("In 10,000 runs none of 10,000 fell below.") == ["none of 10,000"]
    assert counts_without_interval("26 of 30 is at least 69.3 % (Clopper and Pearson).") == []
    assert counts_without_interval("160 to 290 of 300 s, a delay of 5 of 20 mm, 3 of 4 tasks") == []
