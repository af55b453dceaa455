"""What a run tells afterwards: the summary table and the HTML report."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from palpate.report.html import report, write_report

__all__ = ["report", "write_report"]


def __getattr__(name: str) -> Any:
    """The page is imported when it is first written: the summary of a run does without it."""
    if name in __all__:
        from palpate.report import html

        return getattr(html, name)
    raise AttributeError(f"module 'palpate.report' has no attribute {name!r}")
