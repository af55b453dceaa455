"""Every advertised mesh format is read, in the unit that the file or its format states."""

import numpy as np
import pytest

import palpate.mesh.files as mesh_files
from palpate.errors import MeshError, MissingExtraError
from palpate.guidance.geometry import MESHES
from palpate.mesh import Mesh

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
    volumes = {".nrrd", ".nhdr", ".nii", ".nii.gz"}
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
