"""A record outlives its version: files of earlier versions, files without some signals, files with unknown ones."""

from pathlib import Path

import numpy as np
import pytest
import synthetic_run
from mcap.reader import make_reader
from mcap.writer import Writer

from palpate.record import SIGNALS, Record, Recorder

DATA = Path(__file__).with_name("data")


@pytest.mark.parametrize("name", sorted(path.stem for path in DATA.glob("*.mcap")))
def test_files_of_earlier_versions_are_read_bit_for_bit(name):
    """Each file of a version lies beside the arrays that this version wrote into it."""
    record, arrays = Record.open(DATA / f"{name}.mcap"), np.load(DATA / f"{name}.npz")
    assert set(record.signals) == set(arrays)
    for signal, expected in arrays.items():
        assert record[signal].tobytes() == expected.tobytes(), signal
        if signal in SIGNALS:
            assert record.ticks[signal].tobytes() == expected.tobytes(), signal
    assert record.complete
    assert record.scene.startswith(("name:", "title:", "#", "arms:")) or "objects" in record.scene
    for signal in set(SIGNALS) - set(arrays):
        assert np.isnan(record[signal]).all(), "a signal that was not recorded is NaN"


def test_a_signal_that_was_not_recorded_reads_as_nan(tmp_path):
    ticks = synthetic_run.run(0.6)
    with Recorder(tmp_path / "r.mcap", "", 0, 1000.0, True, signals=["F_H_L", "depth"]) as recorder:
        recorder.append(ticks)
    record = Record.open(tmp_path / "r.mcap")
    assert list(record.signals) == ["t", "depth", "F_H_L"]
    np.testing.assert_array_equal(record["depth"], ticks["depth"])
    assert record["q"].shape == (600, 7)
    assert np.isnan(record["q"]).all()
    assert (record.ticks["status"] == 0).all(), "bits cannot be NaN"


def test_a_signal_of_a_later_version_is_kept(tmp_path):
    """The later version has a signal that this one does not know, and no `depth`."""
    ticks = synthetic_run.run(0.6)
    with Recorder(tmp_path / "now.mcap", "", 0, 1000.0, True) as recorder:
        recorder.append(ticks)
    with (tmp_path / "now.mcap").open("rb") as file, (tmp_path / "later.mcap").open("wb") as out:
        writer = Writer(out, chunk_size=50_000)
        writer.start(profile="ros2")
        ids = {}
        for schema, channel, message in make_reader(file).iter_messages():
            if channel.id not in ids:
                text = schema.data.replace(b"float64 depth ", b"float64 tear ")
                ids[channel.id] = writer.register_channel(
                    channel.topic, "cdr", writer.register_schema(schema.name, schema.encoding, text)
                )
            writer.add_message(ids[channel.id], message.log_time, message.data, message.publish_time)
        writer.finish()
    record = Record.open(tmp_path / "later.mcap")
    assert record.signals["tear"].size == 1
    np.testing.assert_array_equal(record["tear"], ticks["depth"])
    assert np.isnan(record.ticks["depth"]).all()
    np.testing.assert_array_equal(record.ticks["F_T_W"], ticks["F_T_W"])


def test_an_unknown_name_is_refused(tmp_path):
    with Recorder(tmp_path / "r.mcap", "", 0, 1000.0, True) as recorder:
        recorder.append(synthetic_run.run(0.3))
    with pytest.raises(KeyError, match="no signal 'force'"):
        Record.open(tmp_path / "r.mcap")["force"]
