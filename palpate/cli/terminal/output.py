"""Terminal output and output files of the commands."""

from __future__ import annotations

import json
import sys
from pathlib import Path

from rich.console import Console

from palpate.base.errors import OutputError


def console_for(json: Path | None) -> Console:
    """The console for messages: the standard error when the JSON goes to the standard output."""
    console = Console(stderr=str(json) == "-", highlight=False)
    if not console.is_terminal:
        console.width = max(console.width, 120)
    return console


def say(console: Console, text: str, label: str = "", style: str = "") -> None:
    """Print text without markup or wrapping, after a coloured label."""
    if label:
        console.print(label, style=style, end=" ", markup=False)
    console.print(text, soft_wrap=True, markup=False)


def write_text(path: Path, text: str) -> None:
    """Write a small file.

    Raises:
        OutputError: the file cannot be written.
    """
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise _refusal(path, error) from None


def write_json(path: Path | None, values: object) -> None:
    """Write a JSON contract of docs/json.md to a file, to the standard output (-), or nowhere (None).

    Args:
        path: where to write.
        values: dictionaries, lists and dataclasses of numbers and texts; a dataclass is written as its fields.
    """
    if path is None:
        return
    from palpate.base.arrays.plain import plain

    text = json.dumps(plain(values), indent=2, allow_nan=False) + "\n"
    if str(path) == "-":
        sys.stdout.write(text)
    else:
        write_text(path, text)


def require_writable(path: Path | None) -> None:
    """Check before the work begins that a file can be written at its end.

    Raises:
        OutputError: the file cannot be written.
    """
    if path is None or str(path) == "-":
        return
    try:
        existed = path.exists()
        with path.open("a", encoding="utf-8"):
            pass
        if not existed:  # interrupted work shall leave no empty file
            path.unlink()
    except OSError as error:
        raise _refusal(path, error) from None


def make_folder(folder: Path) -> None:
    """Create a folder before the work begins, for files that are written at its end.

    Raises:
        OutputError: the folder cannot be created.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise _refusal(folder, error) from None


def _refusal(path: Path, error: OSError) -> OutputError:
    why = error.strerror or str(error)
    return OutputError("the file cannot be written", where=str(path), why=why, mend="choose another place")
