"""Prints the layers of the Python package, lowest last, and fails when an import goes up (pyproject.toml)."""

import sys
import tomllib
from pathlib import Path

from importlinter.cli import lint_imports

ROOT = Path(__file__).resolve().parents[1]


def main() -> int:
    """Print the layers and run import-linter; returns its exit code."""
    config = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"]
    layers = config["contracts"][0]["layers"]
    print("\n".join(f"{floor:3}  {layer}" for floor, layer in reversed(list(enumerate(reversed(layers), 1)))))
    return int(lint_imports(str(ROOT / "pyproject.toml"), no_cache=True, no_logo=True))


if __name__ == "__main__":
    sys.exit(main())
