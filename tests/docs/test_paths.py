"""Every path of the repository that a page names exists, and every page that code names.

Checked are the links of each page, each word that begins with a folder of the repository
(`palpate/world/mesh/files.py`), and back-ticked names of source files (`tick.hpp`, `guidance/fixture.cpp`). `*` and
NAME stand for any text. CHANGELOG.md describes the past and is left out.
"""

import re
from fnmatch import fnmatchcase
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = (
    "core",
    "bindings",
    "palpate",
    "lab",
    "simulators",
    "models",
    "scenes",
    "examples",
    "docs",
    "tests",
    "tools",
    "ros2",
    ".ci",
)
FILES = sorted(
    str(path.relative_to(ROOT))
    for folder in FOLDERS
    for path in (ROOT / folder).rglob("*")
    if "__pycache__" not in path.parts
)
PAGES = sorted(
    p for p in [*ROOT.glob("*.md"), *(ROOT / f for f in FILES if f.endswith(".md"))] if p.name != "CHANGELOG.md"
)

_FOLDERS = "|".join(re.escape(folder) for folder in FOLDERS)
_LINK = re.compile(r"\]\(([^)#\s]+)[^)]*\)")
_PATH = re.compile(rf"(?<![\w/.*-])((?:{_FOLDERS})/[\w./*-]*)")
_SOURCE = re.compile(r"`([\w/*-]+\.(?:py|pyi|cpp|hpp|md))`")


def missing(text: str, page: Path) -> list[str]:
    """Names in the text of `page` that do not exist in the repository."""
    links = [name for name in _LINK.findall(text) if "://" not in name and not name.startswith("mailto:")]
    paths = [name.rstrip("/.") for name in _PATH.findall(text)]
    sources = [name for name in _SOURCE.findall(text) if name not in paths]
    lost = [name for name in links if not (page.parent / name).exists()]
    lost += [name for name in paths if not _known(name, FILES)]
    return lost + [name for name in sources if not (ROOT / name).exists() and not _known(f"*/{name}", FILES)]


def _known(name: str, files: list[str]) -> bool:
    pattern = name.replace("NAME", "*")
    return name in FOLDERS or any(fnmatchcase(file, pattern) for file in files)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_path_that_a_page_names_exists(page):
    assert missing(page.read_text(encoding="utf-8"), page) == []


def test_every_page_that_code_names_exists():
    """Messages and comments send their reader to pages."""
    named = {}
    for file in FILES:
        if file.endswith((".py", ".cpp", ".hpp", ".inl", ".yaml")) and not file.startswith("tests/"):
            for page in re.findall(r"docs/[\w/-]+\.md", (ROOT / file).read_text(encoding="utf-8")):
                named.setdefault(page, file)
    assert len(named) > 20
    assert {page: file for page, file in named.items() if not (ROOT / page).is_file()} == {}


def test_pages_are_found():
    assert {"README.md", "ARCHITECTURE.md", "json.md"} <= {page.name for page in PAGES}


def test_missing_paths_of_a_sample_page_are_found():
    page = """[a](docs/none.md) and [fine](README.md), [web](https://example.org/docs/none.md); `palpate/nowhere.py`, in
    palpate/world/mesh/nothing.py; `core/palpate/loop/tick.*`, `models/NAME.yaml`, `tick.hpp`, `loop/tick.hpp`,
    `judges.py`, the topic `/palpate/scene`, `scenes/none.yaml`: `palpate/arm`, `tests/none/`."""
    assert missing(page, ROOT / "PAGE.md") == [
        "docs/none.md",
        "docs/none.md",
        "palpate/nowhere.py",
        "palpate/world/mesh/nothing.py",
        "scenes/none.yaml",
        "tests/none",
        "judges.py",
    ]
