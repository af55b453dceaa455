"""Every status of the loop has a description."""

import re
from pathlib import Path

import numpy as np
import pytest

from palpate.record.ticks import TICK
from palpate.viewer.words import in_words

HEADER = Path(__file__).parents[2] / "core" / "palpate" / "types" / "status.hpp"
BITS = {name: int(bit) for name, bit in re.findall(r"(k\w+) = 1u << (\d+)", HEADER.read_text())}


def tick(status=0, contacts=0.0):
    row = np.zeros((), dtype=TICK)
    row["status"], row["contacts"] = status, contacts
    return row


@pytest.mark.parametrize("name", BITS)
def test_every_status_bit_has_its_own_description(name):
    (description,) = in_words(tick(1 << BITS[name]), 3.0)
    others = {in_words(tick(1 << bit), 3.0)[0] for other, bit in BITS.items() if other != name}
    assert description not in {"free", "touching"} | others


def test_force_cap_is_shown_in_newtons_after_graver_states():
    shown = in_words(tick((1 << BITS["kForceCapped"]) | (1 << BITS["kNotFinite"])), 3.0)
    assert shown == ["a number was not finite, or beyond a million: the force ramps to zero", "force capped at 3 N"]


def test_status_zero_has_no_description():
    assert in_words(tick(), 3.0) == ["free"]
    assert in_words(tick(contacts=1.0), 3.0) == ["touching"]
    assert in_words(tick(), 3.0, paused=True)[0].startswith("paused")
