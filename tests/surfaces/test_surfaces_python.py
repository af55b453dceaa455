"""Typed constructors, drawings, grids from meshes and files; invalid input is reported with a remedy."""

import gzip

import numpy as np
import pytest
import trimesh

from palpate.base.errors import PalpateWarning, SurfaceError
from palpate.world import surfaces
from palpate.world.mesh import Mesh
from palpate.world.shapes.analytic import SHAPES

ALL = [
    surfaces.Plane(),
    surfaces.Sphere(0.03),
    surfaces.Box((0.04, 0.03, 0.02)),
    surfaces.Cylinder(0.02, 0.05),
    surfaces.Capsule(0.01, 0.05),
    surfaces.ImplicitSurface.of_half_lengths((0.03, 0.02, 0.04), (4, 2, 6)),
]


@pytest.fixture(scope="module")
def ball():
    return surfaces.DistanceGrid.from_mesh(Mesh(*SHAPES["sphere"].mesh(20_000)), 0.002)


@pytest.mark.parametrize("surface", ALL, ids=lambda s: s.name)
def test_drawn_mesh_lies_on_the_surface_and_faces_outwards(surface):
    v, t = surface.vertices, surface.triangles
    np.testing.assert_allclose(surface.nearest(v)[0], 0.0, atol=1e-9)
    a, b, c = (v[t[:, k]] for k in range(3))
    facing = np.cross(b - a, c - a)
    middle = (a + b + c) / 3
    assert ((facing * surface.nearest(middle)[2]).sum(axis=1) >= -1e-15).all()


def test_names_contain_the_sizes():
    assert repr(ALL[2]) == "<Box 'box': box, 40 x 30 x 20 mm>"
    assert str(ALL[5]) == "(x/30)^4 + (y/20)^2 + (z/40)^6 = 1, in mm"


def test_grid_of_a_mesh(ball):
    points = SHAPES["sphere"].curve(np.linspace(0, 3, 300), 1e-3)
    distance, _, normal = ball.nearest(points)
    np.testing.assert_allclose(distance, 1e-3, atol=2e-5)  # deviation of the facets
    assert (normal * SHAPES["sphere"].distance(points)[1]).sum(axis=1).min() > np.cos(np.radians(0.5))
    np.testing.assert_allclose(ball.nearest(ball.vertices)[0], 0.0, atol=1e-7)
    assert 2000 < len(ball.triangles) < 100_000


def test_grid_files_survive_a_round_trip(ball, tmp_path):
    ball.save(tmp_path / "ball.npz")
    again = surfaces.DistanceGrid.load(tmp_path / "ball.npz")
    assert again.name == "ball"
    np.testing.assert_array_equal(again.values, ball.values)
    np.testing.assert_array_equal(again.origin, ball.origin)
    np.testing.assert_array_equal(again.spacing, ball.spacing)


def test_grid_keeps_its_data():
    nodes = np.moveaxis(np.indices((4, 5, 6)), 0, -1) * 0.001
    values = (nodes[..., 2] - 0.0025).astype(np.float32)
    grid = surfaces.DistanceGrid(values, np.zeros(3), 0.001)
    given = values.copy()
    values[:] = 1.0
    np.testing.assert_array_equal(grid.values, given)
    with pytest.raises(ValueError, match="read-only"):
        grid.values[0, 0, 0] = 0.0


