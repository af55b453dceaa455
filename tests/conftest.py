"""Fixed seeds for every property test: a failure on one machine is a failure on all."""

from hypothesis import settings

settings.register_profile("palpate", derandomize=True, deadline=None)
settings.load_profile("palpate")
