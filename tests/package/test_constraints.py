"""constraints.txt has one exact version of every package of pyproject.toml, within its range, and no address.

A failure says that the file is stale: `make constraints` writes it anew.
"""

import re
import sys
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).resolve().parents[2]


def declared(project):
    """All requirements of a parsed pyproject.toml, with extras and groups."""
    extras, groups = project["project"]["optional-dependencies"], project["dependency-groups"]
    lists = [project["project"]["dependencies"], *extras.values(), *groups.values()]
    found = [Requirement(line) for lines in lists for line in lines if isinstance(line, str)]
    return [need for need in found if need.name != project["project"]["name"]]  # an extra may join others


def pinned(text):
    """Requirements of the lines of a constraints file."""
    return [Requirement(line) for line in text.splitlines() if line.strip() and not line.startswith("#")]


def problems(project, text):
    """What is wrong with a constraints file, in words."""
    pins = pinned(text)
    found = [f"{pin}: no exact version" for pin in pins if not re.fullmatch(r"==[\w.+!]+", str(pin.specifier))]
    found += ["an address"] if re.search(r"://|@ ", text) else []
    versions = {}
    for pin in pins:
        if pin.marker is None or pin.marker.evaluate():
            versions.setdefault(canonicalize_name(pin.name), []).append(str(pin.specifier).removeprefix("=="))
    found += [f"{name}: {' and '.join(several)}" for name, several in versions.items() if len(several) > 1]
    for need in declared(project):
        if need.marker is not None and not need.marker.evaluate():
            continue
        version = versions.get(canonicalize_name(need.name), [None])[0]
        if version is None:
            found.append(f"{need.name} is missing")
        elif not need.specifier.contains(version, prereleases=True):
            found.append(f"{need.name} {version} is not within {need.specifier}")
    return found


PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
TEXT = (ROOT / "constraints.txt").read_text()


def test_constraints_fit_the_project():
    assert problems(PROJECT, TEXT) == [], "run: make constraints"


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        (r"numpy==[\d.]+", "numpy>=2", "no exact version"),
        (r"numpy==[\d.]+", "numpy==1.20", "numpy 1.20 is not within"),
        (r"(?m)^tyro==.*\n", "", "tyro is missing"),
        (r"(?m)^tyro==(.*)$", r"tyro==\1\ntyro==1.0.1", " and 1.0.1"),
        (r"(?m)^tyro==.*$", "tyro @ https://example.org/tyro.whl", "an address"),
        (r"(?m)^import-linter==.*\n", "", "import-linter is missing"),
    ],
)
def test_the_judge_finds_each_kind_of_stale_file(old, new, told):
    text = re.sub(old, new, TEXT)
    assert text != TEXT
    assert any(told in problem for problem in problems(PROJECT, text))


def test_the_makefile_names_the_versions_of_python_that_the_project_allows():
    low, high = re.fullmatch(r">=3\.(\d+),<3\.(\d+)", PROJECT["project"]["requires-python"]).groups()
    makefile = (ROOT / "Makefile").read_text()
    assert f"(3, {low}) <= v < (3, {high})" in makefile
    assert f"needs 3.{low} to 3.{int(high) - 1}" in makefile
    assert (3, int(low)) <= sys.version_info[:2] < (3, int(high))
