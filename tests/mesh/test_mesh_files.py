"""Invalid mesh files: each gives an error or a warning with a clear message."""

import os
import struct
import warnings
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from palpate.base.errors import MeshError, PalpateWarning
from palpate.world.mesh import Mesh

pytestmark = pytest.mark.filterwarnings(
    "ignore::palpate.base.errors.PalpateWarning"
)  # each test checks its own warnings
DATA = Path(os.environ.get("PALPATE_DATA", Path(__file__).parents[3] / "shared/data"))

# A cube of 40 mm; triangles are counter-clockwise seen from outside.
CUBE_V = 40.0 * np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
CUBE_T = np.array(
    [
        *([0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]),
        *([2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]),
    ]
)


def binary_stl(v=CUBE_V, t=CUBE_T, header=b"", promised=None) -> bytes:
    facets = b"".join(struct.pack("<12fH", 0, 0, 0, *v[row].ravel(), 0) for row in t)
    return header.ljust(80, b"\0") + struct.pack("<I", len(t) if promised is None else promised) + facets


def ascii_stl(v=CUBE_V, t=CUBE_T) -> bytes:
    text = "solid organ\n"
    for row in t:
        corners = "".join(f"      vertex {x!r} {y!r} {z!r}\n" for x, y, z in v[row].tolist())
        text += f"  facet normal 0 0 0\n    outer loop\n{corners}    endloop\n  endfacet\n"
    return (text + "endsolid organ\n").encode()


def write(folder, data: bytes, name="organ.stl") -> Path:
    path = folder / name
    path.write_bytes(data)
    return path


def assert_is_the_cube(mesh: Mesh) -> None:
    assert (mesh.report.vertices, mesh.report.triangles) == (8, 12)
    assert mesh.report.watertight
    assert mesh.report.volume_m3 == pytest.approx(0.04**3)
    np.testing.assert_allclose(mesh.bounds, [[0, 0, 0], [0.04, 0.04, 0.04]])


@pytest.mark.parametrize("data", [binary_stl(), ascii_stl()], ids=["binary", "ascii"])
def test_stl_loads_in_metres_without_a_warning(tmp_path, data):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert_is_the_cube(Mesh.load(write(tmp_path, data)))


@pytest.mark.parametrize(("unit", "size"), [("mm", 0.04), ("cm", 0.4)])
def test_unit_sets_the_scale(tmp_path, unit, size):
    assert max(Mesh.load(write(tmp_path, binary_stl()), unit).report.extents_m) == pytest.approx(size)


def test_unknown_unit_is_rejected(tmp_path):
    with pytest.raises(MeshError, match=r"unknown unit 'furlong'[\s\S]*use one of mm, cm, m, in"):
        Mesh.load(write(tmp_path, binary_stl()), "furlong")


@pytest.mark.parametrize("suffix", ["obj", "ply", "off"])
def test_other_formats_load(tmp_path, suffix):
    rows = [" ".join(str(x) for x in v) for v in CUBE_V.tolist()]
    if suffix == "obj":
        text = "".join(f"v {r}\n" for r in rows) + "".join(
            f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in CUBE_T.tolist()
        )
    elif suffix == "off":
        text = "OFF\n8 12 0\n" + "".join(f"{r}\n" for r in rows) + "".join(f"3 {a} {b} {c}\n" for a, b, c in CUBE_T)
    else:
        head = "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
        head += "element face 12\nproperty list uchar int vertex_indices\nend_header\n"
        text = head + "".join(f"{r}\n" for r in rows) + "".join(f"3 {a} {b} {c}\n" for a, b, c in CUBE_T)
    assert_is_the_cube(Mesh.load(write(tmp_path, text.encode(), f"organ.{suffix}")))


def test_error_for_a_missing_file_names_a_similar_file(tmp_path):
    write(tmp_path, binary_stl(), "liver.stl")
    with pytest.raises(MeshError, match=r"livr\.stl: mesh file not found\n  mend: did you mean .*liver\.stl\?"):
        Mesh.load(tmp_path / "livr.stl")


def test_folder_instead_of_a_file_is_rejected(tmp_path):
    with pytest.raises(MeshError, match="mesh file cannot be read"):
        Mesh.load(tmp_path)


def test_empty_file_is_rejected(tmp_path):
    with pytest.raises(MeshError, match=r"mesh file is empty \(0 bytes\)"):
        Mesh.load(write(tmp_path, b""))


