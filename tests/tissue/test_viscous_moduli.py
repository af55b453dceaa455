"""Prony terms against linear viscoelasticity: moduli at once, storage and loss moduli in shear, hydrostatic and
oedometric cycles; energy of free blocks and of closed paths of strain."""

from __future__ import annotations

import numpy as np
import pytest
import soft_bodies
from strained import HYDROSTATIC, OEDOMETRIC, SHEAR, YOUNG, Strained, cycle_moduli, once

from palpate.world.tissue.material import LARGEST_SHARE, LONGEST_TAU, SHORTEST_TAU

PATTERNS = {"shear": SHEAR, "hydrostatic": HYDROSTATIC, "oedometric": OEDOMETRIC}


def moduli(nu, prony, omega):
    """Closed forms (storage + i loss) [Pa] of the stress along the pattern: shear 2 G, bulk 3 K, oedometric."""
    G = YOUNG / (2 * (1 + nu)) * (1 + sum(g * 1j * omega * tau / (1 + 1j * omega * tau) for g, tau in prony))
    K = YOUNG / (3 * (1 - 2 * nu))
    return {"shear": 2 * G, "hydrostatic": 3 * K + 0j, "oedometric": K + 4 / 3 * G}


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.45, 0.495])
@pytest.mark.parametrize("name", PATTERNS)
@pytest.mark.parametrize(
    "prony",
    [[(0.3, 0.004)], [(2.0, 0.005)], [(0.5, 0.002), (1.5, 0.02)], [(20.0, 0.01)], [(60.0, 0.003), (40.0, 0.01)]],
    ids=str,
)
def test_storage_and_loss_moduli_are_those_of_linear_viscoelasticity(nu, name, prony):
    omega, step = 200.0, 2 * np.pi / 200.0 / 256
    expected = moduli(nu, prony, omega)[name]
    assert abs(cycle_moduli(nu, prony, PATTERNS[name], omega, step) - expected) < 0.012 * abs(expected)


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.49])
@pytest.mark.parametrize("prony", [[(2.0, 0.005)], [(0.5, LONGEST_TAU), (0.3, 0.1)], [(LARGEST_SHARE, 0.01)]], ids=str)
def test_moduli_at_once_relax_the_shear_and_not_the_volume(nu, prony):
    for name, pattern in PATTERNS.items():
        expected = moduli(nu, prony, 1e12)[name].real
        assert once(nu, prony, pattern) == pytest.approx(expected, rel=5e-3), name


@pytest.mark.parametrize("tau", [SHORTEST_TAU, 1e-3, LONGEST_TAU])
def test_a_large_strain_that_is_held_relaxes_by_the_series(tau):
    prony, step = [(1.5, tau)], tau / 20
    F = np.array([[1.25, 0.2, 0.0], [0.0, 0.8, 0.1], [0.1, 0.0, 1.02]])
    rest = Strained(0.45, [], step, yeoh=0.8).stress(F)
    block = Strained(0.45, prony, step, yeoh=0.8)
    over = np.array([block.stress(F) - rest for _ in range(60)])
    ratio = over[:, 0, 0] / over[0, 0, 0]
    np.testing.assert_allclose(ratio, np.exp(-np.arange(60) * step / tau), atol=5e-3)
    np.testing.assert_allclose(over[20], over[0] * ratio[20], atol=1e-3 * np.abs(over[0]).max())


def test_a_sudden_large_strain_has_the_stress_of_the_isochoric_energy():
    """Central differences of mu/2 (w + c w^2), w = J^(-2/3) tr F^T F - 3, written without the core's formulas."""
    g, c, mu = 2.0, 0.7, YOUNG / 2.9

    def energy(F):
        w = np.linalg.det(F) ** (-2 / 3) * (F**2).sum() - 3.0
        return mu / 2 * (w + c * w**2)

    for F in (np.diag([0.7, 1.1, 1.3]), np.array([[1.0, 0.5, 0.0], [0.0, 1.2, 0.2], [0.1, 0.0, 0.9]]), 1.4 * np.eye(3)):
        expected = np.zeros((3, 3))
        for k in range(9):
            d = np.zeros(9)
            d[k] = 1e-6
            expected.flat[k] = (energy(F + d.reshape(3, 3)) - energy(F - d.reshape(3, 3))) / 2e-6
        over = Strained(0.45, [(g, 1.0)], 1e-7, yeoh=c).stress(F) - Strained(0.45, [], 1e-7, yeoh=c).stress(F)
        np.testing.assert_allclose(over, g * expected, atol=2e-3 * mu)


@pytest.mark.parametrize("seed", range(6))
def test_closed_paths_of_large_strain_take_energy(seed):
    """Random closed paths through finite strains and volumes, whose work is positive, and zero for pure changes of
    volume."""
    rng = np.random.default_rng(seed)
    prony = [(rng.uniform(0.1, 5.0), 10 ** rng.uniform(-3, -1)) for _ in range(rng.integers(1, 4))]
    a = rng.normal(0.0, 0.1, (3, 3, 3))
    t = np.linspace(0.0, 2 * np.pi, 800)
    wave = np.stack([np.sin((k + 1) * t + p) - np.sin(p) for k, p in enumerate(rng.uniform(0, 6, 3))])
    for path in (np.eye(3) + np.einsum("kn,kij->nij", wave, a), np.exp(0.17 * wave[0])[:, None, None] * np.eye(3)):
        block = Strained(rng.choice([0.0, 0.3, 0.49]), prony, 1e-4)
        P = np.array([block.stress(F) for F in path])
        parts = np.einsum("nij,nij->n", (P[1:] + P[:-1]) / 2, np.diff(path, axis=0))
        moved = np.abs(parts).sum()
        assert parts.sum() > -1e-4 * moved
    assert abs(parts.sum()) < 1e-4 * moved, "a change of volume alone is elastic"


@pytest.mark.parametrize("seed", range(8))
def test_free_blocks_never_gain_energy(seed):
    rng = np.random.default_rng(100 + seed)
    terms = rng.integers(1, 5)
    prony = [(10 ** rng.uniform(-1, 1.3), 10 ** rng.uniform(-4.5, 0.5)) for _ in range(terms)]
    nu = rng.choice([0.0, 0.2, 0.3, 0.45, 0.49, 0.495])
    mesh = soft_bodies.box((3, 3, 3), (0.03,) * 3)
    soft = soft_bodies.body(mesh, YOUNG, nu, prony=prony, damping=0.0, yeoh=rng.choice([0.0, 0.5]))
    nodes = mesh[0]
    start = nodes + rng.normal(0.0, 3e-4, nodes.shape)
    velocity = (nodes - nodes.mean(axis=0)) @ rng.normal(0.0, 1.0, (3, 3)) + rng.normal(0.0, 0.02, nodes.shape)
    soft.set_state(start, velocity)
    soft.step(1)
    first = sum(soft.energies())
    total = []
    for _ in range(800):
        soft.step(1)
        total.append(sum(soft.energies()))
    assert np.isfinite(total).all()
    assert max(total) < 1.05 * first
    assert total[-1] < first
