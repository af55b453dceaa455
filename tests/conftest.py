"""Fixed seeds for every property test, so that failures are reproducible on all machines; one thread of BLAS each.

Tests run beside each other, and waiting threads of BLAS would take their cores.
"""

import os

from hypothesis import settings

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(name, "1")

settings.register_profile("palpate", derandomize=True, deadline=None)
settings.load_profile("palpate")
