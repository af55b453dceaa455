"""A record as a table, with wall-clock time, and at a lower rate."""

from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
import synthetic_run

import palpate
from palpate.record import SIGNALS, Record, Recorder
from palpate.record.frame import column_names
from palpate.scene import RecordSection


def recorded(path, ticks, deterministic=True, **options):
    with Recorder(path, "name: floor\n", 0, 1000.0, deterministic, **options) as recorder:
        for start in range(0, len(ticks), 77):
            recorder.append(ticks[start : start + 77])
    return palpate.Record.open(path)


def test_table_has_a_column_with_unit_for_every_number(tmp_path):
    pytest.importorskip("pandas", reason="extra pandas")
    ticks = synthetic_run.run(0.3)
    record = recorded(tmp_path / "a.mcap", ticks, deterministic=False)
    table = record.to_pandas()
    assert table.index.name == "t [s]"
    assert len(table.columns) == sum(s.size for s in SIGNALS.values()) - 1
    np.testing.assert_array_equal(table[["F_T_W.x [N]", "F_T_W.y [N]", "F_T_W.z [N]"]], ticks["F_T_W"])
    np.testing.assert_array_equal(table["depth [m]"], ticks["depth"])
    np.testing.assert_array_equal(table.index, ticks["t"])


def test_names_of_columns_are_unique():
    names = [name for signal in SIGNALS.values() for name in column_names(signal)]
    assert len(set(names)) == len(names)


def test_started_is_recorded_in_real_time_only(tmp_path):
    """Wall-clock time is in the metadata of real-time records; equal lockstep runs give equal bytes."""
    ticks = synthetic_run.run(0.3)
    at = datetime(2026, 11, 22, 10, 15, tzinfo=UTC)
    assert recorded(tmp_path / "live.mcap", ticks, deterministic=False, started=at).started == at
    same = []
    for when in (at, at + timedelta(days=1)):
        assert recorded(tmp_path / "a.mcap", ticks, started=when).started is None
        same.append((tmp_path / "a.mcap").read_bytes())
    assert same[0] == same[1]


@pytest.mark.parametrize("every", [2, 5, 1000])
def test_lower_rate_keeps_every_nth_tick(tmp_path, every):
    ticks = synthetic_run.run(2.0)
    record = recorded(tmp_path / "a.mcap", ticks, every=every)
    assert record.rate == 1000.0 / every
    np.testing.assert_array_equal(record.ticks["t"], ticks["t"][::every])
    np.testing.assert_array_equal(record.ticks["F_T_W"], ticks["F_T_W"][::every])


def test_rate_is_the_haptic_rate_over_a_whole_number():
    assert [RecordSection(rate=rate).step(1000.0) for rate in (None, 1000, 300.0, "100 Hz", 1e6)] == [1, 1, 3, 10, 1]


def test_record_is_public():
    assert palpate.Record is Record


def test_section_of_a_scene_thins_a_record():
    assert RecordSection(every=5).step(1000.0) == 5
    assert RecordSection(signals=["F_H_L"]).signals == ("F_H_L",)
    with pytest.raises(ValueError, match="no signal 'F_HL'"):
        RecordSection(signals=["F_HL"])
    with pytest.raises(ValueError, match="keep one of them"):
        RecordSection(rate=100.0, every=2)
