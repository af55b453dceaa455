"""Figures on the pages are those of the results kept in docs/results (written by tools/results.py).

The folder `phrases` ties them: each of its functions computes phrases from a result, and the page must contain them.
"""

import json
import re
from pathlib import Path

import pytest
from phrases import TIES
from phrases.values import RESULTS, Tie, kept

DOCS = Path(__file__).resolve().parents[2] / "docs"
NAMES = sorted({tie.result for tie in TIES})
KEPT = {path.stem for path in RESULTS.glob("*.json")}
CHECKED = [tie for tie in TIES if tie.result in KEPT]

_NUMBER = re.compile(r"none|\d+(?:[.,]\d+)*")


def missing(page: str, phrases: list[str]) -> list[str]:
    """The phrases that are not on the page; line breaks are spaces, `\\|.*\\|` stands for columns of other runs."""
    text = " ".join(page.split())
    parts = {phrase: re.escape(phrase).replace(re.escape(r"\|.*\|"), r"\|[^|]*\|[^|]*\|") for phrase in phrases}
    return [phrase for phrase, part in parts.items() if not re.search(rf"(?<![\w.,]){part}(?![.,]?\d)", text)]


def page_of(tie: Tie) -> str:
    return (DOCS / tie.page).read_text(encoding="utf-8")


def changed(phrase: str) -> list[str]:
    """The phrase with another last digit, once for each of its numbers."""
    found = []
    for number in _NUMBER.finditer(phrase):
        text, last = number[0], number.end() - 1
        other = "5" if text == "none" else text[:-1] + str((int(phrase[last]) + 1) % 10)
        found.append(phrase[: number.start()] + other + phrase[number.end() :])
    return found


@pytest.mark.parametrize("name", NAMES)
def test_the_result_of_a_page_is_kept(name):
    if name not in KEPT:
        pytest.skip(f"run: python tools/results.py {name}")


@pytest.mark.parametrize(("tie", "maker"), [(tie, maker) for tie in CHECKED for maker in tie.makers])
def test_pages_have_the_figures_of_the_kept_results(tie, maker):
    phrases = maker(kept(tie.result)["result"])
    assert phrases
    assert missing(page_of(tie), phrases) == []


@pytest.mark.parametrize("tie", CHECKED, ids=lambda tie: f"{tie.page}-{tie.result}")
def test_a_figure_that_differs_is_found(tie):
    """The page has no phrase in which a number has another last digit."""
    text, result = page_of(tie), kept(tie.result)["result"]
    for maker in tie.makers:
        for phrase in maker(result):
            assert changed(phrase), phrase
            assert missing(text, changed(phrase)) == changed(phrase), phrase


def test_a_number_is_found_as_a_whole():
    page = "It takes 12.5 ms, at most 130 mm; 1,024 runs."
    assert missing(page, ["12.5 ms", "130 mm", "1,024 runs"]) == []
    wrong = ["2.5 ms", "12", "12.5", "13", "30 mm", "024 runs"]
    assert missing(page, wrong) == ["2.5 ms", "12", "13", "30 mm", "024 runs"]


NIGHT = "night"
"""State of `make night`, which many commits may have written: tests/tools/test_night.py judges it."""


@pytest.mark.parametrize(
    "path", [p for p in sorted(RESULTS.glob("*.json")) if p.stem != NIGHT], ids=lambda path: path.stem
)
def test_a_result_says_how_to_repeat_it(path):
    found = json.loads(path.read_text(encoding="utf-8"))
    assert found["command"].startswith("palpate ")
    assert re.fullmatch(r"[0-9a-f]{12}\+?", found["commit"])
    assert found["control_numpy_import_s"] > 0.0
    assert isinstance(found["seed"], int)
    assert path.stem in NAMES, "no page is compared with it"


CONFESSIONS = ("in no command", "not part of any command", "run once", "simulated once", "measured once by hand")


def confessions(page: str) -> list[str]:
    """Words by which a page says that no command gives its numbers."""
    text = " ".join(page.lower().split())
    return [words for words in CONFESSIONS if words in text]


@pytest.mark.parametrize("path", sorted(DOCS.rglob("*.md")), ids=lambda path: str(path.relative_to(DOCS)))
def test_no_number_comes_from_no_command(path):
    assert confessions(path.read_text(encoding="utf-8")) == []


def test_confessions_of_a_sample_page_are_found():
    assert confessions("The table (simulated\nonce, not part of any command).") == [
        "not part of any command",
        "simulated once",
    ]
