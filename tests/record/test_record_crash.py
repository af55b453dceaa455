"""A recorder that is killed at a random moment, or whose last bytes are lost, leaves all but the last half second.

Long: PALPATE_RECORD_CRASHES=1000 pytest tests/record/test_record_crash.py; a few moments otherwise.
"""

import os
import signal
import subprocess
import sys
import textwrap
import time

import numpy as np
import pytest

from palpate.base.errors import RecordError
from palpate.record import Record, Recorder, as_ticks
from palpate.record.ticks import TICK_DOUBLES

SIGNALS = ("q", "status", "p_WT", "F_H_L", "cycle_us")
MOMENTS = int(os.environ.get("PALPATE_RECORD_CRASHES", "4"))


def ticks_from(first, n):
    """Ticks of which each number is known from its place."""
    k = np.arange(first, first + n)[:, None]
    ticks = as_ticks(np.sin(0.001 * k * (1.0 + np.arange(TICK_DOUBLES))))
    ticks["t"], ticks["status"] = k[:, 0] / 1000.0, k[:, 0]
    return ticks


def require_same(record):
    """Refuse a record whose signals are not those of `ticks_from`."""
    expected = ticks_from(0, len(record))
    for name in ("t", *SIGNALS):
        assert record[name].tobytes() == expected[name].tobytes(), name


CHILD = textwrap.dedent(
    """
    import sys, time
    sys.path.insert(0, sys.argv[2])
    from test_record_crash import SIGNALS, ticks_from
    from palpate.record import Recorder
    recorder = Recorder(sys.argv[1], "", 0, 1000.0, deterministic=False, signals=SIGNALS)
    print("ready", flush=True)
    began, given = time.monotonic(), 0
    while True:
        due = int(1000 * (time.monotonic() - began))
        if due > given:
            print("begun", due, flush=True)
            recorder.append(ticks_from(given, due - given))
            given = due
            print("given", given, flush=True)
        time.sleep(0.004)
    """
)


@pytest.mark.parametrize("moment", range(MOMENTS))
def test_killed_at_a_random_moment(tmp_path, moment):
    path = tmp_path / "record.mcap"
    wait = 0.6 + np.random.default_rng(moment).uniform(0.0, 1.0)
    command = [sys.executable, "-c", CHILD, str(path), os.path.dirname(__file__)]
    environment = dict(os.environ, PYTHONPATH=os.pathsep.join(sys.path))
    with subprocess.Popen(command, stdout=subprocess.PIPE, env=environment) as process:
        assert process.stdout.readline() == b"ready\n"
        time.sleep(wait)
        process.send_signal(signal.SIGKILL)
        lines = process.stdout.read().decode().splitlines(keepends=True)
    said = [line.split() for line in lines if line.endswith("\n")]  # the kill may cut the last one
    begun, given = (max((int(n) for word, n in said if word == kind), default=0) for kind in ("begun", "given"))
    try:
        record = Record.open(path)
    except RecordError:
        assert given <= 500, "on a busy machine the recorder may get no second before it is killed"
        return
    assert not record.complete
    assert f"{len(record)} ticks" in record.note
    assert given - 500 <= len(record) <= begun, "all but the last half second, and none that was not given"
    require_same(record)


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """A record in the making, with the number of its ticks at each length of the file."""
    path = tmp_path_factory.mktemp("crash") / "record.mcap"
    recorder = Recorder(path, "", 0, 1000.0, deterministic=False, signals=SIGNALS)
    lengths = []
    for first in range(0, 3000, 250):
        recorder.append(ticks_from(first, 250))
        lengths.append((path.stat().st_size, first + 250))
    data = path.read_bytes()
    recorder.close()
    return data, lengths


@pytest.mark.parametrize("moment", range(3 * MOMENTS))
@pytest.mark.parametrize("tail", ["cut", "zeros", "hole"])
def test_lost_end_of_the_file(written, tmp_path, moment, tail):
    """A file system that lost its last pages: the file is shorter, ends in zeros, or has a page of zeros."""
    data, lengths = written
    rng = np.random.default_rng([moment, len(tail)])
    at = int(rng.integers(len(data)))
    path = tmp_path / "lost.mcap"
    hole = at // 4096 * 4096
    lost = {
        "cut": data[:at],
        "zeros": data[:at] + bytes(len(data) - at),
        "hole": data[:hole] + bytes(min(4096, len(data) - hole)) + data[hole + 4096 :],
    }
    path.write_bytes(lost[tail])
    whole = max((n for length, n in lengths if length <= (hole if tail == "hole" else at)), default=0)
    try:
        record = Record.open(path)
    except RecordError:
        assert whole == 0, "ticks that were written are lost"
        return
    assert len(record) >= whole
    require_same(record)


def test_a_file_cut_in_its_first_block_has_no_ticks_rather_than_half_of_their_signals(written, tmp_path):
    data, lengths = written
    path = tmp_path / "lost.mcap"
    refused = 0
    for at in range(0, lengths[0][0] + 1, 499):
        path.write_bytes(data[:at])
        try:
            record = Record.open(path)
        except RecordError:
            refused += 1
            continue
        assert len(record) == 250
        require_same(record)
    assert refused > 20
