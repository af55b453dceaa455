"""Files of point clouds: round trips in all formats, units, and damaged files."""

import struct

import numpy as np
import pytest

import palpate
from palpate.base.errors import CloudError
from palpate.world.clouds import MAX_POINTS, table

P = np.array([[0.5, 1.0, -2.0], [0.25, 0.0, 4.0], [0.125, 1.0, 1.0]])
N = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [0.6, 0.0, 0.8]])
C = np.array([[255, 0, 7], [1, 2, 3], [0, 0, 0]], dtype=np.uint8)


@pytest.mark.parametrize("suffix", [".pcd", ".ply", ".npz", ".xyz", ".csv"])
def test_what_is_saved_is_loaded_with_its_unit(tmp_path, suffix):
    palpate.PointCloud(P, N, C, viewpoint=[0.0, 0.0, 1.0]).save(tmp_path / f"a{suffix}")
    back = palpate.PointCloud.load(tmp_path / f"a{suffix}")
    assert back.points == pytest.approx(P, abs=1e-6)
    assert back.normals == pytest.approx(N, abs=1e-6)
    if suffix in (".pcd", ".ply", ".npz"):
        assert (back.colors == C).all()
    if suffix in (".pcd", ".npz"):
        assert back.viewpoint == pytest.approx([0.0, 0.0, 1.0])


def test_the_unit_is_asked_for(tmp_path):
    (tmp_path / "a.xyz").write_text("0 0 0\n10 0 0\n0 10 0\n")
    with pytest.raises(CloudError, match=r"unit of the cloud is not known(.|\n)*unit: m in a scene"):
        palpate.PointCloud.load(tmp_path / "a.xyz")
    assert palpate.PointCloud.load(tmp_path / "a.xyz", unit="mm").points.max() == pytest.approx(0.01)
    palpate.PointCloud(P).save(tmp_path / "b.ply")
    with pytest.raises(CloudError, match="states its unit m, but mm was given"):
        palpate.PointCloud.load(tmp_path / "b.ply", unit="mm")


def test_points_that_are_not_finite_are_left_out_with_their_colours():
    with_hole = P.copy()
    with_hole[1, 2] = np.nan
    found = palpate.PointCloud(with_hole, N, C)
    assert found.invalid == 1
    assert found.points == pytest.approx(P[[0, 2]])
    assert (found.colors == C[[0, 2]]).all()
    assert found.normals == pytest.approx(N[[0, 2]])


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (np.empty((0, 3)), "zero points"),
        (np.full((4, 3), np.nan), "none of the 4 points is finite"),
        (np.zeros((4, 2)), r"shape \(N, 3\)"),
        ([["a", "b", "c"]], "array of numbers"),
        (np.full((4, 3), 1e6), "another unit"),
    ],
)
def test_values_that_are_no_cloud_are_refused(points, message):
    with pytest.raises(CloudError, match=message):
        palpate.PointCloud(points)


def test_too_many_points_are_refused_before_they_are_read(tmp_path, monkeypatch):
    head = "# .PCD\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nPOINTS 50000000\nDATA binary\n"
    (tmp_path / "a.pcd").write_bytes(head.encode())
    with pytest.raises(CloudError, match=rf"50,000,000 points are more than {MAX_POINTS:,}(.|\n)*voxel grid"):
        palpate.PointCloud.load(tmp_path / "a.pcd", unit="m")
    monkeypatch.setattr(table, "MAX_POINTS", 2)
    with pytest.raises(CloudError, match="more than 2"):
        palpate.PointCloud(P)


@pytest.mark.parametrize(
    ("name", "data", "message"),
    [
        ("a.pcd", b"FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 9\nDATA binary\n1234", "are promised, 4 bytes"),
        ("a.pcd", b"FIELDS x y\nSIZE 4 4\nTYPE F F\nPOINTS 0\nDATA binary\n", "column 'z' is missing"),
        ("a.pcd", b"no header", "no line DATA"),
        ("a.ply", b"ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nend_header\n1", "promised"),
        ("a.ply", b"solid", "no PLY header"),
        ("a.npz", b"PK nothing", "not a readable NPZ"),
        ("a.csv", b"x,y,z\n1,2,3\n4,5\n", "3 columns"),
        ("a.csv", b"", "empty"),
        ("a.las", b"LASF", "unknown format"),
    ],
)
def test_damaged_files_are_named_with_their_damage(tmp_path, name, data, message):
    (tmp_path / name).write_bytes(data)
    with pytest.raises(CloudError, match=message):
        palpate.PointCloud.load(tmp_path / name, unit="m")


def test_a_file_that_is_missing_is_named(tmp_path):
    with pytest.raises(CloudError, match="not found"):
        palpate.PointCloud.load(tmp_path / "none.pcd", unit="m")


