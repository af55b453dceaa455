"""Meshes of tetrahedra: outer surface, quality, stable step; faulty meshes are refused with their reason."""

import numpy as np
import pytest

from palpate.base.errors import MeshError
from palpate.world.mesh import Mesh
from palpate.world.tissue import TetMesh, TissueMaterial, quality, shapes, stable_steps, tetrahedra
from palpate.world.tissue.blocks import block
from palpate.world.tissue.tetrahedra import signed_volumes

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


def _fold(nodes, tets):
    """A node of the middle is pulled through the faces around it."""
    nodes = nodes.copy()
    nodes[13] += [0.013, 0.004, 0.002]
    return nodes, tets


FAULTS = {
    "folded": (_fold, "lie on the same side of the face between them"),
    "flat": (lambda n, t: (n * [1, 1, 0], t), "tetrahedra are flat"),
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


@pytest.mark.parametrize("turned", [range(48), [4], [0, 1, 2, 17, 47]], ids=["all", "one", "some"])
def test_tetrahedra_in_the_other_order_are_turned_and_counted(turned):
    nodes, tets = block(*CUBE)
    other = tets.copy()
    for k, order in zip(turned, np.tile([[1, 0, 2, 3], [0, 1, 3, 2], [3, 1, 2, 0]], (16, 1)), strict=False):
        other[k] = other[k][order]
    mesh = TetMesh(nodes, other)
    assert mesh.turned == len(turned)
    assert (signed_volumes(mesh.nodes, mesh.tets) > 0.0).all()
    np.testing.assert_array_equal(np.sort(mesh.tets, axis=1), np.sort(tets, axis=1))
    assert Mesh(mesh.nodes, mesh.surface).report.volume_m3 == pytest.approx(8e-6)
    assert f"{len(turned)} of 48 tetrahedra list their nodes in the other order: turned" in mesh.findings[0].what
    assert TetMesh(nodes, tets).findings == ()


@pytest.mark.parametrize("off", [0.0, 2e-7], ids=["equal", "rounded"])
def test_nodes_at_one_place_are_joined_and_counted(off):
    """Two blocks on each other, each with its own nodes of the face between them."""
    low, tets = block(*CUBE)
    high = low + np.array([off, 0.0, 0.02])
    mesh = TetMesh(np.vstack([low, high]), np.vstack([tets, tets + len(low)]))
    assert (mesh.joined, mesh.parts, len(mesh.nodes)) == (9, 1, 45)
    assert "9 nodes lie at the place of another one: joined" in mesh.findings[0].what
    whole = TetMesh(*block((2, 2, 4), (0.02, 0.02, 0.04)))
    assert len(mesh.surface) == len(whole.surface)


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
