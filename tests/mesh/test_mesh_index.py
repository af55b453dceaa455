"""A mesh read from its image is the mesh that was built; damaged images are refused; large meshes use the cache."""

import functools
import itertools
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from palpate import Mesh, _core
from palpate.base import cache
from palpate.world.mesh import files, index, quiet
from palpate.world.shapes.analytic import SHAPES

BALL = trimesh.creation.icosphere(subdivisions=3, radius=0.03)
SOUP = {  # a closed ball, an open disc, and three triangles at one edge
    "ball": (BALL.vertices, BALL.faces),
    "half": (BALL.vertices, BALL.faces[BALL.triangles_center[:, 2] > 0.0]),
    "fin": (
        np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1]], float),
        [[0, 1, 2], [1, 0, 3], [0, 1, 4]],
    ),
}  # fmt: skip


def core(name):
    vertices, triangles = SOUP[name]
    return _core.Mesh(np.ascontiguousarray(vertices, float), np.ascontiguousarray(triangles, dtype=np.int32))


def report(mesh):
    r = mesh.report
    return {name: np.array(getattr(r, name)).tolist() for name in dir(r) if not name.startswith("_")}


@pytest.mark.parametrize("name", SOUP)
def test_the_image_gives_the_same_mesh(name):
    rng = np.random.default_rng(3)
    built = core(name)
    read = _core.Mesh.from_image(built.image())
    assert report(read) == report(built)
    assert len(report(read)) > 10
    points = rng.normal(size=(500, 3)) * 0.04
    for a, b in zip(built.closest(points), read.closest(points), strict=True):
        np.testing.assert_array_equal(a, b)
    np.testing.assert_array_equal(built.contains(points), read.contains(points))
    np.testing.assert_array_equal(built.rims(), read.rims())
    for a, b in itertools.pairwise(points[:50]):
        assert built.sweep(a, b, 1e-3) == read.sweep(a, b, 1e-3)


IMAGE = core("half").image()


def test_the_arrays_stay_in_the_image_which_outlives_the_mesh():
    room = np.zeros(len(IMAGE) + 40, np.uint8)
    begin = -room.ctypes.data % 32
    odd, image = room[begin + 8 :][: len(IMAGE)], room[begin:][: len(IMAGE)]
    odd[:] = IMAGE
    assert not np.shares_memory(_core.Mesh.from_image(odd).vertices, odd), "copied to where it is aligned"
    image[:] = IMAGE
    mesh = _core.Mesh.from_image(image)
    assert np.shares_memory(mesh.vertices, image)
    assert np.shares_memory(mesh.triangles, image)
    image.flags.writeable = False
    vertices = mesh.vertices
    del room, odd, image, mesh
    np.testing.assert_array_equal(vertices, core("half").vertices)


@pytest.mark.parametrize("name", SOUP)
def test_the_pieces_of_an_image_are_the_image(name):
    built = core(name)
    pieces = built.image_pieces()
    np.testing.assert_array_equal(np.concatenate(pieces), built.image())
    assert any(np.shares_memory(piece, built.vertices) for piece in pieces)


def test_welded_triangles_become_the_same_mesh_once():
    vertices, triangles = (np.ascontiguousarray(a, t) for a, t in zip(SOUP["half"], (float, np.int32), strict=True))
    welded = _core.Welded(vertices, triangles)
    np.testing.assert_array_equal(welded.mesh().image(), IMAGE)
    with pytest.raises(ValueError, match="a mesh already"):
        welded.mesh()
    with pytest.raises(ValueError, match="names vertex 99999"):
        _core.Welded(vertices, np.array([[0, 1, 99999]], np.int32))


@settings(max_examples=600, deadline=None)
@given(st.integers(0, len(IMAGE) - 1), st.integers(1, 255))
def test_a_changed_byte_is_refused_or_harmless(at, change):
    """No change of one byte crashes a query or makes it endless: indices are checked, and numbers are only numbers."""
    changed = IMAGE.copy()
    changed[at] ^= change
    try:
        mesh = _core.Mesh.from_image(changed)
    except ValueError:
        return
    mesh.closest(BALL.vertices[:40])


