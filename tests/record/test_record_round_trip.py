import hashlib
from pathlib import Path

import numpy as np
import pytest
import synthetic_run
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst

from palpate.record import SIGNALS, Record, Recorder, as_rows, as_ticks
from palpate.record.ticks import TICK_DOUBLES

SCENE = "name: floor\nrate: 1000.0\n"


def write(path: Path, ticks, batch: int = 137, deterministic: bool = True, **end) -> Recorder:
    recorder = Recorder(path, SCENE, seed=3, rate=1000.0, deterministic=deterministic)
    for start in range(0, len(ticks), batch):
        recorder.append(ticks[start : start + batch])
    recorder.close(**end)
    assert recorder.failure is None
    return recorder


def test_deterministic_signals_are_read_back_bit_for_bit(tmp_path):
    ticks = synthetic_run.run()
    recorder = write(tmp_path / "r.mcap", ticks, faults=["leader silent at 1.2 s"])
    record = Record.open(tmp_path / "r.mcap")
    for name, signal in SIGNALS.items():
        if signal.deterministic:
            assert record.ticks[name].tobytes() == ticks[name].tobytes(), name
        else:
            assert np.isnan(record.ticks[name]).all(), "a lockstep record has no computing times"
    assert record.complete
    assert record.note is None
    assert record.deterministic
    assert (record.scene, record.seed, record.rate, record.duration) == (SCENE, 3, 1000.0, pytest.approx(4.0))
    assert record.faults == ["leader silent at 1.2 s"]
    assert record.signals["F_H_H"].unit == "N"
    assert recorder.sha256 == hashlib.sha256((tmp_path / "r.mcap").read_bytes()).hexdigest()


def test_real_time_record_also_has_the_computing_times(tmp_path):
    ticks = synthetic_run.run(1.0)
    write(tmp_path / "r.mcap", ticks, deterministic=False, timing={"missed_ticks": 2, "scheduler": "normal"})
    record = Record.open(tmp_path / "r.mcap")
    np.testing.assert_array_equal(as_rows(record.ticks), as_rows(ticks))
    assert record.timing == {"missed_ticks": 2, "scheduler": "normal"}


@settings(max_examples=20, deadline=None)
@given(
    rows=npst.arrays(np.float64, st.tuples(st.integers(1, 40), st.just(TICK_DOUBLES)), elements=st.floats(width=64)),
    bits=st.integers(0, 2**32 - 1),
)
def test_any_double_and_any_status_survive_a_round_trip(tmp_path_factory, rows, bits):
    path = tmp_path_factory.mktemp("any") / "r.mcap"
    ticks = as_ticks(rows.copy())
    ticks["status"] = bits
    write(path, ticks, batch=7, deterministic=False)
    assert as_rows(Record.open(path).ticks).tobytes() == as_rows(ticks).tobytes()


def test_bytes_of_a_record_are_independent_of_the_batches(tmp_path):
    ticks = synthetic_run.run()
    write(tmp_path / "a.mcap", ticks, batch=1)
    other = ticks.copy()
    other["cycle_us"] += 1.0  # computing times of another machine
    other["lateness_us"] = 0.0
    (tmp_path / "b").mkdir()
    write(tmp_path / "b" / "a.mcap", other, batch=4000)
    assert (tmp_path / "a.mcap").read_bytes() == (tmp_path / "b" / "a.mcap").read_bytes()


def test_recording_after_the_end_has_no_effect(tmp_path):
    ticks = synthetic_run.run(0.5)
    recorder = write(tmp_path / "r.mcap", ticks)
    before = (tmp_path / "r.mcap").read_bytes()
    recorder.append(ticks)
    recorder.close()
    assert (tmp_path / "r.mcap").read_bytes() == before
