"""The cap of the force as a spring that saturates: no loop gains energy by it, and the force is at most the cap."""

import itertools
import math

import numpy as np
import pytest
from effort import examples
from hypothesis import given, settings
from hypothesis import strategies as st

from palpate import _core, _verify

CAP = 1.0
SOFT, HARD = 400.0, 1200.0  # stiffness of the floor, and in the middle of its lump [N/m]


def limiter(**values):
    options = _core.StabilityOptions()
    options.force_cap, options.rate_cap = CAP, 1e9
    for name, value in values.items():
        setattr(options, name, value)
    return _verify.Limiter(options, 1e-3)


def lump(p):
    """Force (3,) [N] and energy [J] of a floor at z = 0 with a hard lump at x = 0."""
    bump = (HARD - SOFT) * np.exp(-((p[0] / 0.003) ** 2))
    d = max(-p[2], 0.0)
    return np.array([bump * p[0] / 0.003**2 * d * d, 0.0, (SOFT + bump) * d]), 0.5 * (SOFT + bump) * d * d


def forces(way, known):
    """Forces (n, 3) along the way, with the energy known or not."""
    one, out = limiter(), np.zeros((len(way), 3))
    for k, p in enumerate(way):
        F, U = lump(p)
        work = -out[k - 1] @ (p - way[k - 1]) if k else 0.0
        out[k] = one.step(F, potential=U if known else math.inf, work=work)[0]
    return out


def way(*corners, n=4000):
    """A way (m, 3) through the corners (x, z) [m]."""
    c = np.array([(x, 0.0, z) for x, z in corners])
    return np.concatenate([a + np.linspace(0, 1, n)[:, None] * (b - a) for a, b in itertools.pairwise(c)])


def work(F, p):
    """Energy that the hand has put in at each place [J]."""
    return -np.cumsum((0.5 * (F[1:] + F[:-1]) * np.diff(p, axis=0)).sum(axis=1))


LOOPS = {
    "in beside the lump, out on it": way((-0.006, 0.001), (-0.006, -0.006), (0, -0.006), (0, 0.001), (-0.006, 0.001)),
    "in on the lump, out beside it": way((0, 0.001), (0, -0.006), (-0.006, -0.006), (-0.006, 0.001), (0, 0.001)),
    "over the lump five times": way((-0.006, 0.001), *[(x, -0.005) for x in (-0.006, 0.006) * 5], (-0.006, 0.001)),
}


@pytest.mark.parametrize("name", LOOPS)
def test_a_capped_lump_hands_out_no_energy(name):
    p = LOOPS[name]
    kept, cut = work(forces(p, True), p), work(forces(p, False), p)
    assert kept[-1] > -1e-3 * kept.max()
    assert np.linalg.norm(forces(p, True), axis=1).max() <= CAP
    if "beside the lump" in name:
        assert min(cut[-1], -cut[-1]) < -0.05 * cut.max()  # cut to the length, one of the directions gains energy


def test_one_direction_gains_energy_where_the_force_is_cut_to_its_length():
    gains = [work(forces(p, False), p)[-1] for p in list(LOOPS.values())[:2]]
    assert min(gains) < -1e-4


def test_a_spring_of_constant_stiffness_is_held_at_the_cap():
    one, d = limiter(), np.r_[np.linspace(0, 0.01, 500), np.linspace(0.01, 0, 500)]
    for depth in d:
        F, _, status = one.step(np.array([0, 0, SOFT * depth]), potential=0.5 * SOFT * depth**2)
        assert F[2] == pytest.approx(min(SOFT * depth, CAP), abs=1e-11)
        assert bool(status & 1) == (SOFT * depth > CAP * (1 + 1e-9))


def test_a_force_beyond_the_spring_shortens_it_only_while_it_lasts():
    """Damping of 1 N while the hand goes in: at rest the force is back at the cap."""
    one, d, F = limiter(), np.linspace(0, 0.01, 500), np.zeros(3)
    for depth in d:
        F, _, _ = one.step(np.array([0, 0, SOFT * depth + 1.0]), potential=0.5 * SOFT * depth**2, work=F[2] * d[1])
        assert F[2] == pytest.approx(CAP, abs=1e-9)
    F, _, _ = one.step(np.array([0, 0, SOFT * 0.01]), potential=0.5 * SOFT * 0.01**2)
    assert F[2] == pytest.approx(CAP, abs=1e-9)


@settings(max_examples=examples(200), deadline=None)
@given(st.lists(st.tuples(st.floats(-50, 50), st.floats(-50, 50), st.floats(-1, 10) | st.just(math.nan)), max_size=60))
def test_no_energy_lets_the_force_exceed_the_cap(ticks):
    one = limiter()
    for fx, fz, U in ticks:
        F, cut, _ = one.step(np.array([fx, 0.0, fz]), potential=U)
        assert np.linalg.norm(F) <= CAP
        np.testing.assert_allclose(F + cut, [fx, 0.0, fz], atol=1e-12)
