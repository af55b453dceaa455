"""A soft body against closed forms: homogeneous strain, energy by differences, free vibration, relaxation."""

from __future__ import annotations

import numpy as np
import pytest
import soft_bodies
from scipy.optimize import brentq

from palpate import _tissue

E, NU = 5000.0, 0.45
MU, BULK = E / (2 * (1 + NU)), E / (3 * (1 - 2 * NU))
K = BULK + MU / 3


def psi(F, mu=MU, k=K, yeoh=0.0):
    """Strain energy per volume of F (3, 3), written with the invariants of F itself [J/m^3]."""
    J = np.linalg.det(F)
    w = np.trace(F.T @ F) - 3.0 - 2.0 * (J - 1.0)
    return mu / 2 * (w + yeoh * max(w, 0.0) ** 2) + k / 2 * (J - 1.0) ** 2


def first_stress(F, **material):
    """First Piola-Kirchhoff stress (3, 3) by central differences of ``psi`` [Pa]."""
    P = np.zeros((3, 3))
    for i in range(3):
        for j in range(3):
            d = np.zeros((3, 3))
            d[i, j] = 1e-6
            P[i, j] = (psi(F + d, **material) - psi(F - d, **material)) / 2e-6
    return P


@pytest.fixture
def irregular():
    """A block whose inner nodes are moved at random, and the flags of its boundary."""
    nodes, tets, surface = soft_bodies.box((4, 3, 3), (0.04, 0.03, 0.03))
    outside = np.zeros(len(nodes), bool)
    outside[surface] = True
    nodes = nodes + np.where(outside[:, None], 0.0, np.random.default_rng(1).uniform(-2e-3, 2e-3, nodes.shape))
    return (nodes, tets, surface), outside


@pytest.mark.parametrize("portable", [False, True])
@pytest.mark.parametrize("yeoh", [0.0, 2.0])
def test_patch_of_large_homogeneous_strain_has_no_inner_forces_and_the_stress_of_its_energy(irregular, portable, yeoh):
    mesh, outside = irregular
    F = np.array([[1.3, 0.2, 0.0], [-0.1, 0.8, 0.1], [0.05, 0.0, 1.1]])
    soft = soft_bodies.body(mesh, yeoh=yeoh, portable=portable)
    soft.set_state(mesh[0] @ F.T, np.zeros_like(mesh[0]))
    f = soft.internal_forces()
    P = first_stress(F, yeoh=yeoh)
    assert np.abs(f[~outside]).max() < 1e-5 * np.abs(f).max(), "patch test: inner nodes are in equilibrium"
    face = mesh[0][:, 0] == mesh[0][:, 0].max()
    inner = face & np.isclose(np.abs(mesh[0][:, 1:] - 0.015).max(axis=1), 0.005)
    assert inner.any()
    np.testing.assert_allclose(-f[face & inner].mean(axis=0), P[:, 0] * 1e-4, rtol=1e-4, atol=1e-6)


def test_moments_and_forces_of_the_stress_vanish_for_any_state(irregular):
    mesh, _ = irregular
    soft = soft_bodies.body(mesh, yeoh=1.0)
    x = mesh[0] + np.random.default_rng(2).normal(0.0, 1.5e-3, mesh[0].shape)
    soft.set_state(x, np.zeros_like(x))
    f = soft.internal_forces()
    scale = np.abs(f).sum()
    assert np.abs(f.sum(axis=0)).max() < 1e-6 * scale
    assert np.abs(np.cross(x, f).sum(axis=0)).max() < 1e-6 * scale * 0.05


def test_forces_are_the_gradient_of_the_energy(irregular):
    """Central differences of the energy, also beside inverted tetrahedra."""
    mesh, _ = irregular
    soft = soft_bodies.body(mesh, yeoh=1.0, step=1e-9)
    rng = np.random.default_rng(3)
    zero = np.zeros_like(mesh[0])

    def energy(x):
        soft.set_state(x, zero)
        soft.internal_forces()
        return soft.energies()[0]

    for spread in (1e-3, 8e-3):
        x, d = mesh[0] + rng.normal(0.0, spread, zero.shape), rng.normal(size=zero.shape)
        soft.set_state(x, zero)
        work = -(soft.internal_forces() * d).sum()
        h = 1e-5
        slope = (energy(x + h * d) - energy(x - h * d)) / (2 * h)
        assert slope == pytest.approx(work, rel=2e-3)
    assert soft.least_volume < 0, "control: the last state has inverted tetrahedra"


