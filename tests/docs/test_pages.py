"""Each page has at most 1,500 words, and README.md links to it or to a page that links to it.

CHANGELOG.md and docs/history are left out: they grow with the product.
"""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGES = sorted(
    p for p in [*(ROOT / "docs").rglob("*.md"), *ROOT.glob("*.md")] if not {"CHANGELOG.md", "history"} & {*p.parts}
)
MOST_WORDS = 1500

_LINK = re.compile(r"\]\(([^)#\s]+\.md)[^)]*\)")


def linked(page: Path) -> set[Path]:
    """Pages to which a page links."""
    return {(page.parent / name).resolve() for name in _LINK.findall(page.read_text(encoding="utf-8"))}


def faults(page: Path, readme: Path) -> list[str]:
    """Messages for each rule that the page violates."""
    words = len(page.read_text(encoding="utf-8").split())
    found = [f"{words} words; at most {MOST_WORDS}"] if words > MOST_WORDS else []
    direct = linked(readme)
    reached = direct.union(*(linked(other) for other in direct if other.exists()))
    if page.resolve() not in reached and page != readme:
        found.append("not linked from README.md, nor from a page that README.md links")
    return found


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_page_is_short_and_linked(page):
    assert faults(page, ROOT / "README.md") == []


def test_pages_are_found():
    assert {"contact.md", "json.md", "run.md", "README.md", "ARCHITECTURE.md"} <= {page.name for page in PAGES}


def test_faults_of_sample_pages_are_found(tmp_path):
    readme = tmp_path / "README.md"
    readme.write_text("[a](near.md)")
    (tmp_path / "near.md").write_text("word " * 1498 + "[b](far.md) [c](self.md)")
    (tmp_path / "far.md").write_text("word [d](farther.md)")
    (tmp_path / "farther.md").write_text("word")
    (tmp_path / "lost.md").write_text("word " * 1501)
    found = {name: faults(tmp_path / f"{name}.md", readme) for name in ("near", "far", "farther", "lost")}
    assert (found["near"], found["far"]) == ([], [])
    assert found["farther"] == ["not linked from README.md, nor from a page that README.md links"]
    assert len(found["lost"]) == 2
    assert found["lost"][0].startswith("1501 words")
