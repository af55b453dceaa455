"""Noise of vertices is removed: forces point as on the true sphere, and no vertex moves farther than noise would."""

import numpy as np
import pytest
import trimesh

import palpate
from palpate.base.errors import SceneError
from palpate.scene import Scene
from palpate.world.mesh import Mesh
from palpate.world.mesh.denoise import FARTHEST, denoise
from palpate.world.mesh.mesh import quiet

R, NOISE = 0.03, 5e-5


@pytest.fixture(scope="module")
def noisy():
    exact = trimesh.creation.icosphere(5, R)
    rng = np.random.default_rng(3)
    with quiet():
        return Mesh(exact.vertices * (1.0 + rng.normal(0.0, NOISE / R, (len(exact.vertices), 1))), exact.faces)


def direction_errors_deg(mesh):
    """Angles between the force and the sphere's normal at 60 places, pressed by 0.3 mm with a tool of 1 mm."""
    normals = np.random.default_rng(4).normal(size=(60, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    depths = np.concatenate([np.linspace(1.05 * R, R - 3e-4 + 1e-3, 40), np.full(20, R - 3e-4 + 1e-3)])
    forces = [
        palpate.contact.render(mesh, depths[:, None] * n, radius=1e-3, stiffness=300.0).force[-1] for n in normals
    ]
    cosines = [f @ n / np.linalg.norm(f) for f, n in zip(forces, normals, strict=True)]
    return np.degrees(np.arccos(np.clip(cosines, -1.0, 1.0)))


def test_forces_point_as_on_the_true_sphere_and_the_judge_sees_the_noise(noisy):
    assert np.percentile(direction_errors_deg(denoise(noisy, NOISE)), 95) < 1.5
    assert np.percentile(direction_errors_deg(noisy), 95) > 5.0


def test_surface_is_neither_shrunk_nor_rough(noisy):
    radii = np.linalg.norm(denoise(noisy, NOISE).vertices, axis=1)
    assert radii.mean() == pytest.approx(R, abs=0.1 * NOISE)
    assert radii.std() < 0.4 * NOISE


@pytest.mark.parametrize("noise", [1e-5, 2e-4, 5e-3])
def test_no_vertex_moves_by_more_than_the_noise_allows(noise):
    box = trimesh.creation.box((0.04, 0.04, 0.04)).subdivide().subdivide().subdivide()
    mesh = Mesh(box.vertices, box.faces)
    moved = np.linalg.norm(denoise(mesh, noise).vertices - mesh.vertices, axis=1)
    assert 0.0 < moved.max() <= FARTHEST * noise * (1 + 1e-9)


def test_open_rim_stays(noisy):
    upper = noisy.triangles[noisy.vertices[noisy.triangles].mean(axis=1)[:, 2] > 0.0]
    with quiet():
        cap = Mesh(noisy.vertices, upper)
        smoothed = denoise(cap, NOISE)
    edges, uses = np.unique(
        np.sort(cap.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0, return_counts=True
    )
    rim = np.unique(edges[uses == 1])
    assert len(rim) > 50
    assert np.array_equal(smoothed.vertices[rim], cap.vertices[rim])


def test_no_noise_changes_nothing(noisy):
    assert denoise(noisy, 0.0) is noisy


def test_scene_smooths_its_mesh(noisy, tmp_path):
    trimesh.Trimesh(noisy.vertices, noisy.triangles).export(tmp_path / "noisy.stl")
    text = "objects: [{name: ball, mesh: noisy.stl, unit: m, noise: 0.05mm}]"
    (tmp_path / "scene.yaml").write_text(text)
    from palpate.scene.surface import placed

    [ball] = placed(Scene.load(tmp_path / "scene.yaml"))
    assert np.linalg.norm(ball.body.vertices, axis=1).std() < 0.4 * NOISE
    with pytest.raises(SceneError, match="noise is that of a mesh's vertices"):
        Scene.parse("objects: [{name: ball, sphere: {radius: 30mm}, noise: 1mm}]")
