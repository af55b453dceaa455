"""Every advertised mesh format is read, in the unit that the file or its format states."""

import struct

import numpy as np
import pytest

import palpate.world.mesh.files as mesh_files
from palpate.base.errors import MeshError, MissingExtraError
from palpate.scene.guidance.geometry import MESHES
from palpate.world.mesh import Mesh

trimesh = pytest.importorskip("trimesh")

DAE = """<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><created>2026-01-01T00:00:00Z</created><modified>2026-01-01T00:00:00Z</modified>
<unit name="centimeter" meter="0.01"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="{count}">{numbers}</float_array><technique_common>
<accessor source="#pa" count="{points}" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="{triangles}"><input semantic="VERTEX" source="#v" offset="0"/><p>{corners}</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#g"/></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>"""

VTP = """<?xml version="1.0"?><VTKFile type="PolyData" version="0.1"><PolyData><Piece NumberOfPoints="{points}"
 NumberOfVerts="0" NumberOfLines="0" NumberOfStrips="0" NumberOfPolys="{triangles}"><Points><DataArray type="Float32"
 NumberOfComponents="3" format="ascii">{numbers}</DataArray></Points><Polys><DataArray type="Int32" Name="connectivity"
 format="ascii">{corners}</DataArray><DataArray type="Int32" Name="offsets" format="ascii">{ends}</DataArray></Polys>
</Piece></PolyData></VTKFile>"""

VTK = """# vtk DataFile Version 3.0
box
ASCII
DATASET POLYDATA
POINTS {points} float
{numbers}
POLYGONS {triangles} {size}
{polygons}
"""


def box(side):
    made = trimesh.creation.box((side,) * 3)
    return made.vertices, made.faces


def fill(template, side):
    v, t = box(side)
    return template.format(
        points=len(v), count=v.size, triangles=len(t), size=4 * len(t),
        numbers=" ".join(f"{x:g}" for x in v.ravel()), corners=" ".join(map(str, t.ravel())),
        ends=" ".join(str(3 * i + 3) for i in range(len(t))),
        polygons="\n".join("3 " + " ".join(map(str, row)) for row in t.tolist()),
    )  # fmt: skip


#: Ending: side of a box of 40 mm in the unit of the format, and the package that reads it.
SIDES = {
    ".stl": (40.0, ""), ".obj": (40.0, ""), ".ply": (40.0, ""), ".off": (40.0, ""), ".glb": (0.04, ""),
    ".gltf": (0.04, ""), ".3mf": (40.0, "lxml"), ".dae": (4.0, "collada"), ".vtk": (40.0, "vtkmodules"),
    ".vtp": (40.0, "vtkmodules"),
}  # fmt: skip


def write(folder, ending):
    """A box of 40 mm in a file of this format."""
    side, path = SIDES[ending][0], folder / f"box{ending}"
    template = {".dae": DAE, ".vtp": VTP, ".vtk": VTK}.get(ending)
    if template is not None:
        path.write_text(fill(template, side))
    elif ending == ".gltf":
        for name, data in trimesh.exchange.gltf.export_gltf(trimesh.Scene(trimesh.Trimesh(*box(side)))).items():
            (folder / name).write_bytes(data)
        path = folder / "model.gltf"
    else:
        trimesh.Trimesh(*box(side)).export(str(path))
    return path


@pytest.mark.parametrize("ending", SIDES)
def test_format_is_read_in_its_unit(tmp_path, ending):
    if SIDES[ending][1]:
        pytest.importorskip(SIDES[ending][1], reason="extra files or vtk")
        pytest.importorskip("networkx", reason="extra files")
    mesh = Mesh.load(write(tmp_path, ending))
    assert mesh.report.watertight
    assert mesh.report.triangles == 12
    np.testing.assert_allclose(np.ptp(mesh.bounds, axis=0), 0.04, rtol=1e-6)


def test_every_advertised_format_is_tested():
    volumes = {".nrrd", ".nhdr", ".nii", ".nii.gz", ".mha", ".mhd"}
    assert set(mesh_files.FORMATS) - volumes == set(SIDES)
    assert set(MESHES) <= set(SIDES)


def test_given_unit_takes_precedence_over_that_of_the_format(tmp_path):
    mesh = Mesh.load(write(tmp_path, ".glb"), unit="in")
    np.testing.assert_allclose(np.ptp(mesh.bounds, axis=0), 0.04 * 0.0254, rtol=1e-6)
    assert mesh.unit == "in"


