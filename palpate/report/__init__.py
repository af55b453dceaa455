"""Reports on a run: the summary table and the HTML page."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from palpate.report.html import report, write_report

__all__ = ["report", "write_report"]


def __getattr__(name: str) -> Any:
    """Imports the page on first use, as the summary of a run does not need it."""
    if name in __all__:
        from palpate.report import html

        return getattr(html, name)
    raise AttributeError(f"module 'palpate.report' has no attribute {name!r}")
