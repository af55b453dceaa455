"""Thin soft bodies bend and twist as they should: against quadratic hexahedra, on two and more cells."""

from __future__ import annotations

import numpy as np
import pytest
import soft_bodies
from quadratic_bars import compliance, traction
from scipy.linalg import eigh

from palpate import Tissue
from palpate.cli.commands.check.tissue import inspect_tissue

E, H = 4000.0, 0.01  # Young's modulus [Pa], thickness [m]
BAR, STRIP, FLAP = (8 * H, H, H), (6 * H, 4 * H, H), (4 * H, 4 * H, H)


def boxed(size, through, stretch=1.0):
    """A block of cubes, ``through`` of them through the thickness; longer by ``stretch`` along x."""
    cell = size[2] / through
    return soft_bodies.box((round(size[0] / cell / stretch), round(size[1] / cell), through), size)


def stiffness(soft, nodes):
    """Stiffness (3n, 3n) [N/m] at rest by central differences of the forces of the core."""
    n, h = len(nodes), 2e-2 * np.linalg.norm(nodes[1] - nodes[0])
    zero, K = np.zeros((n, 3)), np.zeros((3 * n, 3 * n))
    for k in range(3 * n):
        side = []
        for sign in (1.0, -1.0):
            x = nodes.copy()
            x.flat[k] += sign * h
            soft.set_state(x, zero)
            side.append(soft.internal_forces().ravel())
        K[:, k] = (side[1] - side[0]) / (2 * h)
    return (K + K.T) / 2


def end_load(mesh, size, at):
    """Forces (n, 3) of a linear traction ``at`` on the end of a mesh [N]."""
    nodes, _, surface = mesh
    faces = surface[(np.abs(nodes[surface][:, :, 0] - size[0]) < 1e-9).all(axis=1)]
    corners = nodes[faces]
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    pull = at(corners)
    f = np.zeros_like(nodes)
    for k in range(3):
        np.add.at(f, faces[:, k], area[:, None] / 12 * (pull.sum(axis=1) + pull[:, k]))
    return f


def deflection_work(mesh, size, kind, nu):
    """Work of the unit traction on the deflection of the core's body [J]: Newton's steps with a stiffness in doubles,
    on the core's own forces."""
    nodes = mesh[0]
    soft = soft_bodies.body(mesh, E, nu)
    free = np.repeat(nodes[:, 0] > 1e-9, 3)
    K = stiffness(soft, nodes)[np.ix_(free, free)]
    f = end_load(mesh, size, traction(kind, size)).ravel()[free]
    u = np.zeros(len(free))
    u[free] = np.linalg.solve(K, f)
    scale = 1e-3 * size[2] / np.abs(u).max()  # small, so that the response is linear
    u *= scale
    for _ in range(3):
        soft.set_state(nodes + u.reshape(-1, 3), np.zeros_like(nodes))
        u[free] += np.linalg.solve(K, scale * f + soft.internal_forces().ravel()[free])
    return float(f @ u[free]) / scale


def error(mesh, size, kind, nu):
    """Relative error of the stiffness."""
    return compliance(kind, size, E, nu) / deflection_work(mesh, size, kind, nu) - 1.0


def test_judge_agrees_with_beam_theory():
    """A slender bar: bending and shear by Timoshenko; twist by Saint-Venant, which the clamped end stiffens."""
    size, nu = (20 * H, H, H), 0.3
    force, G = H * H, E / (2 * (1 + nu))
    bend = force * size[0] ** 3 / (3 * E * H**4 / 12) + force * size[0] / (5 / 6 * G * H * H)
    assert compliance("bend", size, E, nu) == pytest.approx(force * bend, rel=0.01)
    moment = H**4 / 6
    assert compliance("twist", size, E, nu) == pytest.approx(moment**2 * size[0] / (0.1406 * G * H**4), rel=0.03)


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.45, 0.49])
@pytest.mark.parametrize(
    ("kind", "size"), [("bend", BAR), ("bend", FLAP), ("twist", STRIP)], ids=["cantilever", "flap", "twist"]
)
def test_two_cells_through_the_thickness_bend_and_twist_within_ten_percent(kind, size, nu):
    assert abs(error(boxed(size, 2), size, kind, nu)) < 0.10


@pytest.mark.parametrize("nu", [0.3, 0.49])
def test_a_bar_of_two_by_two_cells_twists_within_ten_percent(nu):
    assert abs(error(boxed(BAR, 2), BAR, "twist", nu)) < 0.10


