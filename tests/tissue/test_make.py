"""Filling closed surfaces, and files with tetrahedra."""

import numpy as np
import pytest

from palpate.base.errors import MeshError
from palpate.world.mesh import Mesh
from palpate.world.mesh import repair as mesh_repair
from palpate.world.mesh.mesh import quiet
from palpate.world.tissue import TetMesh, load, make, save, tetrahedralize
from palpate.world.tissue.blocks import block

CUBE = (2, 2, 2), (0.02, 0.02, 0.02)  # cells and size [m]


def cube(size=0.02, n=1):
    mesh = TetMesh(*block((n, n, n), (size, size, size)))
    return mesh.nodes, mesh.surface


@pytest.fixture
def _own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))


@pytest.mark.usefixtures("_own_cache")
def test_a_cube_is_filled_once_and_then_read_from_the_cache(monkeypatch):
    pytest.importorskip("pytetwild", reason="extra tissue")
    surface, lines = Mesh(*cube(), name="cube"), []
    mesh = tetrahedralize(surface, 0.01, tell=lines.append)
    assert mesh.volumes.sum() == pytest.approx(8e-6, rel=1e-3)
    assert mesh.parts == 1
    assert len([line for line in lines if "still filling" not in line]) == 2
    assert "filling 12 triangles" in lines[0]
    monkeypatch.setattr(make, "_fill", None)
    again = tetrahedralize(surface, 0.01, tell=lines.append)
    np.testing.assert_array_equal(again.tets, mesh.tets)
    assert len([line for line in lines if "still filling" not in line]) == 2


def test_an_open_surface_is_refused_with_the_mend():
    v, t = cube()
    with quiet(), pytest.raises(MeshError, match="the surface is open: 3 edges") as error:
        tetrahedralize(Mesh(v, t[1:], name="cube.stl"), 0.01)
    width = 29  # mm, the diagonal of a side, rounded up
    assert f"palpate check cube.stl --repair mended.stl --hole {width} closes it (holes filled: 1)" in error.value.mend


def test_a_hole_that_the_repair_does_not_close_is_said(monkeypatch):
    monkeypatch.setattr(mesh_repair, "LONGEST_LOOP", 2)
    v, t = cube()
    with quiet(), pytest.raises(MeshError) as error:
        tetrahedralize(Mesh(v, t[1:], name="cube.stl"), 0.01)
    assert "would leave holes of up to 28.3 mm open" in error.value.mend


@pytest.mark.parametrize(("edge", "words"), [(1e-5, "tetrahedra"), (0.5, "do not fit")])
def test_a_hopeless_resolution_is_refused(edge, words):
    with pytest.raises(MeshError, match=words):
        tetrahedralize(Mesh(*cube()), edge)


@pytest.mark.usefixtures("_own_cache")
def test_a_surface_that_encloses_a_part_twice_is_refused(monkeypatch):
    """A cube of 8 ml inside a cube of 64 ml, both with their normals outward: a mesher fills 64 ml."""
    pytest.importorskip("pytetwild", reason="extra tissue")
    (v, t), (inner, _) = cube(0.04), cube(0.02)
    twice = Mesh(np.vstack([v, inner + 0.01]), np.vstack([t, t + len(v)]), name="twice")
    monkeypatch.setattr(
        make, "_fill", lambda *_: dict(zip(("nodes", "tets"), block((2, 2, 2), (0.04,) * 3), strict=True))
    )
    with pytest.raises(MeshError, match="72 ml by its triangles, but 64 ml were filled"):
        tetrahedralize(twice, 0.04)
    assert len(tetrahedralize(Mesh(v, t), 0.04).tets) == 48  # the same filling of the outer cube alone is accepted


@pytest.mark.usefixtures("_own_cache")
def test_a_mesher_that_fails_is_told_with_its_last_message(monkeypatch, tmp_path):
    pytest.importorskip("pytetwild", reason="extra tissue")
    (tmp_path / "fill.py").write_text("print('first'); raise SystemExit('no memory')")
    monkeypatch.setattr(make.Path, "with_name", lambda *_: tmp_path / "fill.py")
    with pytest.raises(MeshError, match=r"the mesher failed \(exit 1\)") as error:
        tetrahedralize(Mesh(*cube(), name="cube"), 0.01)
    assert error.value.why == "no memory"


@pytest.mark.parametrize("ending", ["vtk", "vtu", "msh", "mesh"])
def test_files_keep_nodes_tetrahedra_and_regions(tmp_path, ending):
    pytest.importorskip("meshio", reason="extra tissue")
    nodes, tets = block(*CUBE)
    region = (np.arange(len(tets)) % 3 == 0).astype(np.int32)
    path = tmp_path / f"block.{ending}"
    save(TetMesh(nodes, tets, region), path, unit="cm")
    read = load(path, unit="cm")
    np.testing.assert_allclose(read.nodes, nodes, atol=1e-12)
    np.testing.assert_array_equal(read.tets, tets)
    np.testing.assert_array_equal(read.region, region)


def test_files_that_cannot_be_used_are_named(tmp_path):
    meshio = pytest.importorskip("meshio", reason="extra tissue")
    damaged, surface = tmp_path / "damaged.vtk", tmp_path / "surface.vtk"
    damaged.write_text("nothing of the kind")
    meshio.write(surface, meshio.Mesh(np.eye(3), [("triangle", [[0, 1, 2]])]))
    for path, words in [
        (damaged, "not a readable file"),
        (surface, "no tetrahedra; it has triangle"),
        (tmp_path / "absent.vtk", "no such file"),
        (tmp_path / "volume.stl", "unknown ending"),
    ]:
        with pytest.raises(MeshError, match=words):
            load(path)
    with pytest.raises(MeshError, match="unknown unit"):
        load(surface, unit="foot")
