"""Fixed seeds for every property test, so that failures are reproducible on all machines."""

from hypothesis import settings

settings.register_profile("palpate", derandomize=True, deadline=None)
settings.load_profile("palpate")
