"""PCD files in all three encodings, and clouds from meshes and arrays."""

import struct

import numpy as np
import pytest

from palpate.base.errors import RegistrationError
from palpate.world.clouds.pcd import lzf
from palpate.world.registration.cloud_files import averaged, read_cloud

P = np.array([[0.5, 1.0, -2.0], [0.25, 0.0, 4.0], [np.nan, 1.0, 1.0]], dtype=np.float32)


def pcd(kind: str, body: bytes) -> bytes:
    head = "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 3\nHEIGHT 1\n"
    return f"{head}VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3\nDATA {kind}\n".encode() + body


def literal(data: bytes) -> bytes:
    """LZF without back references."""
    runs = [data[i : i + 32] for i in range(0, len(data), 32)]
    packed = b"".join(bytes([len(run) - 1]) + run for run in runs)
    return struct.pack("<II", len(packed), len(data)) + packed


@pytest.mark.parametrize(
    ("kind", "body"),
    [
        ("ascii", b"0.5 1 -2\n0.25 0 4\nnan 1 1\n"),
        ("binary", P.tobytes()),
        ("binary_compressed", literal(P.T.tobytes())),
    ],
)
def test_pcd_is_read_without_missing_points(tmp_path, kind, body):
    (tmp_path / "a.pcd").write_bytes(pcd(kind, body))
    assert read_cloud(tmp_path / "a.pcd") == pytest.approx(P[:2])


def test_lzf_repeats_what_it_has_written():
    assert lzf(bytes([1]) + b"ab" + bytes([(3 << 5), 1]), 7) == b"abababa"  # five bytes from two back: they overlap
    assert lzf(bytes([0]) + b"x" + bytes([(7 << 5), 10, 0]), 20) == b"x" * 20
    with pytest.raises(ValueError, match="before the start"):
        lzf(bytes([(2 << 5), 1]), 4)


@pytest.mark.parametrize("damaged", [pcd("binary", P.tobytes()[:-4]), b"no header", pcd("binary_compressed", b"12")])
def test_damaged_pcd_is_refused(tmp_path, damaged):
    (tmp_path / "a.pcd").write_bytes(damaged)
    with pytest.raises(RegistrationError, match="not a readable PCD"):
        read_cloud(tmp_path / "a.pcd")


def test_clouds_come_from_arrays_and_meshes_in_their_unit(tmp_path):
    np.save(tmp_path / "a.npy", P[:2])
    assert read_cloud(tmp_path / "a.npy", "mm") == pytest.approx(1e-3 * P[:2])
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 10 0 0\nv 0 10 0\nf 1 2 3\n")
    points = read_cloud(tmp_path / "a.obj", "mm")
    assert points.max() == pytest.approx(0.01, abs=2e-4)
    (tmp_path / "b.npy").write_bytes(b"nothing")
    with pytest.raises(RegistrationError, match="cannot be read"):
        read_cloud(tmp_path / "b.npy")


def test_points_of_a_cell_are_averaged():
    p = np.array([[0.1, 0.1, 0.1], [0.3, 0.1, 0.1], [1.1, 0.1, 0.1]])
    assert averaged(p, 1.0) == pytest.approx(np.array([[0.2, 0.1, 0.1], [1.1, 0.1, 0.1]]))