@pytest.mark.parametrize("stretch", [0.7, 1.4])
@pytest.mark.parametrize("yeoh", [0.0, 1.0])
def test_uniaxial_stretch_against_the_closed_form(stretch, yeoh):
    """A bar whose ends slide freely in their plane; the lateral stretch makes the lateral stress zero."""
    mesh = soft_bodies.box((4, 2, 2), (0.04, 0.02, 0.02))
    nodes = mesh[0]
    lateral = brentq(lambda b: first_stress(np.diag([stretch, b, b]), yeoh=yeoh)[1, 1], 0.5, 2.0)
    soft = soft_bodies.body(mesh, yeoh=yeoh)
    x = nodes * [stretch, lateral, lateral]
    soft.set_state(x, np.zeros_like(x))
    f = soft.internal_forces()
    end = nodes[:, 0] == nodes[:, 0].max()
    force = -f[end].sum(axis=0)
    expected = first_stress(np.diag([stretch, lateral, lateral]), yeoh=yeoh)[0, 0] * 4e-4
    assert force[0] == pytest.approx(expected, rel=1e-4)
    assert np.abs(f[:, 1:]).max() < 1e-4 * abs(expected), "no lateral force"


def vibration(mode_shape, soft, mesh, seconds):
    """Frequency of the mode that is excited by its shape, from the zero crossings of its amplitude [Hz]."""
    soft.set_state(mesh[0], mode_shape)
    amplitude = []
    for _ in range(int(seconds / soft.time_step)):
        soft.step(1)
        amplitude.append(((soft.positions() - mesh[0]) * mode_shape).sum())
    t = np.arange(1, len(amplitude) + 1) * soft.time_step
    a = np.array(amplitude)
    rising = np.flatnonzero((a[:-1] < 0) & (a[1:] >= 0))
    crossings = t[rising] - a[rising] * soft.time_step / (a[rising + 1] - a[rising])
    return 1.0 / np.diff(crossings).mean()


def test_longitudinal_vibration_of_a_bar_has_the_closed_frequency():
    """A slender bar, fixed at one end: f = sqrt(E / rho) / 4 L."""
    length, young = 0.2, 5000.0
    mesh = soft_bodies.box((40, 2, 2), (length, 0.01, 0.01))
    fixed = mesh[0][:, 0] == 0.0
    soft = soft_bodies.body(mesh, young, 0.3, fixed=fixed, damping=0.0, tick=5e-4)
    shape = np.zeros_like(mesh[0])
    shape[:, 0] = 1e-3 * np.sin(np.pi * mesh[0][:, 0] / (2 * length))
    expected = np.sqrt(young / 1000.0) / (4 * length)
    assert soft.added_mass() < 0.01
    assert vibration(shape, soft, mesh, 1.8) == pytest.approx(expected, rel=0.02)


def test_energy_of_free_vibration_is_kept_and_damping_takes_it():
    mesh = soft_bodies.box((6, 3, 3), (0.06, 0.03, 0.03))
    fixed = mesh[0][:, 0] == 0.0
    velocity = np.where(fixed[:, None], 0.0, [0.0, 0.0, 0.3] * mesh[0][:, :1] / 0.06)
    for damping, low, high in ((0.0, 0.97, 1.03), (20.0, 0.0, 0.05)):
        soft = soft_bodies.body(mesh, fixed=fixed, damping=damping)
        soft.set_state(mesh[0], velocity)
        start = sum(soft.energies())
        totals = []
        for _ in range(400):
            soft.step(1)
            totals.append(sum(soft.energies()))
        assert low * start <= totals[-1] <= high * start
    assert start > 1e-5


def test_prony_terms_relax_as_their_series_and_lose_energy():
    """Homogeneous shear that is held: the ratio of forces is 1 + sum g exp(-t / tau)."""
    prony = [(0.6, 0.02), (0.3, 0.1), (0.2, 0.5)]
    mesh = soft_bodies.box((2, 2, 2), (0.02, 0.02, 0.02))
    soft = soft_bodies.body(mesh, prony=prony, fixed=np.ones(27, bool), spring=np.zeros(27))
    x = mesh[0] + mesh[0][:, 2:] * [0.1, 0.0, 0.0]
    soft.set_state(x, np.zeros_like(x))
    rest = soft.internal_forces()
    soft.step(1)
    elastic, energy = soft.energies()[0], []
    for _ in range(1000):
        soft.step(1)
        energy.append(soft.energies()[0])
    assert np.abs(rest).max() > 0
    assert (np.diff(energy) <= 1e-12 * elastic).all(), "the springs of the Prony terms only lose energy"
    t = np.arange(1, 1001) * soft.time_step
    stored = sum(g * np.exp(-2 * t / tau) for g, tau in prony)
    series = 1.0 + stored
    np.testing.assert_allclose(np.array(energy) / energy[-1], series / series[-1], rtol=0.03)


