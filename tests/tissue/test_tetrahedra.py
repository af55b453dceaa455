"""Meshes of tetrahedra: outer surface, quality, stable step; faulty meshes are refused with their reason."""

import numpy as np
import pytest

from palpate.errors import MeshError
from palpate.mesh import Mesh
from palpate.tissue import TetMesh, TissueMaterial, quality, shapes, stable_steps, tetrahedra
from palpate.tissue.blocks import block

CUBE = (2, 2, 2), (0.02, 0.02, 0.02)  # cells and size [m]

LIVER = TissueMaterial(5e3, 0.45)


def test_outer_surface_is_closed_and_encloses_the_volume():
    mesh = TetMesh(*block((3, 2, 4), (0.03, 0.02, 0.04)))
    report = Mesh(mesh.nodes, mesh.surface).report
    assert len(mesh.surface) == 4 * (3 * 2 + 2 * 4 + 3 * 4)
    assert report.watertight
    assert report.inverted == report.turned == 0
    assert report.volume_m3 == pytest.approx(mesh.volumes.sum(), rel=1e-12)


def test_nodes_without_a_tetrahedron_are_dropped():
    nodes, tets = block(*CUBE)
    mesh = TetMesh(np.vstack([[[np.nan] * 3], nodes]), tets + 1)
    np.testing.assert_array_equal(mesh.nodes, nodes)
    np.testing.assert_array_equal(mesh.tets, tets)


def _flip(nodes, tets):
    tets = tets.copy()
    tets[4] = tets[4][[1, 0, 2, 3]]
    return nodes, tets


FAULTS = {
    "inverted": (_flip, r"1 of 48 tetrahedra are inverted or flat; the first is 4"),
    "flat": (lambda n, t: (n * [1, 1, 0], t), "inverted or flat"),
    "not finite": (lambda n, t: (np.where(n == n.max(), np.nan, n), t), "is not finite"),
    "index": (lambda n, t: (n, t + 5), "tets name node 31; the mesh has 27"),
    "negative index": (lambda n, t: (n, t - 1), "tets name node"),
    "shape": (lambda n, t: (n, t[:, :3]), r"shape \(m, 4\)"),
    "empty": (lambda n, t: (n, t[:0]), r"shape \(m, 4\)"),
    "nodes": (lambda n, t: (n[:, :2], t), r"shape \(n, 3\)"),
    "three share a face": (lambda n, t: (n, np.vstack([t, t[:1], t[:1]])), "shares a face with 3 others"),
}


@pytest.mark.parametrize(("damage", "words"), FAULTS.values(), ids=FAULTS)
def test_faulty_meshes_are_refused(damage, words):
    with pytest.raises(MeshError, match=words):
        TetMesh(*damage(*block(*CUBE)))


def test_too_many_tetrahedra_are_refused(monkeypatch):
    monkeypatch.setattr(tetrahedra, "MOST", 40)
    with pytest.raises(MeshError, match=r"48 tetrahedra; a body has at most 40"):
        TetMesh(*block(*CUBE))


def test_regular_tetrahedron_has_quality_one():
    corners = np.array([[1, 1, 1], [-1, 1, -1], [1, -1, -1], [-1, -1, 1]]) * 0.01
    mesh = TetMesh(corners, np.array([[0, 1, 2, 3]]))
    assert shapes(mesh)[0] == pytest.approx(1.0)
    assert np.all(shapes(TetMesh(*block((1, 1, 1), (0.02, 0.02, 0.001)))) < 0.3)


def test_stable_step_is_below_that_of_the_exact_highest_frequency():
    """The eigenvalues of the assembled stiffness, with lumped masses, bound the step from above."""
    mesh = TetMesh(*block(*CUBE))
    exact = 2.0 / np.sqrt(_highest_eigenvalue(mesh, LIVER))
    bound = stable_steps(mesh, [LIVER]).min()
    assert 0.3 * exact < bound <= exact


def _highest_eigenvalue(mesh, m):
    lam = m.bulk - 2.0 / 3.0 * m.shear
    n = len(mesh.nodes)
    K, M = np.zeros((3 * n, 3 * n)), np.zeros(n)
    for tet, volume in zip(mesh.tets, mesh.volumes, strict=True):
        slopes = np.linalg.inv(np.c_[np.ones(4), mesh.nodes[tet]])[1:].T  # (4, 3)
        for i, a in enumerate(tet):
            M[a] += m.density * volume / 4.0
            for j, b in enumerate(tet):
                gi, gj = slopes[i], slopes[j]
                block_ab = lam * np.outer(gi, gj) + m.shear * (np.outer(gj, gi) + gi @ gj * np.eye(3))
                K[3 * a : 3 * a + 3, 3 * b : 3 * b + 3] += volume * block_ab
    root = 1.0 / np.sqrt(np.repeat(M, 3))
    return np.linalg.eigvalsh(root[:, None] * K * root)[-1]


def test_added_mass_grows_with_the_step_and_with_the_modulus():
    mesh = TetMesh(*block(*CUBE))
    small, large = (quality(mesh, [LIVER], step).added_mass_percent for step in (1e-5, 5e-3))
    assert small == 0.0
    assert large > 0.0
    assert quality(mesh, [TissueMaterial(5e4, 0.45)], 5e-3).added_mass_percent > large
    assert quality(mesh, [LIVER]).edge_mm == pytest.approx(10.0)


def test_parts():
    nodes, tets = block(*CUBE)
    assert TetMesh(nodes, tets).parts == 1
    assert TetMesh(np.vstack([nodes, nodes + 1.0]), np.vstack([tets, tets + len(nodes)])).parts == 2