@pytest.mark.parametrize("cut", [1, 30, 50, 550])
def test_truncated_binary_reports_promised_and_present_triangles(tmp_path, cut):
    present = 12 - -(-cut // 50)
    message = f"truncated binary STL: the header promises 12 triangles, the file holds {present}\n"
    with pytest.raises(MeshError, match=message):
        Mesh.load(write(tmp_path, binary_stl()[:-cut]))


def test_truncated_header_is_rejected(tmp_path):
    with pytest.raises(MeshError, match="not an STL file: 40 bytes"):
        Mesh.load(write(tmp_path, b"\0" * 40))


def test_bytes_after_the_end_are_reported(tmp_path):
    with pytest.warns(PalpateWarning, match="7 bytes after the 12 triangles"):
        assert_is_the_cube(Mesh.load(write(tmp_path, binary_stl() + b"\0" * 7)))


def test_truncated_ascii_is_rejected(tmp_path):
    cut = b"endfacet".join(ascii_stl().split(b"endfacet")[:7])  # the seventh facet has no end
    with pytest.raises(MeshError, match="truncated or malformed ASCII STL: 7 facets begun, 6 ended, 21 vertices"):
        Mesh.load(write(tmp_path, cut))


def test_ascii_with_a_word_for_a_number_is_reported_with_the_line(tmp_path):
    data = ascii_stl().replace(b"vertex 0.0 0.0 0.0", b"vertex 0.0 zero 0.0", 1)
    with pytest.raises(MeshError, match=r"organ\.stl:4: not three numbers: 'vertex 0.0 zero 0.0'"):
        Mesh.load(write(tmp_path, data))


def test_ascii_named_binary_loads_with_a_warning(tmp_path):
    with pytest.warns(PalpateWarning, match="an ASCII STL under a binary name: read as ASCII"):
        assert_is_the_cube(Mesh.load(write(tmp_path, ascii_stl(), "organ.stlb")))


@pytest.mark.parametrize(("header", "name"), [(b"solid organ", "organ.stl"), (b"", "organ.stla")])
def test_binary_with_an_ascii_header_loads_with_a_warning(tmp_path, header, name):
    with pytest.warns(PalpateWarning, match="a binary STL that calls itself ASCII: read as binary"):
        assert_is_the_cube(Mesh.load(write(tmp_path, binary_stl(header=header), name)))


def test_file_without_triangles_is_rejected(tmp_path):
    with pytest.raises(MeshError, match="the STL holds zero triangles"):
        Mesh.load(write(tmp_path, binary_stl(t=CUBE_T[:0])))
    with pytest.raises(MeshError, match="the STL holds zero triangles"):
        Mesh.load(write(tmp_path, b"solid organ\nendsolid organ\n"))


def test_points_without_faces_are_rejected(tmp_path):
    with pytest.raises(MeshError, match="the mesh holds zero triangles"):
        Mesh.load(write(tmp_path, b"OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n", "cloud.off"))


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("encode", [binary_stl, ascii_stl])
def test_values_that_are_not_finite_are_rejected(tmp_path, value, encode):
    v = CUBE_V.copy()
    v[2, 1] = value
    with pytest.raises(MeshError, match=r"vertices are not finite; the first is vertex 5: \(0, -?(nan|inf), 0\)"):
        Mesh.load(write(tmp_path, encode(v)))


def test_planar_vertices_are_rejected(tmp_path):
    with pytest.raises(MeshError, match="vertices have 2 coordinates; three are needed"):
        Mesh.load(write(tmp_path, b"v 0 0\nv 40 0\nv 0 40\nf 1 2 3\n", "flat.obj"))


def test_git_lfs_pointer_is_reported(tmp_path):
    with pytest.raises(MeshError, match=r"Git LFS pointer[\s\S]*git lfs pull"):
        Mesh.load(write(tmp_path, b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 9\n"))


def test_error_for_an_unknown_format_lists_the_known_formats(tmp_path):
    with pytest.raises(MeshError, match=r"unknown mesh format '\.step'[\s\S]*\.stl, \.obj"):
        Mesh.load(write(tmp_path, b"ISO-10303-21;", "organ.step"))


@pytest.mark.parametrize("suffix", ["obj", "ply", "off", "glb", "3mf"])
def test_garbage_under_any_name_is_a_mesh_error(tmp_path, suffix):
    with pytest.raises(MeshError):
        Mesh.load(write(tmp_path, bytes(range(256)) * 4, f"organ.{suffix}"))


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    data=st.one_of(
        st.binary(max_size=400),
        st.tuples(st.integers(0, 683), st.binary(max_size=8)).map(
            lambda x: binary_stl()[: x[0]] + x[1] + binary_stl()[x[0] + len(x[1]) :]
        ),
        st.tuples(st.integers(0, 2000), st.binary(max_size=8)).map(
            lambda x: ascii_stl()[: x[0]] + x[1] + ascii_stl()[x[0] + len(x[1]) :]
        ),
    )
)
@example(data=binary_stl(promised=2**32 - 1))
@example(data=b"solid\nfacet normal\nendfacet")
def test_any_bytes_give_a_mesh_or_a_mesh_error(tmp_path, data):
    path = write(tmp_path, data)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PalpateWarning)
        try:
            mesh = Mesh.load(path)
        except MeshError:
            return
    assert np.isfinite(mesh.vertices).all()
    assert len(mesh.triangles) > 0


@pytest.mark.skipif(not DATA.is_dir(), reason=f"real meshes not found in {DATA} (set PALPATE_DATA)")
@pytest.mark.parametrize("name", ["Liver", "Kidney_right", "Stomach", "Spleen", "Duodenum", "gallbladder_visual"])
def test_real_organs_are_watertight_and_organ_sized(name):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        report = Mesh.load(DATA / "meshes" / f"{name}.stl").report
    assert report.watertight
    assert report.components == 1
    assert 2e-5 < report.volume_m3 < 3e-3


@pytest.mark.skipif(not DATA.is_dir(), reason=f"real meshes not found in {DATA} (set PALPATE_DATA)")
def test_open_liver_of_many_parts_loads_with_warnings():
    with pytest.warns(PalpateWarning, match="the surface is open: 182 edges have one triangle only"):
        report = Mesh.load(DATA / "meshes/liver_visual.stl").report
    assert not report.watertight
    assert report.triangles == 28716