@pytest.mark.parametrize("prony", [(), [(0.5, 0.01), (0.2, 0.1), (0.1, 1.0)]])
def test_both_kernels_agree_and_each_repeats_its_bytes(irregular, prony):
    if not _tissue.TissueBody.has_avx2:
        pytest.skip("this processor has no AVX2: there is one kernel")
    mesh, _ = irregular
    found = []
    for portable in (False, False, True):
        soft = soft_bodies.body(mesh, fixed=mesh[0][:, 2] == 0.0, prony=prony, yeoh=0.5, portable=portable)
        loads = np.zeros_like(mesh[0])
        loads[mesh[0][:, 2] == mesh[0][:, 2].max()] = [0.005, 0.0, -0.01]
        soft.set_loads(loads)
        soft.step(400)
        found.append(soft.positions())
    moved = np.abs(found[0] - mesh[0]).max()
    assert moved > 2e-3
    assert found[0].tobytes() == found[1].tobytes()
    assert np.abs(found[0] - found[2]).max() < 1e-4 * moved


def test_stable_step_is_that_of_the_largest_frequency_of_a_tetrahedron():
    """Independent of the core's closed form: eigenvalues of the stiffness matrix (12, 12) that B^T D B gives."""
    rng = np.random.default_rng(6)
    for nu in (0.0, 0.3, 0.49):
        corners = rng.normal(0.0, 0.01, (4, 3))
        if np.linalg.det(corners[1:] - corners[0]) < 0.0:
            corners[[0, 1]] = corners[[1, 0]]
        slope = np.linalg.inv(np.hstack([np.ones((4, 1)), corners]))[1:].T
        B = np.zeros((6, 12))
        for a, (x, y, z) in enumerate(slope):
            B[:, 3 * a : 3 * a + 3] = [[x, 0, 0], [0, y, 0], [0, 0, z], [y, x, 0], [0, z, y], [z, 0, x]]
        mu, bulk = E / (2 * (1 + nu)), E / (3 * (1 - 2 * nu))
        D = np.diag([2 * mu] * 3 + [mu] * 3)
        D[:3, :3] += bulk - 2 / 3 * mu
        fastest = np.sqrt(np.linalg.eigvalsh(B.T @ D @ B).max() * 4.0 / 1000.0)
        soft = soft_bodies.body((corners, np.array([[0, 1, 2, 3]], np.int32), np.zeros((0, 3), np.int32)), E, nu)
        assert soft.stable_step() == pytest.approx(2.0 / fastest, rel=1e-7)


def test_time_step_and_added_mass_follow_the_stiffness():
    mesh = soft_bodies.box((4, 3, 3), (0.04, 0.03, 0.03))
    soft, stiff = soft_bodies.body(mesh), soft_bodies.body(mesh, 80e3, 0.49)
    assert stiff.stable_step() == pytest.approx(soft.stable_step() / np.sqrt(80 / 5), rel=0.6)
    assert stiff.steps_per_tick > soft.steps_per_tick
    forced = soft_bodies.body(mesh, 80e3, 0.49, step=1e-3)
    assert forced.added_mass() > 0.5
    assert forced.masses().sum() == pytest.approx(0.036 * (1 + forced.added_mass()), rel=1e-6)
    velocity = np.random.default_rng(1).normal(0.0, 0.05, mesh[0].shape)
    forced.set_state(mesh[0], velocity)
    start = sum(forced.energies())
    forced.step(2000)
    assert sum(forced.energies()) < 1.1 * start, "the added mass makes the step stable"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"mu": np.array([-1.0])}, r"mu\[0\] = -1"),
        ({"mu": np.ones(2)}, "mu has 2 values"),
        ({"tets": np.array([[0, 1, 2, 9]], np.int32)}, "names node 9"),
        ({"tets": np.array([[0, 2, 1, 3]], np.int32)}, "inverted"),
        ({"nodes": np.array([[0.0, 0, 0], [1, 0, 0], [0, np.nan, 0], [0, 0, 1]])}, "not finite"),
        ({"prony": [(0.1, 0.0)]}, "tau"),
        ({"prony": [(0.1, 1.0)] * 5}, "at most 4"),
        ({"step": -1.0}, "step"),
        ({"fixed": np.zeros(2, bool)}, "fixed has 2"),
    ],
)
def test_invalid_bodies_are_refused_with_the_value(change, message):
    good = {
        "nodes": np.array([[0.0, 0, 0], [0.01, 0, 0], [0, 0.01, 0], [0, 0, 0.01]]),
        "tets": np.array([[0, 1, 2, 3]], np.int32),
        "surface": np.zeros((0, 3), np.int32),
        "mu": np.array([2e3]),
        "bulk": np.array([2e4]),
        "density": np.array([1e3]),
        "yeoh": np.zeros(1),
        "prony": [],
        "fixed": np.zeros(4, bool),
        "spring": np.zeros(4),
    }
    _tissue.TissueBody(**good)
    with pytest.raises(ValueError, match=message):
        _tissue.TissueBody(**{**good, **change})
