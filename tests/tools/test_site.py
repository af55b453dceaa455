"""The site has every page once, and the files to which pages link; built where its tools are installed."""

import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def tool():
    spec = importlib.util.spec_from_file_location("site_tool", ROOT / "tools" / "site.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def copied(tool, pages):
    for page in [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")]:
        tool.copy(page, pages)
    tool.examples(pages)
    tool.reference(pages)


def test_every_page_is_in_the_navigation_once(tool, tmp_path):
    copied(tool, tmp_path)
    names = [name for part in tool.navigation(tmp_path) for pages in part.values() for name in pages]
    assert sorted(names) == sorted(str(page.relative_to(tmp_path)) for page in tmp_path.rglob("*.md"))
    assert {"index.md", "docs/ros2.md", "api/Session.md", "examples/index.md"} <= set(names)


def test_a_page_that_no_part_names_is_told(tool, tmp_path):
    copied(tool, tmp_path)
    (tmp_path / "STRAY.md").write_text("# A page\n")
    with pytest.raises(SystemExit, match="add to NAVIGATION: STRAY"):
        tool.navigation(tmp_path)


def test_links_lead_to_files_that_are_copied(tool, tmp_path):
    tool.copy(ROOT / "README.md", tmp_path)
    assert (tmp_path / "docs" / "images" / "palpation.png").is_file()
    assert "](examples/index.md)" in (tmp_path / "index.md").read_text()


def test_every_page_that_a_page_links_exists(tool, tmp_path):
    copied(tool, tmp_path)
    lost = []
    for page in tmp_path.rglob("*.md"):
        links = [found[1] for found in tool._LINK.findall(page.read_text(encoding="utf-8")) if found[1].endswith(".md")]
        lost += [(page.name, link) for link in links if "://" not in link and not (page.parent / link).exists()]
    assert lost == []


@pytest.mark.long
def test_the_site_is_built_and_a_dead_link_is_an_error(tool, tmp_path, monkeypatch):
    pytest.importorskip("mkdocs", reason="make site")
    assert subprocess.run([sys.executable, ROOT / "tools" / "site.py", tmp_path / "site"], check=False).returncode == 0
    assert (tmp_path / "site" / "docs" / "ros2.html").is_file()
    assert "Session" in (tmp_path / "site" / "api" / "Session.html").read_text()
    monkeypatch.setattr(
        tool, "reference", lambda pages: (pages / "CHANGELOG.md").write_text("# a\n\n[b](nowhere.md)\n")
    )
    assert tool.main(tmp_path / "broken") != 0
