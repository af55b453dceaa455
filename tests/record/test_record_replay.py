import numpy as np
import pytest
import synthetic_run

from palpate.record import Record, Recorder, play


@pytest.fixture(scope="module")
def record(tmp_path_factory):
    path = tmp_path_factory.mktemp("replay") / "r.mcap"
    with Recorder(path, "", 0, 1000.0, True) as recorder:
        recorder.append(synthetic_run.run(2.0))
    return Record.open(path)


class Clock:
    """Time that passes only when slept, plus what each frame's drawing takes."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        self.now += seconds


@pytest.mark.parametrize(("speed", "drawing"), [(1.0, 0.0), (2.0, 0.0), (0.5, 0.01), (1.0, 0.2)])
def test_every_tick_once_and_on_time(record, speed, drawing):
    clock = Clock()
    frames = []
    for frame in play(record, rate=30.0, speed=speed, clock=clock, sleep=clock.sleep):
        due = (frame["t"][-1] - record.ticks["t"][0]) / speed
        assert clock.now - 100.0 >= due - 1e-9, "no tick before its time"
        assert clock.now - 100.0 - due <= drawing + 1.1e-3 / speed, "the newest tick is fresh"
        frames.append(frame)
        clock.now += drawing
    np.testing.assert_array_equal(np.concatenate(frames)["t"], record.ticks["t"])
    assert clock.now - 100.0 == pytest.approx(2.0 / speed, abs=2 * drawing + 1e-9 + 1.1e-3 / speed)
    assert len(frames) <= 30 * 2.0 / speed + 2


def test_start_in_the_middle(record):
    clock = Clock()
    first = next(iter(play(record, start=1.5, clock=clock, sleep=clock.sleep)))
    assert first["t"][0] == pytest.approx(1.5)


def test_bad_speed(record):
    with pytest.raises(ValueError, match="rate and speed are positive"):
        next(iter(play(record, speed=0.0)))
