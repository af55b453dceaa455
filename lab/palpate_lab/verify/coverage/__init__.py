"""Coverage: how often the intervals and verdicts that commands print are right, on data with known truth.

Each file in `estimates` is one estimate: a generator of data in the form that the estimate assumes, and in three forms
that it does not assume. `run` repeats them and counts. A command that prints an interval needs such a file;
tests/verify/test_coverage.py compares them with the pages of the JSON.
"""
