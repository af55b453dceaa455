"""The organ generator: one closed outward mesh, well-shaped triangles on the surface, reproducible."""

import hashlib

import numpy as np
import pytest
import trimesh

from palpate.world import shapes as organs
from palpate.world.shapes.surface_nets import extract, refine, triangle_count


def as_trimesh(shape):
    return trimesh.Trimesh(*shape, process=False)


@pytest.fixture(scope="module")
def liver():
    return organs.organ()


@pytest.mark.parametrize("make", [organs.organ, organs.gallbladder])
def test_organ_is_one_closed_outward_piece_without_slivers(make):
    mesh = as_trimesh(make())
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.volume > 0.0
    assert mesh.body_count == 1
    assert mesh.euler_number == 2
    assert np.degrees(mesh.face_angles.min()) > 10.0
    assert mesh.edges_unique_length.max() < 4.0 * np.median(mesh.edges_unique_length)


def test_organ_has_the_size_of_a_small_liver_around_the_origin(liver):
    mesh = as_trimesh(liver)
    width, height, thickness = mesh.extents
    assert 0.16 < width < 0.20
    assert 0.12 < height < 0.16
    assert 0.07 < thickness < 0.11
    assert 0.6e-3 < mesh.volume < 1.2e-3  # [m^3]
    np.testing.assert_allclose(mesh.bounds.sum(axis=0), 0.0, atol=1e-12)


def test_right_lobe_is_larger_and_the_inferior_edge_is_thin(liver):
    vertices, _ = liver
    right, left = vertices[vertices[:, 0] < -0.03], vertices[vertices[:, 0] > 0.05]
    assert np.ptp(right[:, 2]) > 1.5 * np.ptp(left[:, 2])
    low = vertices[(vertices[:, 1] < vertices[:, 1].min() + 0.01)]
    assert np.ptp(low[:, 2]) < 0.3 * np.ptp(vertices[:, 2])


@pytest.mark.parametrize("target", [2000, 6000, 12_000])
def test_triangle_count_is_within_ten_percent_and_the_surface_is_closed(target):
    mesh = as_trimesh(organs.organ(target))
    assert abs(len(mesh.faces) - target) < 0.1 * target
    assert mesh.is_watertight


def test_splitting_keeps_the_surface():
    coarse, fine = as_trimesh(organs.organ(15_000)), as_trimesh(organs.organ(80_000))
    assert fine.is_watertight
    assert 40_000 < len(fine.faces) < 200_000
    assert fine.volume == pytest.approx(coarse.volume, rel=5e-3)


def test_same_arguments_give_the_same_bytes_and_another_seed_another_relief(liver):
    def digest(shape):
        return hashlib.sha256(shape[0].tobytes() + shape[1].tobytes()).hexdigest()

    assert digest(organs.organ()) == digest(liver)
    assert digest(organs.organ(seed=1)) != digest(liver)


def test_too_few_triangles_are_reported():
    with pytest.raises(ValueError, match="triangles = 100: the shape needs at least 2000 to keep its thin edge"):
        organs.organ(100)


# The extraction against a sphere in closed form. ------------------------------------------------------------

BOX = np.array([[-1.3, -1.2, -1.25], [1.2, 1.3, 1.25]])


def ball(p):
    return np.linalg.norm(p, axis=-1) - 1.0


def test_sphere_vertices_are_on_the_sphere_and_volume_converges():
    vertices, triangles = extract(ball, *BOX, 0.08)
    mesh = trimesh.Trimesh(vertices, triangles, process=False)
    np.testing.assert_allclose(np.linalg.norm(vertices, axis=1), 1.0, atol=1e-6)
    assert mesh.is_watertight
    assert len(triangles) == triangle_count(ball, *BOX, 0.08)
    error = 4.0 / 3.0 * np.pi - mesh.volume
    finer = trimesh.Trimesh(*refine(ball, vertices, triangles, 0.08), process=False)
    assert finer.is_watertight
    assert 0.0 < 4.0 / 3.0 * np.pi - finer.volume < 0.3 * error  # second order: a quarter of the error


def test_solid_that_leaves_the_box_is_rejected():
    with pytest.raises(ValueError, match="touches the box"):
        extract(ball, BOX[0], 0.5 * BOX[1], 0.1)
    with pytest.raises(ValueError, match="no point of the grid is inside"):
        extract(ball, BOX[0] + 10.0, BOX[1] + 10.0, 0.1)