@pytest.mark.parametrize("ending", [".vtk", ".vtp", ".3mf", ".dae"])
def test_damaged_file_is_refused(tmp_path, ending):
    pytest.importorskip(SIDES[ending][1], reason="extra files or vtk")
    pytest.importorskip("networkx", reason="extra files")
    (tmp_path / f"a{ending}").write_bytes(b"not a mesh")
    with pytest.raises(MeshError, match=rf"not a readable {ending} file|zero triangles"):
        Mesh.load(tmp_path / f"a{ending}")


def test_missing_package_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr(mesh_files.importlib.util, "find_spec", lambda name: None)
    (tmp_path / "a.3mf").write_bytes(b"x")
    with pytest.raises(MissingExtraError, match=r"the reader of \.3mf files is not installed[\s\S]*palpate\[files\]"):
        Mesh.load(tmp_path / "a.3mf")


# -- OFF with polygons ------------------------------------------------------------------------------------------

L_SHAPE = np.array([(0, 0), (30, 0), (30, 10), (10, 10), (10, 30), (0, 30)], float)  # 500 mm^2, concave


def prism(outline, height=20.0):
    """Vertices and faces, polygons as they are, counter-clockwise from outside."""
    n = len(outline)
    vertices = np.vstack([np.c_[outline, np.zeros(n)], np.c_[outline, np.full(n, height)]])
    sides = [[i, (i + 1) % n, n + (i + 1) % n, n + i] for i in range(n)]
    return vertices, [list(range(n))[::-1], list(range(n, 2 * n)), *sides]


@pytest.mark.parametrize("head", ["OFF\n{n} {m} 0\n", "OFF {n} {m} 0\n", "# by hand\nCOFF\n\n{n} {m} 0 # counts\n"])
@pytest.mark.parametrize("colour", ["", " 255 0 0"])
@pytest.mark.parametrize("turn", [0, 1, 2, 3, 4, 5])
def test_off_files_of_polygons_are_read(tmp_path, head, colour, turn):
    """An L-shaped prism: its concave face must not be cut as a fan. Turned, so that each corner begins once."""
    vertices, faces = prism(np.roll(L_SHAPE, turn, axis=0))
    rows = [" ".join(map(str, p)) + (" 1 0 0 1" if "COFF" in head else "") for p in vertices]
    rows += [f"{len(f)} " + " ".join(map(str, f)) + colour for f in faces]
    (tmp_path / "a.off").write_text(head.format(n=len(vertices), m=len(faces)) + "\n".join(rows) + "\n")
    mesh = Mesh.load(tmp_path / "a.off", "mm")
    assert mesh.report.watertight
    assert mesh.report.inverted == 0
    assert mesh.report.volume_m3 == pytest.approx(500e-6 * 20e-3, rel=1e-6)
    a, b, c = (np.asarray(mesh.vertices)[np.asarray(mesh.triangles)[:, k]] for k in range(3))
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
    assert area == pytest.approx(2 * 500e-6 + 120e-3 * 20e-3, rel=1e-6)  # a fan would overlap itself


@pytest.mark.parametrize(
    "text", ["4OFF\n1 1 0\n0 0 0 0\n", "OFF BINARY\n", "nOFF\n3\n", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n"]
)
def test_other_off_files_are_refused(tmp_path, text):
    (tmp_path / "a.off").write_text(text)
    with pytest.raises(MeshError, match=r"not a readable \.off file"):
        Mesh.load(tmp_path / "a.off")


@pytest.mark.parametrize("order", ["<", ">", ""])
def test_a_ply_whose_vertices_have_lists_is_a_mesh(tmp_path, order):
    """As photogrammetry writes it; trimesh does not read the binary forms. A cube with its quads."""
    vertices, faces = prism(np.array([(0, 0), (20, 0), (20, 20), (0, 20)], float))
    form = {"<": "binary_little_endian", ">": "binary_big_endian", "": "ascii"}[order]
    head = (
        f"ply\nformat {form} 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
        "property list uchar int view\nelement face 6\nproperty list uchar uint vertex_indices\nend_header\n"
    )
    if order:
        rows = [struct.pack(f"{order}3fB{k}i", *p, k, *range(k)) for k, p in enumerate(vertices)]
        rows += [struct.pack(f"{order}B4I", 4, *f) for f in faces]
    else:
        rows = [" ".join(map(str, [*p, k, *range(k)])).encode() + b"\n" for k, p in enumerate(vertices)]
        rows += [" ".join(map(str, [4, *f])).encode() + b"\n" for f in faces]
    (tmp_path / "a.ply").write_bytes(head.encode() + b"".join(rows))
    mesh = Mesh.load(tmp_path / "a.ply", "mm")
    assert mesh.report.watertight
    assert mesh.report.volume_m3 == pytest.approx(8e-6, rel=1e-6)
