"""The cache returns equal arrays, survives damaged files and concurrent writers, bounds its size, changes no record."""

import os
import subprocess
import sys

import numpy as np
import pytest

from palpate.base import cache
from palpate.base.cache import store
from palpate.world import shapes

ARRAYS = {"vertices": np.linspace(0.0, 1.0, 30).reshape(10, 3), "triangles": np.arange(12, dtype=np.int32)}


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path / "palpate"


class Maker:
    """A factory of the arrays that counts its calls."""

    def __init__(self, arrays=ARRAYS):
        self.count, self.arrays = 0, arrays

    def __call__(self):
        self.count += 1
        return self.arrays


def same(found):
    return found.keys() == ARRAYS.keys() and all(
        found[name].dtype == values.dtype and found[name].tobytes() == values.tobytes()
        for name, values in ARRAYS.items()
    )


def test_arrays_are_made_once_and_read_back_bit_for_bit():
    make = Maker()
    assert same(cache.load_or_make("shape", "0123", make))
    assert same(cache.load_or_make("shape", "0123", make))
    assert make.count == 1
    assert same(cache.load_or_make("shape", "4567", make))
    assert make.count == 2
    assert {entry.kind for entry in cache.entries()} == {"shape"}


@pytest.mark.parametrize("damage", ["truncated", "flipped", "empty", "text", "other"])
def test_damaged_file_is_replaced(damage):
    make = Maker()
    cache.load_or_make("shape", "0123", make)
    path = cache.entries()[0].path
    data = bytearray(path.read_bytes())
    if damage == "flipped":
        start = data.index(ARRAYS["vertices"].tobytes())
        data[start + 17] ^= 0xFF
    path.write_bytes({"truncated": bytes(data[: len(data) // 2]), "empty": b"", "text": b"not a cache",
                      "other": b"\x93NUMPY" + bytes(40)}.get(damage, bytes(data)))  # fmt: skip
    assert same(cache.load_or_make("shape", "0123", make))
    assert make.count == 2
    assert same(cache.load_or_make("shape", "0123", make))
    assert make.count == 2


def test_any_flipped_byte_is_detected_or_harmless():
    cache.load_or_make("shape", "0123", Maker())
    path = cache.entries()[0].path
    data = path.read_bytes()
    for index in range(0, len(data), 7):
        damaged = bytearray(data)
        damaged[index] ^= 0x41
        path.write_bytes(bytes(damaged))
        found = store._read(path)
        assert found is None or found.keys() != ARRAYS.keys() or same(found), f"byte {index}"


def test_folder_that_cannot_be_written_only_disables_the_cache(folder, monkeypatch):
    folder.write_text("a file where the folder should be")
    make = Maker()
    assert same(cache.load_or_make("shape", "0123", make))
    assert same(cache.load_or_make("shape", "0123", make))
    assert make.count == 2
    monkeypatch.setenv("XDG_CACHE_HOME", "not/absolute")
    monkeypatch.setenv("HOME", str(folder.parent))
    assert cache.folder() == folder.parent / ".cache" / "palpate"


def test_oldest_entries_are_deleted_at_the_size_limit(folder, monkeypatch):
    for k in range(4):
        cache.load_or_make("shape", f"{k:04}", Maker())
        os.utime(folder / f"shape-{k:04}.npz", (1000.0 + k, 1000.0 + k))
    size = cache.entries()[0].bytes
    cache.load_or_make("shape", "0000", Maker())  # a read makes this entry the newest
    leftover = folder / ".dead.tmp"
    leftover.write_bytes(b"half")
    os.utime(leftover, (1000.0, 1000.0))
    monkeypatch.setattr(store, "LIMIT_BYTES", 3 * size + size // 2)
    cache.load_or_make("shape", "0004", Maker())
    assert {entry.path.stem for entry in cache.entries()} == {"shape-0004", "shape-0000", "shape-0003"}
    assert not leftover.exists()
    assert cache.clear() == 3 * size
    assert cache.entries() == []


def test_two_concurrent_writers_leave_one_complete_file(folder):
    program = (
        "import numpy as np, sys\n"
        "from palpate.base import cache\n"
        "arrays = {'a': np.full(200_000, 7.0)}\n"
        "for k in range(40):\n"
        "    found = cache.load_or_make('rivals', f'{k % 4:04}', lambda: arrays)\n"
        "    assert found['a'].tobytes() == arrays['a'].tobytes()\n"
        "    if k % 3 == 0: cache.clear()\n"
    )
    rivals = [subprocess.Popen([sys.executable, "-c", program]) for _ in range(2)]
    assert [rival.wait(timeout=120) for rival in rivals] == [0, 0]
    assert list(folder.glob(".*.tmp")) == []
    assert all(store._read(entry.path) is not None for entry in cache.entries())


def test_key_depends_on_the_code_and_the_arguments(tmp_path):
    source = tmp_path / "maker.py"
    source.write_text("radius = 1")
    first = cache.source_key([source], "organ", 1000, 0)
    assert first == cache.source_key([source], "organ", 1000, 0)
    assert first != cache.source_key([source], "organ", 1000, 1)
    source.write_text("radius = 2")
    assert first != cache.source_key([source], "organ", 1000, 0)


@pytest.mark.parametrize("make", [shapes.organ, shapes.gallbladder])
def test_shape_from_the_cache_equals_the_original_shape(make):
    made = make(2500)
    kept = make(2500)
    assert len(cache.entries()) == 1
    cache.clear()
    again = make(2500)
    for one in (kept, again):
        assert [values.dtype for values in one] == [values.dtype for values in made]
        assert [values.tobytes() for values in one] == [values.tobytes() for values in made]


def test_records_are_the_same_with_and_without_the_cache(tmp_path, folder):
    from palpate import Scene, Session

    text = "objects: [{shape: organ, triangles: 3000}]\nrecord: {report: false}\n"
    digests = []
    for k in range(3):  # made, stored, made again
        session = Session(Scene.parse(text, str(tmp_path / "a.yaml")), out=tmp_path / f"{k}")
        digests.append(session.run(0.3).record_sha256)
        assert len(cache.entries()) == 1
        if k == 1:
            cache.clear()
    assert digests[0] is not None
    assert digests == [digests[0]] * 3
