"""The figures of an item in words: their names with the units behind the numbers, rows as tables."""

from __future__ import annotations

import re
from collections.abc import Mapping
from html import escape
from typing import Any

_UNITS = {
    "N_s_per_m": "N s/m", "N_per_m": "N/m", "mm": "mm", "um": "µm", "m_s": "m/s", "m": "m", "deg": "°", "mN": "mN",
    "Nm": "N m", "N": "N", "Hz": "Hz", "kg": "kg", "ms": "ms", "s": "s", "percent": "%",
}  # fmt: skip
_MOST = 12
"""Longest list or table; longer ones are left to the CSV file."""
_WIDEST = 8
"""Most columns of a table."""


def values(given: Any) -> str:
    """HTML of the figures of one side: a sentence, or a list of named values."""
    if not isinstance(given, Mapping):
        return f"<p><i>{prose(str(given))}</i></p>"
    lines = "".join(f"<li>{line}</li>" for name, x in given.items() if (line := _line(str(name), x)))
    return f"<ul>{lines}</ul>" if lines else ""


def prose(text: str) -> str:
    """HTML of a text, with code between backticks."""
    return re.sub(r"`([^`]+)`", r"<code>\1</code>", escape(text))


def label(name: str) -> tuple[str, str]:
    """A name in words, and its unit: ``tip_off_mm`` is (tip off, mm). A name with blanks or symbols stays as it is."""
    if not re.fullmatch(r"[\w.]+", name) or "_" not in name or not name.isascii():
        return name, ""
    stem, unit = next(
        ((name.removesuffix(f"_{key}"), shown) for key, shown in _UNITS.items() if name.endswith(f"_{key}")), (name, "")
    )
    if stem[-1:].isdigit():  # the unit is that of this number, as in within_20_percent
        stem, unit = name, ""
    return stem.replace("_", " "), unit


def _line(name: str, value: Any) -> str:
    """A named value, as text, list or table; empty if it is too long."""
    words, unit = label(name)
    if isinstance(value, Mapping):
        inner = "".join(f"<li>{line}</li>" for key, x in value.items() if (line := _line(str(key), x)))
        return (
            f"{escape(words)}{f' [{unit}]' if unit else ''}:<ul>{inner}</ul>" if inner and len(value) <= _MOST else ""
        )
    if isinstance(value, list) and value and all(isinstance(row, Mapping) for row in value):
        return f"{escape(words)}: {_table(value)}" if len(value) <= _MOST and len(value[0]) <= _WIDEST else ""
    text = _text(value)
    return f"{escape(words)}: {text}{'' if unit in ('', '°') else ' '}{unit}" if text is not None else ""


def _table(rows: list[Mapping[str, Any]]) -> str:
    columns = [label(str(name)) for name in rows[0]]
    head = "".join(f"<th>{escape(words)}{f' [{unit}]' if unit else ''}</th>" for words, unit in columns)
    body = "".join(
        "<tr>" + "".join(f"<td>{_text(row[name]) or '' if name in row else ''}</td>" for name in rows[0]) + "</tr>"
        for row in rows
    )  # fmt: skip
    return f'<div class="scroll"><table><tr>{head}</tr>{body}</table></div>'


def _text(value: Any) -> str | None:
    """A value in a few characters; None for what is too long."""
    if isinstance(value, bool) or value is None:
        return {True: "yes", False: "no", None: "none"}[value]
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, (int, str)):
        return escape(str(value))
    if isinstance(value, list):
        parts = [_text(x) for x in value]
        return None if len(parts) > 8 or any(p is None for p in parts) else ", ".join(map(str, parts)) or "none"
    return None