@pytest.mark.parametrize("length", [0, 7, 8, 100, len(IMAGE) // 2, len(IMAGE) - 1])
def test_a_truncated_image_is_refused(length):
    with pytest.raises(ValueError, match="stored index"):
        _core.Mesh.from_image(IMAGE[:length].copy())


def test_an_image_with_bytes_after_it_is_refused():
    with pytest.raises(ValueError, match="damaged"):
        _core.Mesh.from_image(np.concatenate([IMAGE, np.zeros(8, np.uint8)]))


@pytest.mark.parametrize("from_end", [57, 58])
def test_a_flag_that_is_neither_true_nor_false_is_refused(from_end):
    """`two_sided` and `closed` stand before the volume and two corners: reading another value is undefined in C++."""
    changed = IMAGE.copy()
    assert changed[-from_end] <= 1
    changed[-from_end] = 101
    with pytest.raises(ValueError, match="damaged"):
        _core.Mesh.from_image(changed)


@functools.cache
def hierarchy():
    """Offset of the nodes of the hierarchy in IMAGE, and their number: only this place fits the image's length."""
    node, block, after = 480, 9 * 4 * 8 + 4 * 4, 3 * 8 + 8 + 11 * 8 + 2 + 8 + 6 * 8  # sizes [bytes]
    found = []
    for start in range(8):
        words = np.frombuffer(IMAGE[start : start + (len(IMAGE) - start) // 8 * 8].tobytes(), np.uint64)
        likely = np.flatnonzero((words[:-1] > 0) & (words[:-1] < 1_000_000) & (words[1:] < 1_000_000))
        for k in likely.tolist():
            at, nodes, blocks = start + 8 * k + 16, int(words[k]), int(words[k + 1])
            if at + nodes * node + blocks * block + after == len(IMAGE):
                found.append((at, nodes))
    (place,) = found
    return place


def with_children(children):
    """The image with other children at some (node, lane); children: from the number of nodes."""
    at, count = hierarchy()
    changed = IMAGE.copy()
    nodes = changed[at : at + 480 * count].reshape(count, 480)
    for (node, lane), child in children(count).items():
        nodes[node, 448 + 4 * lane : 452 + 4 * lane] = np.frombuffer(np.int32(child).tobytes(), np.uint8)
    return changed


def test_the_same_children_make_the_same_image():
    at, count = hierarchy()
    children = IMAGE[at : at + 480 * count].reshape(count, 480)[:, 448:].copy().view(np.int32)
    assert sorted(children[children > 0]) == list(range(1, count)), "each node but the root has one parent"
    same = with_children(lambda _: {(n, i): children[n, i] for n in range(count) for i in range(8)})
    np.testing.assert_array_equal(same, IMAGE)


@pytest.mark.parametrize(
    "children",
    [
        lambda count: {(n, lane): n + 1 if lane == 0 else -1 for n in range(count - 1) for lane in range(8)},
        lambda count: {(0, 0): 1, (0, 1): 1},
        lambda count: {(count - 1, 0): 1},
        lambda count: {(0, lane): -1 for lane in range(8)},
        lambda count: {(count - 1, 0): count},
    ],
    ids=["deeper than the stack of a query", "two parents", "a loop", "without a parent", "beyond the last node"],
)
def test_a_hierarchy_that_is_no_shallow_tree_is_refused(children):
    """A query has a stack of fixed size: found by fuzzing, nodes in a row of 42 and more wrote beyond it."""
    with pytest.raises(ValueError, match="damaged"):
        _core.Mesh.from_image(with_children(children))


@pytest.mark.parametrize("side", ["lower", "upper"])
@pytest.mark.parametrize("axis", range(3))
def test_an_unused_child_whose_box_is_not_empty_is_refused(axis, side):
    """A query would visit it as the root, again and again: found by fuzzing, where only the x axis was checked."""
    at, count = hierarchy()
    changed = IMAGE.copy()
    nodes = changed[at : at + 480 * count].reshape(count, 480)
    unused = np.argwhere(nodes[:, 448:].copy().view(np.int32) == 0)
    assert len(unused), "the ball has a node with fewer than eight children"
    node, lane = unused[0]
    place = (0 if side == "lower" else 96) + 32 * axis + 4 * lane
    nodes[node, place : place + 4] = np.frombuffer(np.float32(0.0).tobytes(), np.uint8)
    with pytest.raises(ValueError, match="damaged"):
        _core.Mesh.from_image(changed)


@pytest.fixture
def cached(tmp_path, monkeypatch):
    """A user's cache of its own, used for meshes of any size."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(index, "CACHED_FROM", 1)


def test_a_large_mesh_is_indexed_once(cached, monkeypatch):
    with quiet():
        first = Mesh(BALL.vertices, BALL.faces)
        assert [entry.kind for entry in cache.entries()] == ["mesh_index"]
        second = Mesh(BALL.vertices, BALL.faces)
        assert len(cache.entries()) == 1, "read"
        Mesh(BALL.vertices * 1.001, BALL.faces)
        assert len(cache.entries()) == 2, "another shape has another index"
    np.testing.assert_array_equal(first.triangles, second.triangles)
    assert report(first.core) == report(second.core)
    assert first.report == second.report


def test_a_small_mesh_leaves_no_file(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    Mesh(BALL.vertices, BALL.faces)
    assert cache.entries() == []


def test_a_foreign_file_in_the_cache_is_ignored(cached):
    Mesh(BALL.vertices, BALL.faces)
    for content in (np.zeros(100, np.uint64), np.zeros(100, np.uint8), np.zeros(0, np.uint64)):
        np.save(cache.entries()[0].path, content)
        assert len(Mesh(BALL.vertices, BALL.faces).triangles) == len(BALL.faces)


def test_a_flipped_bit_of_a_stored_index_is_seen(cached):
    """It might be the bit of a coordinate, which no other check sees."""
    Mesh(BALL.vertices, BALL.faces)
    (entry,) = cache.entries()
    data = bytearray(entry.path.read_bytes())
    for at in range(128, len(data), len(data) // 50):
        data[at] ^= 1 << at % 8
        entry.path.write_bytes(data)
        assert cache.load_bytes("mesh_index", entry.path.stem.rpartition("-")[2]) is None
        data[at] ^= 1 << at % 8


def test_a_mesh_from_the_cache_stays_in_its_file(cached):
    with quiet():
        Mesh(BALL.vertices, BALL.faces)
        mesh = Mesh(BALL.vertices, BALL.faces)
    place = mesh.vertices.ctypes.data
    with open("/proc/self/maps") as maps:
        areas = [line.split() for line in maps if "mesh_index" in line]
    spans = [tuple(int(end, 16) for end in area[0].split("-")) for area in areas]
    assert any(begin <= place < end for begin, end in spans), "mapped, not copied"
    mesh.core.closest(np.zeros((1, 3)), np.inf)


@pytest.mark.parametrize("sizes", [(0,), (8,), (3, 0, 21), (1, 7, 64, 5)])
def test_pieces_of_any_length_are_kept_in_the_cache(cached, sizes):
    pieces = [np.random.default_rng(n).integers(0, 256, n, np.uint8) for n in sizes]
    cache.keep_bytes("mesh_index", "pieces", pieces)
    np.testing.assert_array_equal(cache.load_bytes("mesh_index", "pieces"), np.concatenate(pieces))


PEAK = """
import sys
from palpate.world.mesh import Mesh
from palpate_lab.verify.bench.contact import _status_mb
import palpate.scene
before = _status_mb("VmRSS")
mesh = Mesh.load(sys.argv[1])
print((_status_mb("VmHWM") - before) * 1e6 / len(mesh.triangles))
"""


def test_a_large_mesh_takes_few_bytes_a_triangle_while_it_is_read_and_kept(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    if not Path("/proc/self/status").exists():
        pytest.skip("the peak of memory is told by Linux alone")
    path = tmp_path / "torus.stl"
    vertices, triangles = SHAPES["torus"].mesh(320_000)
    files.write(path, 1e3 * vertices, triangles)
    done = subprocess.run([sys.executable, "-c", PEAK, path], capture_output=True, text=True, check=True)
    assert float(done.stdout) < 250, "[bytes]; 410 with a copy of the arrays and of the index"
    assert [entry.kind for entry in cache.entries() if entry.kind == "mesh_index"], "it was kept"


def test_a_known_file_is_not_read_again(cached, tmp_path, monkeypatch):
    monkeypatch.setattr(index, "CACHED_SIZE", 1)
    path = tmp_path / "ball.stl"
    BALL.export(path)
    with quiet():
        first = Mesh.load(path)
        monkeypatch.setattr(files, "read_with_unit", None)
        second = Mesh.load(path)
    assert second.unit == "mm"
    assert second.report == first.report
    np.testing.assert_array_equal(first.vertices, second.vertices)
    np.testing.assert_array_equal(first.triangles, second.triangles)
    with pytest.raises(TypeError):
        Mesh.load(path, "cm")  # another unit is another mesh
    path.write_bytes(path.read_bytes()[:-1] + b"\1")
    with pytest.raises(TypeError):
        Mesh.load(path)


def test_small_mesh_is_indexed_once_while_it_is_among_the_last():
    """Equal arrays share the core mesh; another coordinate is another mesh, and the oldest is forgotten."""
    vertices, triangles = np.eye(3), np.array([[0, 1, 2]], np.int32)
    first, key = index.build([(vertices, triangles)])
    assert key == ""
    assert index.build([(vertices.copy(), triangles.copy())])[0] is first
    for k in range(index.KEPT):
        other = index.build([(vertices + k + 1.0, triangles)])[0]
        assert other is not first
        assert np.array_equal(other.vertices, vertices + k + 1.0)
    assert index.build([(vertices, triangles)])[0] is not first
