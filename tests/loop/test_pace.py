"""The pace along a planned motion, against the closed forms of constant acceleration."""

import pytest

from palpate import _core

DT = 1e-3


@pytest.mark.parametrize("stop_time", [0.02, 0.04])
def test_a_stop_from_full_pace_takes_the_stop_time_and_half_of_it_along_the_motion(stop_time: float) -> None:
    pace = _core.Pace(stop_time)
    gained = sum(pace.step(1.0, DT) for _ in range(round(stop_time / DT)))
    assert pace.value == pytest.approx(1.0)
    assert gained == pytest.approx(0.5 * stop_time)
    assert pace.step(1.0, DT) == pytest.approx(DT)
    steps, progress = 0, 0.0
    while pace.value > 1e-12:
        progress += pace.step(0.0, DT)
        steps += 1
    assert steps == pytest.approx(stop_time / DT, abs=1)
    assert progress == pytest.approx(0.5 * stop_time)
    assert pace.step(0.0, DT) == pytest.approx(0.0, abs=1e-15)


def test_from_the_limit_a_motion_rests_within_what_is_left() -> None:
    for left in (1e-4, 1e-3, 5e-3):
        pace = _core.Pace(0.02)
        while pace.value < pace.limit(left):
            pace.step(pace.limit(left), 1e-5)
        progress = 0.0
        while pace.value > 1e-12:
            progress += pace.step(0.0, 1e-5)
        assert progress == pytest.approx(left, rel=1e-3)
    assert _core.Pace(0.02).limit(-1.0) == 0.0


def test_the_end_of_a_motion_resets_the_pace() -> None:
    pace = _core.Pace(0.02)
    pace.step(1.0, DT)
    pace.reset()
    assert pace.value == 0.0


@pytest.mark.parametrize("stop_time", [0.0, -1.0, float("nan"), float("inf")])
def test_a_stop_time_that_is_none_is_refused(stop_time: float) -> None:
    with pytest.raises(ValueError, match="must be above 0 s"):
        _core.Pace(stop_time)
