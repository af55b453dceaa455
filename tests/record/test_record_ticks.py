import itertools

import numpy as np
import pytest

from palpate import _core
from palpate.record.ticks import SIGNALS, TICK, TICK_BYTES, TICK_DOUBLES, as_rows, as_ticks


def test_table_covers_every_byte_of_the_tick_once():
    spans = sorted((s.offset, s.offset + 8 * s.size) for s in SIGNALS.values())
    assert spans[0][0] == 0
    assert spans[-1][1] == TICK_BYTES
    assert all(a[1] == b[0] for a, b in itertools.pairwise(spans))
    assert len(SIGNALS) == len(_core.signals())


def test_fields_match_the_offsets_of_the_table():
    rows = np.random.default_rng(1).normal(size=(5, TICK_BYTES // 8))
    ticks = as_ticks(rows)
    assert ticks.shape == (5,)
    for s in SIGNALS.values():
        column = s.offset // 8
        expected = rows[:, column] if s.size == 1 else rows[:, column : column + s.size]
        np.testing.assert_array_equal(ticks[s.name].view(np.float64), expected)
        assert ticks[s.name].dtype == (np.uint64 if s.name == "status" else np.float64)
    np.testing.assert_array_equal(as_rows(ticks), rows)
    assert as_ticks(ticks).dtype == TICK


def test_wrong_shape_is_reported():
    with pytest.raises(ValueError, match=rf"float64 of shape \(n, {TICK_DOUBLES}\). Got: float64 \(5, 3\)"):
        as_ticks(np.zeros((5, 3)))