@pytest.mark.parametrize("encoding", ["raw", "gzip"])
def test_nrrd_files_are_read(ball, tmp_path, encoding):
    data = (1e3 * ball.values).astype("<f4").tobytes(order="F")
    spacing, origin = 1e3 * ball.spacing, 1e3 * ball.origin
    header = (
        "NRRD0004\n# made by a test\ntype: float\ndimension: 3\nspace: left-posterior-superior\n"
        f"sizes: {' '.join(str(n) for n in ball.values.shape)}\n"
        f"space directions: ({spacing[0]},0,0) (0,{spacing[1]},0) (0,0,{spacing[2]})\n"
        f"space origin: ({origin[0]},{origin[1]},{origin[2]})\nendian: little\nencoding: {encoding}\n\n"
    )
    (tmp_path / "ball.nrrd").write_bytes(header.encode() + (gzip.compress(data) if encoding == "gzip" else data))
    again = surfaces.DistanceGrid.load(tmp_path / "ball.nrrd", unit="mm")
    np.testing.assert_allclose(again.values, ball.values, atol=1e-8)
    np.testing.assert_allclose(again.origin, ball.origin)
    np.testing.assert_allclose(again.spacing, ball.spacing)
    (tmp_path / "ball.nrrd").write_bytes(header.encode() + data[:100])
    with pytest.raises(SurfaceError, match="the volume cannot be read"):
        surfaces.DistanceGrid.load(tmp_path / "ball.nrrd")


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: surfaces.Sphere(-1.0), "radius of a sphere must be a positive length in metres, got -1.0"),
        (lambda: surfaces.Sphere("big"), "radius of a sphere must be a positive length in metres, got 'big'"),
        (lambda: surfaces.Box((0.1, 0.1)), "size of a box must be three finite numbers"),
        (lambda: surfaces.Box((0.1, 0.1, 0)), "side of a box must be a positive length"),
        (lambda: surfaces.Capsule(0.01, 0), "length of a capsule must be a positive length"),
        (lambda: surfaces.ImplicitSurface((1, 1, 1), (2, 3, 2)), "exponents of an implicit surface must be 2, 4"),
        (lambda: surfaces.ImplicitSurface.of_half_lengths((1, 0, 1)), "half lengths must be positive"),
        (lambda: surfaces.DistanceGrid(np.ones((5, 5)), np.zeros(3), 1), r"shape \(nx, ny, nz\). Got: \(5, 5\)"),
        (lambda: surfaces.DistanceGrid(np.ones((5, 5, 5)), np.zeros(3), 1), "no surface inside"),
        (lambda: surfaces.DistanceGrid(np.broadcast_to(1.0, (9999, 9999, 9)), np.zeros(3), 1), "more than 134,217,728"),
        (lambda: surfaces.DistanceGrid.load("nowhere.npz"), "nowhere.npz: grid file not found"),
        (lambda: surfaces.DistanceGrid.from_mesh(Mesh(*SHAPES["sphere"].mesh(500)), 1e-5), "mm or more"),
    ],
)
def test_mistakes_are_reported(make, message):
    with pytest.raises(SurfaceError, match=message):
        make()


def test_damaged_files_are_reported(tmp_path, ball):
    for name, message in (
        ("a.npz", "the grid cannot be read"),
        ("a.stl", ".stl is not a format of distance grids"),
        ("a.nrrd", "cannot be"),
    ):
        (tmp_path / name).write_bytes(b"nonsense")
        with pytest.raises(SurfaceError, match=message):
            surfaces.DistanceGrid.load(tmp_path / name)
    np.savez(tmp_path / "b.npz", distance=ball.values)
    with pytest.raises(SurfaceError, match=r"array 'origin.*' is missing"):
        surfaces.DistanceGrid.load(tmp_path / "b.npz")


def test_open_mesh_has_no_inside():
    with pytest.warns(PalpateWarning, match="open"):
        sheet = Mesh(*SHAPES["wavy"].mesh(500), name="sheet")
    with pytest.raises(SurfaceError, match=r"sheet: the mesh is open: .* open edges"):
        surfaces.DistanceGrid.from_mesh(sheet, 0.002)


def test_grid_too_coarse_for_a_plate_is_reported():
    plate = Mesh(*SHAPES["plate"].mesh(500), name="plate")
    with pytest.warns(PalpateWarning, match="of the mesh's volume"):
        surfaces.DistanceGrid.from_mesh(plate, 0.0008)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("spacing", [3e-3, 1e-3, 0.7e-3])
def test_a_solid_box_loses_no_volume_to_a_fine_grid(spacing):
    """Its faces lie on nodes: without them half a cell would be missing at each face, 8 % at 1 mm."""
    box = trimesh.creation.box((0.04, 0.03, 0.02))
    surfaces.DistanceGrid.from_mesh(Mesh(box.vertices, box.faces, name="box"), spacing)
