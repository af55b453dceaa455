"""Blocks of ticks are taken in order behind the loop; one that fails ends the run, whose record holds those before."""

import sys

import numpy as np
import pytest

from palpate import Scene, Session
from palpate.arm import models_folder
from palpate.record import Record
from palpate.record.ticks import TICK, as_ticks
from palpate.record.writer import Recorder
from palpate.session import PairsSession
from palpate.session.backlog import Backlog


def ticks(*times):
    found = np.zeros(len(times), TICK)
    found["t"] = times
    return as_ticks(found)


def test_every_tick_is_taken_in_order():
    taken = []
    backlog = Backlog(3, lambda block, snapshots: taken.append((block["t"].tolist(), snapshots)))
    backlog.finish()
    for t in range(8):
        backlog.add(ticks(t), [t] if t == 4 else [])
    backlog.finish()
    assert taken == [([0, 1, 2], []), ([3, 4, 5], [4]), ([6, 7], [])]


def test_blocks_after_one_that_failed_are_dropped_and_later_ones_taken():
    taken = []

    def keep(block, snapshots):
        if block["t"][0] == 1:
            raise RuntimeError("broken")
        taken.extend(block["t"].tolist())

    backlog = Backlog(1, keep)
    with pytest.raises(RuntimeError, match="broken"):  # noqa: PT012
        for t in range(1, 20):
            backlog.add(ticks(t), [])
        backlog.finish()
    dropped = [*taken]
    backlog.finish()
    backlog.add(ticks(50), [])
    backlog.finish()
    assert taken == [*dropped, 50]


@pytest.mark.parametrize("scene", ["palpation.yaml", "two_hands.yaml"])
def test_a_run_that_is_watched_has_the_same_record_and_leaves_the_interpreter_as_it_was(scene, tmp_path):
    """Batches are shorter where somebody looks on, and the recording thread gives way more often meanwhile."""
    given, seen, found = Scene.load(models_folder().parent / "scenes" / scene), [], []
    before = sys.getswitchinterval()
    for k, look in enumerate((None, lambda _: seen.append(sys.getswitchinterval()))):
        session = (PairsSession if given.pairs else Session)(given, out=tmp_path / str(k))
        session.run(0.7, on_progress=look)
        assert sys.getswitchinterval() == before
        found.append([path.read_bytes() for path in sorted((tmp_path / str(k)).rglob("record.mcap"))])
    assert len(seen) == 7
    assert max(seen) < before
    assert found[0] == found[1]
    assert found[0]


@pytest.fixture
def failing_from(monkeypatch):
    """Makes records fail from a time [s] on."""
    append = Recorder.append

    def begin(latest):
        def failing(recorder, rows, snapshots=()):
            if rows["t"][-1] > latest:
                raise RuntimeError("broken")
            append(recorder, rows, snapshots)

        monkeypatch.setattr(Recorder, "append", failing)

    return begin


def of_scene(name):
    return Scene.load(models_folder().parent / "scenes" / name)


@pytest.mark.parametrize("latest", [0.3, 0.9])
def test_a_run_whose_record_fails_leaves_the_ticks_before_it(latest, tmp_path, failing_from):
    """The last block is waited for when the session is closed."""
    failing_from(latest)
    session = Session(of_scene("palpation.yaml"), out=tmp_path)
    with pytest.raises(RuntimeError, match="broken"):
        session.run(1.0)
    record = Record.open(session.record)
    assert record.complete
    assert latest - 0.5 < record.ticks["t"][-1] < latest
    session.close()


def test_the_records_of_all_pairs_are_complete_when_they_fail(tmp_path, failing_from):
    failing_from(0.3)
    session = PairsSession(of_scene("two_hands.yaml"), out=tmp_path)
    with pytest.raises(RuntimeError, match="broken"):
        session.run(0.5)
    records = [Record.open(one.record) for one in session.pairs.values()]
    assert [record.complete for record in records] == [True, True]
    failing_from(1e9)
    assert session.run(0.1).record is not None, "a new run has a folder of its own"