@pytest.mark.parametrize(("kind", "size"), [("bend", BAR), ("twist", BAR)], ids=["cantilever", "twist"])
@pytest.mark.parametrize("through", [3, 4])
def test_finer_bars_err_no_more(kind, size, through):
    size = (size[0] / 2, *size[1:])
    assert abs(error(boxed(size, through), size, kind, 0.45)) < 0.10


def tetrahedra_alone(mesh, nu):
    """Stiffness (3n, 3n) of linear tetrahedra with the shear modulus of the body and .4 of it as bulk modulus."""
    nodes, tets, _ = mesh
    mu = E / (2 * (1 + nu))
    D = np.diag([2 * mu] * 3 + [mu] * 3)
    D[:3, :3] += 0.4 * mu - 2 / 3 * mu
    K = np.zeros((3 * len(nodes), 3 * len(nodes)))
    for tet in tets:
        full = np.hstack([np.ones((4, 1)), nodes[tet]])
        B = np.zeros((6, 12))
        for a, (x, y, z) in enumerate(np.linalg.inv(full)[1:].T):
            B[:, 3 * a : 3 * a + 3] = [[x, 0, 0], [0, y, 0], [0, 0, z], [y, x, 0], [0, z, y], [z, 0, x]]
        at = (3 * tet[:, None] + np.arange(3)).ravel()
        K[np.ix_(at, at)] += np.linalg.det(full) / 6 * B.T @ D @ B
    return K


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.49])
@pytest.mark.parametrize("through", [1, 2, 4])
def test_no_mode_has_little_energy(nu, through):
    """Each mode but the rigid ones has a sixth of the energy of the tetrahedra alone, or more."""
    mesh = boxed((0.02, 0.02, 0.01), through) if through < 4 else boxed((0.01, 0.01, 0.01), 4)
    K, other = stiffness(soft_bodies.body(mesh, E, nu), mesh[0]), tetrahedra_alone(mesh, nu)
    values, vectors = np.linalg.eigh(other)
    strained = vectors[:, 6:] / np.sqrt(values[6:])
    assert values[5] < 1e-9 * values[6], "control: six rigid modes"
    assert np.linalg.eigvalsh(strained.T @ K @ strained)[0] > 0.165
    rigid = vectors[:, :6]
    assert np.abs(rigid.T @ K @ rigid).max() < 1e-4 * values[6]


def test_frequencies_of_a_coarse_bar_are_those_of_a_finer_one():
    """The lowest modes of a clamped bar: bending in two planes, twist, stretch; none is added by the patches."""
    found = []
    for through in (2, 3):
        size = (6 * H, H, H)
        mesh = boxed(size, through)
        soft = soft_bodies.body(mesh, E, 0.45)
        free = np.repeat(mesh[0][:, 0] > 1e-9, 3)
        mass = np.repeat(soft.masses(), 3)[free]
        K = stiffness(soft, mesh[0])[np.ix_(free, free)] / np.sqrt(np.outer(mass, mass))
        found.append(np.sqrt(eigh(K, eigvals_only=True, subset_by_index=[0, 8])))
    np.testing.assert_allclose(found[0], found[1], rtol=0.08)


@pytest.mark.parametrize(("kind", "size"), [("bend", FLAP), ("bend", BAR)])
def test_check_predicts_the_error_of_one_cell(kind, size):
    for nu in (0.3, 0.45, 0.49):
        mesh = boxed(size, 1)
        predicted = inspect_tissue(Tissue(mesh[:2], young=5e3, poisson=nu)).bending_error_percent / 100.0
        assert predicted == pytest.approx(error(mesh, size, kind, nu), rel=0.15)


@pytest.mark.parametrize("nu", [0.3, 0.45, 0.49])
@pytest.mark.parametrize(("long", "wide"), [(1.5, 1), (1.5, 4), (2, 2), (3, 1)])
def test_check_predicts_the_largest_error_of_stubby_parts_of_two_cells(long, wide, nu):
    """Bending and twist of plates and bars shorter than four times their thickness: up to 26 % at nu .49."""
    size = (long * H, wide * H, H)
    mesh = boxed(size, 2)
    predicted = inspect_tissue(Tissue(mesh[:2], young=5e3, poisson=nu)).bending_error_percent / 100.0
    worst = max(abs(error(mesh, size, kind, nu)) for kind in ("bend", "twist"))
    assert worst <= predicted + 0.005
    assert predicted <= max(1.35 * worst, 0.16)
