"""Cases for the runner of `palpate fuzz` that die, fail and raise."""

import os

from palpate.verify.fuzz import FaultError


def case(seed: int) -> dict[str, int]:
    if seed == 3:
        os._exit(7)
    if seed == 5:
        raise FaultError("what must not be")
    return {"fine": 6 // (seed - 6) and 1}
