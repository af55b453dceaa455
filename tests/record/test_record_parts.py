"""What is read of a record in parts is what the cycle wrote, bit by bit: columns, ranges, blocks, tables."""

import os
from functools import lru_cache
from threading import current_thread

import numpy as np
import pytest
import synthetic_run

from palpate.base.errors import RecordError
from palpate.record import SIGNALS, Record, Recorder, as_rows, as_ticks, pieces
from palpate.record.ticks import TICK_DOUBLES


def written(path, ticks, batch=331, **options):
    with Recorder(path, "", 0, 1000.0, options.pop("deterministic", False), **options) as recorder:
        for start in range(0, len(ticks), batch):
            recorder.append(ticks[start : start + batch])
    assert recorder.failure is None
    return Record.open(path)


def waking(n, seed):
    """Ticks whose numbers begin to move one after the other, and then never rest: layouts grow."""
    rng = np.random.default_rng(seed)
    rows = np.tile(rng.normal(size=TICK_DOUBLES), (n, 1))
    wake = rng.integers(0, 2 * n, TICK_DOUBLES)  # half of them never
    moving = np.arange(n)[:, None] >= wake
    rows[moving] = rng.normal(size=int(moving.sum()))
    ticks = as_ticks(rows)
    ticks["t"] = np.arange(n) / 1000.0
    return ticks


@pytest.fixture(scope="module")
def grown(tmp_path_factory):
    ticks = waking(5000, 3)
    return written(tmp_path_factory.mktemp("grown") / "r.mcap", ticks), ticks


def test_every_column_has_the_bits_that_were_written(grown):
    record, ticks = grown
    topics = [one.topic for one in record._index.channels.values()]
    assert topics.count("/follower") > 3, "the layout grew"
    for name in SIGNALS:
        assert record[name].tobytes() == ticks[name].tobytes(), name
    assert as_rows(record.ticks).tobytes() == as_rows(ticks).tobytes()


@pytest.mark.parametrize("signal", list(SIGNALS))
def test_a_signal_that_moves_alone_is_kept(tmp_path, signal):
    """Every column in turn: all others stay, this one moves at one tick."""
    ticks = as_ticks(np.zeros((600, TICK_DOUBLES)))
    ticks["t"] = np.arange(600) / 1000.0
    column = ticks[signal].reshape(600, -1)
    column[417, -1] = 3
    record = written(tmp_path / "r.mcap", ticks)
    assert as_rows(record.ticks).tobytes() == as_rows(ticks).tobytes()


def test_ranges_blocks_and_steps_are_those_of_the_whole(grown):
    record, ticks = grown
    assert len(record) == len(ticks)
    blocks = [block.copy() for block in record.blocks()]
    assert len(blocks) > 2
    assert np.concatenate(blocks).tobytes() == ticks.tobytes()
    names = ["F_T_W", "quat_WT", "status", "depth"]
    for start, stop, every in ((0, 1, 1), (249, 251, 1), (17, 4321, 7), (4990, None, 3), (3, 3, 2), (-10, None, 1)):
        found = record.read(names, start, stop, every)
        for name in names:
            assert found[name].tobytes() == ticks[name][start:stop:every].tobytes(), (start, stop, every)


def test_threads_that_unpack_ahead_change_no_bit_and_tell_damage(grown, monkeypatch, tmp_path):
    record, ticks = grown
    monkeypatch.setattr(pieces, "AHEAD_FROM", 0)
    threads = set()
    load = type(record._index).load
    monkeypatch.setattr(
        type(record._index), "load", lambda self, place: threads.add(current_thread().name) or load(self, place)
    )
    for start, stop in ((0, None), (249, 251), (17, 4321)):
        found = Record.open(record.path).read(None, start, stop)
        assert found.tobytes() == ticks[start:stop].tobytes()
    assert any(name.startswith("palpate-record") for name in threads)
    data = bytearray(record.path.read_bytes())
    *_, place = (p for p in record._index.chunks if record._index.channels[p.channels[0]].topic == "/follower")
    data[place.offset + place.length - 9] ^= 0xFF
    (tmp_path / "r.mcap").write_bytes(data)
    with pytest.raises(RecordError, match="damaged"):
        Record.open(tmp_path / "r.mcap").read(["F_T_W"])


def test_only_the_chunks_of_the_asked_signal_are_unpacked(grown, monkeypatch):
    record, _ = grown
    loaded = []
    load = type(record._index).load
    monkeypatch.setattr(type(record._index), "load", lambda self, place: loaded.append(place) or load(self, place))
    record.read(["F_T_W"], 1000, 1500)
    channels = {channel for place in loaded for channel in place.channels}
    assert {record._index.channels[channel].topic for channel in channels} == {"/follower"}
    assert 2 <= len(loaded) <= 3


def test_frame_reads_a_span_of_some_columns(grown):
    pytest.importorskip("pandas", reason="extra pandas")
    record, ticks = grown
    table = record.frame(["F_T_W", "depth"], start=1.0, stop=2.0, every=10)
    assert list(table.columns) == ["F_T_W.x [N]", "F_T_W.y [N]", "F_T_W.z [N]", "depth [m]"]
    np.testing.assert_array_equal(table.index, ticks["t"][1000:2000:10])
    np.testing.assert_array_equal(table["depth [m]"], ticks["depth"][1000:2000:10])
    assert record.frame(["F_T_W"], start=1e4).shape == (0, 3)
    with pytest.raises(KeyError, match="force not recorded"):
        record.frame(["force"])


def test_a_thinned_record_shares_the_columns_it_has(tmp_path):
    ticks = synthetic_run.run(1.5)
    full = written(tmp_path / "full.mcap", ticks)
    thin = written(tmp_path / "thin.mcap", ticks, signals=["p_WT", "F_H_L"], every=4)
    assert list(thin.signals) == ["t", "p_WT", "F_H_L"]
    for name in thin.signals:
        assert thin[name].tobytes() == full.read([name], every=4)[name].tobytes()
    assert thin.path.stat().st_size < full.path.stat().st_size / 4


def test_a_million_ticks_are_read_back_bit_by_bit(tmp_path):
    """Long: PALPATE_RECORD_TICKS=1000000; 20,000 ticks otherwise."""
    n, seed = int(os.environ.get("PALPATE_RECORD_TICKS", "20000")), 11
    step = 5000
    rng = np.random.default_rng(seed)
    wake = rng.integers(0, n, TICK_DOUBLES)

    @lru_cache(maxsize=2)  # several blocks are compared with each
    def rows(start):
        one = np.random.default_rng([seed, start])
        found = np.where(np.arange(start, start + step)[:, None] >= wake, one.normal(size=(step, TICK_DOUBLES)), 0.5)
        ticks = as_ticks(found)
        ticks["t"] = np.arange(start, start + step) / 1000.0
        return ticks

    with Recorder(tmp_path / "r.mcap", "", 0, 1000.0, False) as recorder:
        for start in range(0, n, step):
            recorder.append(rows(start))
    record = Record.open(tmp_path / "r.mcap")
    assert len(record) == n
    at = 0
    for block in record.blocks():
        first = at // step * step
        expected = np.concatenate([rows(k) for k in range(first, at + len(block), step)])[at - first :][: len(block)]
        assert block.tobytes() == expected.tobytes(), at
        at += len(block)
    assert at == n
