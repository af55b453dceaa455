"""Measures of how somebody performed a task, from a record."""

from palpate.metrics.force import ForceSensitivity, force_sensitivity
from palpate.metrics.measures import Wanted, summary
from palpate.metrics.scores import benchmark, fls_peg_transfer, simulator_score
from palpate.metrics.smoothness import log_dimensionless_jerk, movements, sparc

__all__ = [
    "ForceSensitivity",
    "Wanted",
    "benchmark",
    "fls_peg_transfer",
    "force_sensitivity",
    "log_dimensionless_jerk",
    "movements",
    "simulator_score",
    "sparc",
    "summary",
]
