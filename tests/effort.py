"""How many examples a property test tries: a third in `make test`, all in `make test-long`."""

import os

LONG = os.environ.get("PALPATE_LONG") == "1"


def examples(n: int) -> int:
    """The number of examples for a test that tries n in its long version."""
    return n if LONG else max(10, n // 3)
