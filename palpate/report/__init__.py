"""What a run tells afterwards: the summary table and the HTML report."""

from palpate.report.html import report, write_report

__all__ = ["report", "write_report"]
