"""What a replay reads of a record: the same as from ticks in memory, and few chunks wherever it jumps to."""

import numpy as np
import pytest
import synthetic_run

from palpate.record import Record, Recorder
from palpate.record.ticks import TICK
from palpate.viewer.gauges import HISTORY, POINTS, WINDOW
from palpate.viewer.played import Played

SECONDS = 40.0


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Ticks at 250 Hz, and the file of their record."""
    ticks = synthetic_run.run(SECONDS, 250.0)
    path = tmp_path_factory.mktemp("played") / "record.mcap"
    with Recorder(path, "", 0, 250.0, deterministic=False) as recorder:
        recorder.append(ticks)
    return ticks, path


def test_a_record_is_played_as_its_ticks_in_memory(run):
    ticks, path = run
    record = Record.open(path)
    played, known = Played(record), Played(record.ticks)
    assert len(played) == len(ticks)
    assert played.span == known.span == (ticks["t"][0], ticks["t"][-1])
    assert played.end() == known.end()
    for t in (-1.0, 0.0, 3.0021, 17.5, 39.9, 50.0):
        k = played.number(t)
        assert k == known.number(t) == max(0, int(np.searchsorted(ticks["t"], t, side="right")) - 1)
        for name in TICK.names:
            np.testing.assert_array_equal(played.tick(k)[name], known.tick(k)[name])
        plotted = [one.window(HISTORY, k, WINDOW, POINTS) for one in (played, known)]
        assert len(plotted[0]) <= 2 * POINTS
        for name in HISTORY:
            np.testing.assert_array_equal(plotted[0][name], plotted[1][name])


def test_a_jump_unpacks_the_chunks_of_what_is_drawn_alone(run, monkeypatch):
    record = Record.open(run[1])
    played, loaded = Played(record), []
    load = type(record._index).load
    monkeypatch.setattr(type(record._index), "load", lambda self, place: loaded.append(place) or load(self, place))
    k = played.number(30.0)
    played.tick(k), played.window(HISTORY, k, WINDOW, POINTS)
    drawn = 3 * (4 * WINDOW + 2)  # chunks of a quarter second of three groups
    assert len(loaded) <= drawn + 40
    loaded.clear()
    k = played.number(30.03)
    played.tick(k), played.window(HISTORY, k, WINDOW, POINTS)
    assert len(loaded) <= 10, "the next picture"
