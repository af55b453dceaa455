"""The memory of a record does not grow with the number of its chunks."""

import tracemalloc

import numpy as np
from mcap.reader import make_reader

from palpate.record.mcap_file import Block, McapFile

CHANNELS, TICKS = 70, 64


def chunks_of(file, count):
    """Write chunks of as many channels as a dVRK pair has."""
    for k in range(count):
        times = np.arange(k * TICKS, (k + 1) * TICKS, dtype=np.uint64)
        file.add_chunk(Block(np.zeros((TICKS, CHANNELS), np.uint8), times, {c + 1: c for c in range(CHANNELS)}))


def test_memory_is_the_same_after_a_thousand_chunks(tmp_path):
    """The index of a chunk takes 0.8 kB, and 50 hours at 500 Hz have 1.4 million of them: a file keeps it."""
    file = McapFile(tmp_path / "long.mcap")
    file.begin(profile="", library="test")
    schema = file.add_schema("none", "", "")
    for c in range(CHANNELS):
        file.add_channel(f"/{c}", schema, "", {})
    chunks_of(file, 50)
    tracemalloc.start()
    chunks_of(file, 1000)
    grown, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    file.finish()
    assert grown < 100_000, "[bytes]; the index of these chunks has 800,000"
    with (tmp_path / "long.mcap").open("rb") as stream:
        summary = make_reader(stream, validate_crcs=True).get_summary()
    assert len(summary.chunk_indexes) == 1050
    assert [path.name for path in tmp_path.iterdir()] == ["long.mcap"]
