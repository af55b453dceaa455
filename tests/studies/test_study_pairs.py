"""`palpate study pairs`: apart, a hand feels what it feels alone; a difference between two runs is told."""

import numpy as np
import pytest
from two_pairs import TWO

from palpate.base.errors import PalpateError
from palpate_lab.studies.pairs import work
from palpate_lab.studies.pairs.work import run, table


def study(folder, text, **options):
    file = folder / "two.yaml"
    file.write_text(text)
    return run(file, duration=2.0, **options)


def test_hands_that_stay_apart_feel_what_they_feel_alone(tmp_path):
    found = study(tmp_path, TWO)
    assert [one.row.pair for one in found] == ["right", "left"]
    for one in found:
        assert one.row.peak_N > 0.1
        assert one.row.added_peak_N == one.row.contact_s == one.row.instrument_peak_N == 0.0
        np.testing.assert_array_equal(one.alone, one.together)
        assert one.row.verdict_with_instrument == "stable"
    table([one.row for one in found])


def test_a_force_that_another_instrument_adds_is_told(tmp_path, monkeypatch):
    """The run beside the other is changed: its instrument pushes with 0.2 N for half a second."""
    together = work._together

    def pushed(scene, seconds):
        summaries, ticks = together(scene, seconds)
        beside = ticks["left"].copy()
        beside["F_H_L"][1000:1500, 0] += 0.2
        beside["F_instrument_W"][1000:1500, 1] = 0.2
        beside["instrument_gap"][1000:1500] = -1e-4
        return summaries, ticks | {"left": beside}

    monkeypatch.setattr(work, "_together", pushed)
    (one,) = study(tmp_path, TWO, pair="left")
    assert one.row.added_s == one.row.contact_s == pytest.approx(0.5)
    assert one.row.added_peak_N == pytest.approx(0.2)
    assert one.row.added_mean_N == pytest.approx(0.2)
    assert one.row.instrument_peak_N == pytest.approx(0.2)


def test_a_scene_of_one_pair_is_refused(tmp_path):
    with pytest.raises(PalpateError, match="the scene has one"):
        study(tmp_path, "objects: [{sphere: {radius: 0.03}, stiffness: 300}]\n")