@pytest.mark.parametrize("kind", ["binary", "binary_compressed", "ascii"])
def test_padding_of_pcl_is_left_out(tmp_path, kind):
    """PCL names the padding of its points ``_``, as often as there is any: x y z _ rgb _ of 32 bytes."""
    rows = np.zeros(3, np.dtype([("p", "<f4", 3), ("a", "u1", 4), ("rgb", "<u4"), ("b", "u1", 12)]))
    rows["p"], rows["rgb"], rows["a"], rows["b"] = P, [0x0A0B0C] * 3, 9, 7
    head = (
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z _ rgb _\nSIZE 4 4 4 1 4 1\n"
        "TYPE F F F U U U\nCOUNT 1 1 1 4 1 12\nWIDTH 3\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3\n"
    )
    flat = b"".join(
        np.ascontiguousarray(c).tobytes() for c in (*rows["p"].T, rows["a"], rows["rgb"], rows["b"])
    )  # field by field
    literal = b"".join(bytes([len(flat[i : i + 32]) - 1]) + flat[i : i + 32] for i in range(0, len(flat), 32))
    body = {
        "binary": rows.tobytes(),
        "binary_compressed": np.array([len(literal), len(flat)], "<u4").tobytes() + literal,
        "ascii": "\n".join(" ".join(map(str, [*p, *[9] * 4, 0x0A0B0C, *[7] * 12])) for p in P).encode(),
    }[kind]
    (tmp_path / "a.pcd").write_bytes(head.encode() + f"DATA {kind}\n".encode() + body)
    found = palpate.PointCloud.load(tmp_path / "a.pcd", unit="m")
    assert found.points == pytest.approx(P)
    assert (found.colors == [10, 11, 12]).all()


PLY_HEAD = (
    "ply\nformat {form} 1.0\nelement camera 2\nproperty list uchar float k\nproperty double f\nelement vertex 3\n"
    "property float x\nproperty list uchar int view\nproperty float y\nproperty list ushort double w\n"
    "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n"
)
LISTS = ([1, 2, 3], [], [7])


@pytest.mark.parametrize("order", ["<", ">", ""])
def test_lists_and_other_elements_of_a_ply_are_left_out(tmp_path, order):
    """Photogrammetry writes which pictures saw a point as a list beside it, of another length in each row."""
    form = {"<": "binary_little_endian", ">": "binary_big_endian", "": "ascii"}[order]

    def pack(kind, *values):
        return struct.pack(order + kind, *values) if order else b" ".join(str(v).encode() for v in values) + b" "

    def packed(length, kind, values):
        return pack(length, len(values)) + (pack(f"{len(values)}{kind}", *values) if values else b"")

    end = b"" if order else b"\n"
    body = b"".join(packed("B", "f", k) + pack("d", 0.5) + end for k in ([1.0, 2.0], []))
    for p, c, view in zip(P, C, LISTS, strict=True):
        body += pack("f", p[0]) + packed("B", "i", view) + pack("f", p[1]) + packed("H", "d", view) + pack("f", p[2])
        body += pack("3B", *c) + end
    (tmp_path / "a.ply").write_bytes(PLY_HEAD.format(form=form).encode() + body)
    found = palpate.PointCloud.load(tmp_path / "a.ply", unit="m")
    assert found.points == pytest.approx(P)
    assert (found.colors == C).all()
    (tmp_path / "b.ply").write_bytes(PLY_HEAD.format(form=form).encode() + body[:-12])
    with pytest.raises(CloudError, match="are promised"):
        palpate.PointCloud.load(tmp_path / "b.ply", unit="m")


def test_a_ply_of_another_library_is_read(tmp_path):
    plyfile = pytest.importorskip("plyfile")
    rng = np.random.default_rng(0)
    for text in (True, False):
        rows = np.empty(40, [("x", "f4"), ("y", "f4"), ("z", "f4"), ("view", "O"), ("q", "f8")])
        points = rng.normal(size=(40, 3)).astype("f4")
        rows["x"], rows["y"], rows["z"] = points.T
        for row in rows:
            row["view"] = np.arange(rng.integers(0, 5), dtype="i4")
        element = plyfile.PlyElement.describe(rows, "vertex", val_types={"view": "i4"}, len_types={"view": "u1"})
        plyfile.PlyData([element], text=text, byte_order="<").write(str(tmp_path / "a.ply"))
        assert palpate.PointCloud.load(tmp_path / "a.ply", unit="m").points == pytest.approx(points, rel=1e-5)


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("depth.png", "x", "image of depths is no cloud without the camera[\\s\\S]*create_from_depth_image"),
        ("a.las", "x", "unknown format '.las'[\\s\\S]*CloudCompare"),
        ("a.bag", "x", "unknown format '.bag'[\\s\\S]*rs-convert"),
        ("groundtruth.txt", "# timestamp tx ty tz qx qy qz qw\n1.5 0 0 1 0 0 0 1\n", "lists poses or files"),
        ("depth.txt", "# timestamp filename\n1.5 depth/1.5.png\n", "lists poses or files"),
    ],
)
def test_depth_images_and_folders_of_tum_are_refused_with_the_tool(tmp_path, name, text, words):
    from palpate.sensing.replay import ReplaySource

    (tmp_path / name).write_text(text)
    with pytest.raises(CloudError, match=words):
        palpate.PointCloud.load(tmp_path / name, unit="m")
    if name in ("depth.png", "depth.txt"):
        with pytest.raises(CloudError, match=r"a folder of depth images[\s\S]*5000 in TUM RGB-D"):
            ReplaySource(tmp_path)
