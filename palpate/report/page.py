"""Writes the file of a report."""

from __future__ import annotations

from pathlib import Path

from palpate.base.errors import OutputError


def write(page: Path, text: str) -> Path:
    """Write the page; returns its file.

    Raises:
        OutputError: the file cannot be written.
    """
    try:
        page.write_text(text, encoding="utf-8")
    except OSError as error:
        why = error.strerror or str(error)
        raise OutputError(f"the report cannot be written: {why}", where=str(page), mend="use --out") from None
    return page
