"""The panel of rates: rate, lateness and age of every loop and source of a running session."""

from __future__ import annotations

import time
from collections.abc import Callable
from html import escape

import viser

from palpate.session.rates import Rate, cells

_HEAD = ("loop or source", "rate", "late p99", "missed", "age")
PERIOD = 1.0
"""Period of the panel [s]."""


class RatesPanel:
    """A table with one row per loop and source, renewed once a second."""

    def __init__(self, gui: viser.GuiApi, rates: Callable[[], list[Rate]]) -> None:
        self._rates, self._due = rates, 0.0
        self._table = gui.add_html("")

    def show(self) -> None:
        """Renews the table when it is due."""
        now = time.monotonic()
        if now < self._due:
            return
        self._due = now + PERIOD
        head = "".join(f'<th style="text-align:left;padding-right:6px">{text}</th>' for text in _HEAD)
        body = "".join(
            f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in cells(rate))}</tr>" for rate in self._rates()
        )
        self._table.content = (
            f'<div style="padding:6px 10px;font-size:12px" id="palpate-rates"><table style="width:100%">'
            f"<tr>{head}</tr>{body}</table></div>"
        )
