"""The checks before a release, and what is left for a person to do.

    python tools/release.py [--quick]

Each check prints one line, and the exit code is 1 if one of them failed. --quick leaves out those that take minutes.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
LEFT = """\
left for a person:
  1. `make night` has no fault in docs/results/night.json
  2. one session with a person's hand on a real device, with its certificate
  3. tag v{version}, push it: .github/workflows/wheels.yml makes the wheels
  4. publish wheels, sdist, bill of materials and the site; enter the DOI in CITATION.cff"""


def version() -> str:
    """The version in pyproject.toml."""
    return str(tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"])


def same_version() -> str:
    """CITATION.cff and CHANGELOG.md name the version, and the changelog a date."""
    cited = re.search(r"^version: (.*)$", (ROOT / "CITATION.cff").read_text(encoding="utf-8"), re.M)
    if cited is None or cited[1] != version():
        return f"CITATION.cff names {cited[1] if cited else 'none'} instead of {version()}"
    heading = f"## {version()} ("
    line = next(
        (one for one in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8").splitlines() if one.startswith(heading)), ""
    )
    return (
        ""
        if re.search(r"\d{4}-\d\d-\d\d", line)
        else f"CHANGELOG.md has no date for {version()}: {line or 'no heading'}"
    )


def clean_tree() -> str:
    """Nothing is uncommitted."""
    return " ".join(command("git", "status", "--porcelain").stdout.split()[:6])


def generated_files() -> str:
    """Schema and stubs are those of the sources."""
    made = command(sys.executable, "-m", "palpate", "schema").stdout
    kept = (ROOT / "docs" / "scene.schema.json").read_text(encoding="utf-8")
    return (
        ""
        if json.loads(made) == json.loads(kept)
        else "docs/scene.schema.json: palpate schema --out docs/scene.schema.json"
    )


def licences() -> str:
    """Every package of the core states a licence."""
    found = json.loads(command(sys.executable, "-m", "palpate", "licenses", "--json", "-").stdout)["components"]
    silent = [one["name"] for one in found if not one["licence"] and one["needed_by"] == "core"]
    return ", ".join(silent)


def lint() -> str:
    """make lint passes."""
    return last_line(command("make", "lint"))


def tests() -> str:
    """make test passes."""
    return last_line(command("make", "test"))


def wheel() -> str:
    """The wheel is built, installed into an empty environment, and feels an organ."""
    return last_line(command(sys.executable, "-m", "pytest", "-q", "tests/package/test_wheel.py"))


def site() -> str:
    """The site is built without a dead link."""
    return last_line(command("make", "site"))


QUICK: tuple[Callable[[], str], ...] = (same_version, clean_tree, generated_files, licences)
LONG: tuple[Callable[[], str], ...] = (lint, tests, wheel, site)


def command(*words: str) -> subprocess.CompletedProcess[str]:
    """Run a command at the root."""
    return subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False)


def last_line(run: subprocess.CompletedProcess[str]) -> str:
    """Empty if the command succeeded; otherwise the last line of what it said."""
    if run.returncode == 0:
        return ""
    return next(iter(reversed((run.stdout + run.stderr).strip().splitlines())), f"exit code {run.returncode}")


def main(arguments: list[str]) -> int:
    """Run the checks; returns 1 if one failed."""
    failed = 0
    for check in (*QUICK, *(() if "--quick" in arguments else LONG)):
        fault = check()
        failed += bool(fault)
        purpose = (check.__doc__ or "").rstrip(".")
        print(f"{'FAILED' if fault else 'ok    '}  {purpose}{f': {fault}' if fault else ''}", flush=True)
    print(LEFT.format(version=version()))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
