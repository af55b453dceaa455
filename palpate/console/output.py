"""Where commands write their files."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from rich.console import Console

from palpate.errors import OutputError


def console_for(json: Path | None) -> Console:
    """Where a command talks to people: the standard error when its JSON takes the standard output."""
    console = Console(stderr=str(json) == "-", highlight=False)
    if not console.is_terminal:
        console.width = max(console.width, 120)
    return console


def say(console: Console, text: str, label: str = "", style: str = "") -> None:
    """Print text as it is, long lines whole, after a coloured label."""
    if label:
        console.print(label, style=style, end=" ", markup=False)
    console.print(text, soft_wrap=True, markup=False)


def write_text(path: Path, text: str) -> None:
    """Write a small file.

    Raises:
        OutputError: it cannot be written.
    """
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise _refusal(path, error) from None


def write_json(path: Path | None, values: Any) -> None:
    """Write a JSON contract of docs/json.md to a file, to the standard output (-), or nowhere (None)."""
    if path is None:
        return
    text = json.dumps(values, indent=2, allow_nan=False) + "\n"
    if str(path) == "-":
        sys.stdout.write(text)
    else:
        write_text(path, text)


def require_writable(path: Path | None) -> None:
    """Try a file that will be written at the end, before the work begins.

    Raises:
        OutputError: it cannot be written.
    """
    if path is None or str(path) == "-":
        return
    try:
        there = path.exists()
        with path.open("a", encoding="utf-8"):
            pass
        if not there:  # nothing is left of work that is interrupted
            path.unlink()
    except OSError as error:
        raise _refusal(path, error) from None


def make_folder(folder: Path) -> None:
    """Make a folder for files that will be written at the end, before the work begins.

    Raises:
        OutputError: it cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise _refusal(folder, error) from None


def _refusal(path: Path, error: OSError) -> OutputError:
    why = error.strerror or str(error)
    return OutputError("the file cannot be written", where=str(path), why=why, mend="choose another place")
