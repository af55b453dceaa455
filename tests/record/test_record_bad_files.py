"""Damaged records, and write errors of the disk."""

import os
import resource
import signal
import subprocess
import sys
import textwrap
import time

import numpy as np
import pytest
import synthetic_run
from effort import examples
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.writer import Writer

from palpate.base.errors import OutputError, PalpateError, RecordError
from palpate.record import Record, Recorder


@pytest.fixture(scope="module")
def complete_record(tmp_path_factory):
    path = tmp_path_factory.mktemp("whole") / "record.mcap"
    ticks = synthetic_run.run(1.1, rate=200.0)
    with Recorder(path, "name: floor\n", seed=0, rate=200.0, deterministic=True) as recorder:
        recorder.append(ticks)
    return path.read_bytes(), ticks


def error_of(path) -> str:
    with pytest.raises(RecordError) as error:
        Record.open(path)
    assert str(path) in str(error.value)
    return str(error.value)


def test_missing_empty_and_foreign_files_are_reported(tmp_path):
    assert "No such file" in error_of(tmp_path / "none.mcap")
    assert "it is a folder" in error_of(tmp_path)
    (tmp_path / "empty.mcap").touch()
    assert "empty" in error_of(tmp_path / "empty.mcap")
    (tmp_path / "text.mcap").write_text("solid liver\n")
    assert "not an MCAP file" in error_of(tmp_path / "text.mcap")


def test_a_foreign_mcap_is_reported(tmp_path):
    path = tmp_path / "camera.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        channel = writer.register_channel("/camera/image", "cdr", 0)
        writer.add_message(channel, 0, b"", 0)
        writer.finish()
    message = error_of(path)
    assert "not a record of Palpate: it has no /loop with the time t" in message
    assert "its channels: /camera/image" in message


def test_record_without_ticks_is_reported(tmp_path):
    Recorder(tmp_path / "r.mcap", "", 0, 1000.0, True).close()
    assert "the record has no ticks" in error_of(tmp_path / "r.mcap")


@settings(max_examples=examples(150), deadline=None)
@given(data=st.data())
def test_truncated_record_gives_its_complete_chunks_or_an_error(tmp_path_factory, complete_record, data):
    content, ticks = complete_record
    length = data.draw(st.integers(0, len(content) - 1))
    path = tmp_path_factory.getbasetemp() / "cut.mcap"
    path.write_bytes(content[:length])
    try:
        record = Record.open(path)
    except RecordError:
        return
    assert not record.complete
    assert "no end" in record.note
    assert len(record.ticks) % 50 == 0 or len(record.ticks) == len(ticks)
    np.testing.assert_array_equal(record.ticks["F_T_W"], ticks["F_T_W"][: len(record.ticks)])


@settings(max_examples=examples(300), deadline=None)
@given(data=st.data())
def test_flipped_bytes_never_cause_a_traceback(tmp_path_factory, complete_record, data):
    content = bytearray(complete_record[0])
    for _ in range(data.draw(st.integers(1, 4))):
        # three quarters of the samples hit the head of the file, which has the structure
        span = len(content) if data.draw(st.integers(0, 3)) == 0 else 6000
        content[data.draw(st.integers(0, span - 1))] = data.draw(st.integers(0, 255))
    path = tmp_path_factory.getbasetemp() / "flipped.mcap"
    path.write_bytes(content)
    try:
        record = Record.open(path)
        assert len(record.ticks)
        _ = record.faults, record.timing, record.rate, record.seed, record.duration, record.note
    except PalpateError:
        pass


def test_killed_run_leaves_a_record_except_the_last_second(tmp_path):
    path = tmp_path / "record.mcap"
    child = textwrap.dedent(
        f"""
        import sys, time
        import synthetic_run
        from palpate.record import Recorder
        ticks = synthetic_run.run(6.0)
        recorder = Recorder({str(path)!r}, "name: floor", 0, 1000.0, deterministic=False)
        for start in range(0, 6000, 33):
            recorder.append(ticks[start:start + 33])
            if start >= 3300:
                print("ready", flush=True)
                time.sleep(60)
        """
    )
    environment = dict(os.environ, PYTHONPATH=os.pathsep.join(sys.path))
    with subprocess.Popen([sys.executable, "-c", child], stdout=subprocess.PIPE, env=environment) as process:
        assert process.stdout.readline() == b"ready\n"
        process.send_signal(signal.SIGKILL)
    record = Record.open(path)
    assert not record.complete
    assert 3333 - 250 <= len(record.ticks) <= 3333
    np.testing.assert_array_equal(record.ticks["F_cell_L"], synthetic_run.run(6.0)["F_cell_L"][: len(record.ticks)])


def test_full_disk_ends_the_recording_but_not_the_run(tmp_path):
    """A limit on file size replaces the full disk: a write fails in the middle of a chunk."""
    ticks = synthetic_run.run(2.0)
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    old = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    recorder = Recorder(tmp_path / "r.mcap", "", 0, 1000.0, True)
    try:
        resource.setrlimit(resource.RLIMIT_FSIZE, (400_000, before[1]))
        for start in range(0, 2000, 100):
            recorder.append(ticks[start : start + 100])
        recorder.close()
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, old)
    assert recorder.failure is not None
    assert "File too large" in recorder.failure
    assert recorder.sha256 is None
    record = Record.open(tmp_path / "r.mcap")
    assert not record.complete
    assert len(record.ticks) == recorder.ticks_written > 0
    np.testing.assert_array_equal(record.ticks["q"], ticks["q"][: len(record.ticks)])


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="/dev/full is of Linux")
def test_full_disk_from_the_first_byte_is_reported():
    recorder = Recorder("/dev/full", "", 0, 1000.0, True)
    recorder.append(synthetic_run.run(0.5))
    recorder.close()
    assert "No space left on device" in recorder.failure


def test_missing_folder_is_reported(tmp_path):
    with pytest.raises(OutputError, match="the record cannot be written: No such file or directory"):
        Recorder(tmp_path / "no" / "r.mcap", "", 0, 1000.0, True)


def test_slow_real_time_run_is_flushed_periodically(tmp_path):
    ticks = synthetic_run.run(1.0)
    recorder = Recorder(tmp_path / "r.mcap", "", 0, 1000.0, deterministic=False)
    recorder.append(ticks[:10])
    time.sleep(0.3)
    recorder.append(ticks[10:20])
    assert len(Record.open(tmp_path / "r.mcap").ticks) == 20
    recorder.close()
