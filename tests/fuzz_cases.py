"""Test cases for the runner of `palpate fuzz`: one dies, one fails, one raises an unexpected error."""

import os

from palpate_lab.verify.fuzz import FaultError


def case(seed: int) -> dict[str, int]:
    if seed == 3:
        os._exit(7)
    if seed == 5:
        raise FaultError("a violated requirement")
    return {"fine": 6 // (seed - 6) and 1}
