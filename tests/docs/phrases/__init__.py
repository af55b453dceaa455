"""Phrases of the pages that are computed from the results kept in docs/results."""

from phrases import guidance, planning, registration, stability, tissue, wall

TIES = [*wall.TIES, *stability.TIES, *guidance.TIES, *planning.TIES, *registration.TIES, *tissue.TIES]
