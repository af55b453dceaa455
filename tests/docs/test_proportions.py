"""Sections that count successes of n trials, or give a share of trials, state the interval that n allows."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGES = [*sorted((ROOT / "docs").rglob("*.md")), ROOT / "README.md"]
#: Pages whose counts are of everything there is, or no trials.
WHOLE = {
    "demonstrations.md": "episodes before a kill",
    "haply.md": "all messages of a library's tests",
    "paper.md": "all items of the paper",
    "platforms.md": "files of the sources",
}
_UNIT = r"(?:m|s|N|Pa|kPa|mm|ms|g|kg|Hz|cm|deg|um|MB|GB|mJ|ticks)"
_NUMBER = r"\d[\d,.]*"
_COUNT = re.compile(
    rf"\b(?:\d[\d,]*|[Nn]one|[Nn]o|[Aa]ll) of (?:the |these |all )?(\d[\d,]*)\b(?! {_UNIT}\b)(?![.,:/]\d)"
)
#: What is drawn at random in a study. Ticks and answers of one run are not: they are missed in bursts.
_TRIALS = (
    "run|session|trial|hand|operator|case|interval|scene|loop|device|set|lump|place|press|registration|task|organ|route"
    "|plan|query|check|pose|image|seed|presses|cases|recording|form"
)
_SHARE = re.compile(
    rf"({_NUMBER})(?:(?: to |-| and |, ){_NUMBER})* ?% of "
    rf"(?:the |all |these |those |such |clean |simulated |{_NUMBER} )*(?:{_TRIALS})s?\b"
)
_INTERVAL = re.compile(
    rf"Clopper|\({_NUMBER} ?(?:to|-) ?{_NUMBER} ?%|at (?:least|most) {_NUMBER} ?%|{_NUMBER} \+- ?{_NUMBER} ?%"
)
_ASKED = ("95", "99")  # levels of an interval or of a quantile


def claims(section: str) -> list[str]:
    """Counts of ten or more trials and shares of trials."""
    counts = [found[0] for found in _COUNT.finditer(section) if int(found[1].replace(",", "")) >= 10]
    return counts + [found[0] for found in _SHARE.finditer(section) if found[1] not in _ASKED]


def without_interval(page: str) -> list[str]:
    """Claims in sections of a page that state no interval; one that another section judges counts as judged."""
    sections = [" ".join(section.split()) for section in re.split(r"(?m)^(?=#)", page)]
    judged = [section for section in sections if "Clopper" in section]
    bad = [claim for one in sections if not _INTERVAL.search(one) for claim in claims(one)]
    return [claim for claim in bad if not any(claim in section for section in judged)]


def test_sections_with_proportions_have_their_intervals():
    bad = {page.name: without_interval(page.read_text(encoding="utf-8")) for page in PAGES}
    assert {name: found for name, found in bad.items() if found and name not in WHOLE} == {}
    assert set(WHOLE) <= {name for name, found in bad.items() if found}, "no exception without a use"


@pytest.mark.parametrize(
    ("text", "claim"),
    [("It found 26 of 30 lumps.", "26 of 30"), ("In 10,000 runs none of 10,000 fell below.", "none of 10,000"),
     ("# A\n26 of 30 is at least 69.3 % (Clopper and Pearson).\n# B\n9 of 10 pass.", "9 of 10"),
     ("The guard acts in 30 % of the runs.", "30 % of the runs"),
     ("Such intervals miss the truth in 10 to 20 % of\nthe cases.", "10 to 20 % of the cases")],
)  # fmt: skip
def test_a_proportion_without_interval_is_found(text, claim):
    assert without_interval(text) == [claim]


@pytest.mark.parametrize(
    "text",
    ["26 of 30 is at least 69.3 % (Clopper and Pearson).", "It missed 0 of 8,136 ticks.", "3 of 4 tasks",
     "# A\n20 of 20 (at least 83 %)\n", "160 to 290 of 300 s, a delay of 5 of 20 mm", "30 % of the runs (29 to 31 %)",
     "# A\n20 of 20\n# B\n20 of 20 is at least 83.2 % (Clopper and Pearson)", "95 % of the hands"],
)  # fmt: skip
def test_what_is_no_proportion_or_has_its_interval_is_passed(text):
    assert without_interval(text) == []
