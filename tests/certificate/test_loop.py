"""The sampled loop against closed-loop eigenvalues, closed forms, and numerical integration of the held force."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from palpate.devices.certificate.loop import SampledLoop, _illinois, difference, modes, zero_order_hold


def device(m=0.3, b=0.5, k=0.0, T=1e-3, delay=0.0, cutoff=0.0):
    A = np.array([[0.0, 1.0], [-k / m, -b / m]])
    return SampledLoop(A, np.array([0.0, 1.0 / m]), np.array([1.0, 0.0]), T, delay, velocity=difference(T, cutoff))


def closed(loop, K, B, cutoff=0.0):
    """Closed-loop matrix with delayed forces as states: x, last y, velocity, u[k-1] .. u[k-l-1]."""
    Phi, Gamma0, Gamma1 = loop.sampled
    n, whole = len(Phi), int(loop.delay / loop.T + 1e-9)
    share = -np.expm1(-2 * np.pi * cutoff * loop.T) if cutoff > 0 else 1.0
    size = n + whole + 3
    y, v, M = np.zeros(size), np.zeros(size), np.zeros((size, size))
    y[:n] = loop.c
    v[:n], v[n], v[n + 1] = share / loop.T * loop.c, -share / loop.T, 1.0 - share
    u = -(K * y + B * v)
    M[:n, :n], M[n], M[n + 1], M[n + 2] = Phi, y, v, u
    for i in range(whole):
        M[n + 3 + i, n + 2 + i] = 1.0
    past = np.vstack([u, np.eye(size)[n + 2 :]])
    M[:n] += np.outer(Gamma0, past[whole]) + np.outer(Gamma1, past[whole + 1])
    return M


def radius(*args):
    return np.abs(np.linalg.eigvals(closed(*args))).max()


def random_loops(count):
    rng = np.random.default_rng(3)
    for _ in range(count):
        m, b, T = 10 ** rng.uniform(-1.3, 0.3), 10 ** rng.uniform(-1, 1.3), 10 ** rng.uniform(-4, -2)
        k, cutoff = rng.choice([0.0, 10 ** rng.uniform(1, 3)]), rng.choice([0.0, 10 ** rng.uniform(1, 2.5)])
        loop = device(m, b, k, T, rng.uniform(0, min(0.02, 40 * T)), cutoff)
        yield loop, cutoff, rng.uniform(0, 0.9) * min(loop.B_max, 50.0)


def test_roots_of_the_closed_loop_leave_the_circle_at_the_limit():
    for loop, cutoff, B in random_loops(30):
        K, _ = loop.K_max(B)
        assert all(radius(loop, share * K, B, cutoff) < 1 + 1e-9 for share in (0.1, 0.4, 0.7, 0.999))
        assert radius(loop, 1.001 * K, B, cutoff) > 1
        if np.isfinite(loop.B_max):
            assert radius(loop, 0.0, 0.999 * loop.B_max, cutoff) < 1 + 1e-9
            assert radius(loop, 0.0, 1.001 * loop.B_max, cutoff) > 1 + 1e-9


@pytest.mark.parametrize(("b", "T"), [(0.5, 1e-3), (5.0, 1e-2)])
def test_a_free_device_without_delay_has_a_closed_form(b, T):
    m = 0.3
    tau, a = m / b, np.exp(-b * T / m)
    assert device(m, b, T=T).K_max(0.0)[0] == pytest.approx(b * (1 - a) / (tau * (1 - a) - a * T), rel=1e-8)


def test_fast_sampling_without_delay_is_colgate_and_browns_bound():
    loop = device(m=1.0, b=2.0, T=1e-5)
    assert loop.K_max(0.0)[0] == pytest.approx(2 * 2.0 / 1e-5, rel=1e-3)  # 2 b / T


def test_long_delay_matches_the_continuous_loop():
    """m w^2 = k + K cos(w d), b w = K sin(w d): continuous time, as T -> 0."""
    m, b, k, d = 0.4, 6.0, 200.0, 0.012
    K, w = device(m, b, k, 1e-5, d - 0.5e-5).K_max(0.0)
    assert K * np.sin(w * d) == pytest.approx(b * w, rel=1e-3)
    assert k + K * np.cos(w * d) == pytest.approx(m * w**2, rel=1e-3)


def test_fractional_delays_interpolate_between_whole_periods():
    limits = [device(b=4.0, k=100.0, delay=d * 1e-3).K_max(0.0)[0] for d in (2.0, 2.25, 2.5, 2.75, 3.0)]
    assert all(np.diff(limits) < 0)
    assert 1 / limits[2] == pytest.approx(0.5 * (1 / limits[0] + 1 / limits[4]), rel=0.01)  # K ~ 1 / delay


def test_zero_order_hold_matches_numerical_integration():
    A, b = np.array([[0.0, 1.0], [-500.0, -3.0]]), np.array([0.0, 2.0])
    Phi, Gamma = zero_order_hold(A, b, 0.02)
    x = solve_ivp(lambda t, x: A @ x + b, (0, 0.02), [0.01, -0.3], rtol=1e-11, atol=1e-14).y[:, -1]
    assert Phi @ [0.01, -0.3] + Gamma == pytest.approx(x, abs=1e-11)
    Phi, Gamma = zero_order_hold(np.array([[-7.0]]), np.array([3.0]), 0.1)
    assert (Phi.item(), Gamma.item()) == pytest.approx((np.exp(-0.7), 3.0 / 7.0 * -np.expm1(-0.7)))


def test_a_critically_damped_device_has_equal_poles_and_a_limit():
    m, k = 0.5, 200.0
    near, exact = (device(m, b, k, delay=2e-3).K_max(1.0)[0] for b in (20.0 * 1.0001, 20.0))
    assert exact == pytest.approx(near, rel=1e-3)
    poles, V, V_inverse = modes(np.array([[0.0, 1.0], [-k / m, -20.0 / m]]))
    assert (V * poles) @ V_inverse == pytest.approx(np.array([[0.0, 1.0], [-k / m, -20.0 / m]]), rel=1e-4, abs=1e-4)


@pytest.mark.parametrize("delay", [6e-3, 9.3e-3, 15e-3])
def test_limit_vanishes_at_the_largest_damping(delay):
    """Even very close to zero, the lowest crossing is the limit, not a crossing far above."""
    loop = device(m=0.45, b=10.6, k=300.0, delay=delay, cutoff=100.0)
    shares = 1.0 - np.logspace(-7, -1, 25)
    K = np.array([loop.K_max(share * loop.B_max)[0] for share in shares])
    assert np.all(K[1:] > K[:-1])
    assert K[0] < 1e-3 * loop.K_max(0.0)[0]
    assert (
        radius(loop, 1.01 * K[12], shares[12] * loop.B_max, 100.0)
        > 1
        > radius(loop, 0.99 * K[12], shares[12] * loop.B_max, 100.0)
    )


def test_damping_raises_then_lowers_the_limit():
    loop = device(b=3.0, delay=4e-3, cutoff=80.0)
    few, some, much = (loop.K_max(share * loop.B_max)[0] for share in (0.0, 0.4, 0.98))
    assert few < some > much
    assert loop.K_max(1.01 * loop.B_max) == (0.0, 0.0)


def test_a_filter_of_one_period_anywhere_in_the_loop_is_one_period_of_delay():
    """The filter 1 / z acts on the force, or on position and velocity."""
    loop = device(b=3.0, k=50.0, delay=1.4e-3, cutoff=90.0)
    late = loop.delayed(2.4e-3)
    on_force = replace(loop, force=lambda z: 1.0 / z)
    on_motion = replace(loop, position=lambda z: 1.0 / z, velocity=lambda z: loop.velocity(z) / z)
    for B in (0.0, 0.5 * late.B_max):
        assert on_force.K_max(B) == pytest.approx(late.K_max(B), rel=1e-6)
        assert on_motion.K_max(B) == pytest.approx(late.K_max(B), rel=1e-6)


@pytest.mark.parametrize(
    ("grams", "w", "zeta", "delay", "B"),
    [(0.032, 241.3, 1.0e-5, 6.37e-3, 7.07), (0.166, 145.2, 1.3e-5, 7.55e-3, 7.49),
     (0.352, 186.3, 2.1e-4, 6.91e-3, 7.12), (0.440, 710.2, 4.8e-5, 0.74e-3, 5.69),
     (0.651, 224.1, 7.4e-5, 4.27e-3, 8.64), (1.343, 355.7, 4.3e-5, 2.38e-3, 6.87), (300.0, 500.0, 0.01, 3.0e-3, 5.0)],
)  # fmt: skip
def test_a_lightly_damped_resonance_is_not_missed(grams, w, zeta, delay, B):
    """A small mass on a spring at the handle swings within a band much narrower than the distance of frequencies."""
    m, m_2 = 0.1, 1e-3 * grams
    k, b = m_2 * w**2, 2.0 * zeta * m_2 * w
    M, A = np.array([m, m_2])[:, None], np.zeros((4, 4))
    A[:2, 2:] = np.eye(2)
    A[2:, :2] = -np.array([[k + 100.0, -k], [-k, k]]) / M
    A[2:, 2:] = -np.array([[b + 3.0, -b], [-b, b]]) / M
    y = np.array([1.0, 0.0, 0.0, 0.0])
    loop = SampledLoop(A, np.array([0.0, 0.0, 1.0 / m, 0.0]), y, 1e-3, delay, velocity=difference(1e-3))
    K, _ = loop.K_max(B)
    assert radius(loop, 0.999 * K, B) < 1.0 + 1e-9
    assert radius(loop, 1.001 * K, B) > 1.0
    assert all(radius(loop, share * K, B) < 1.0 + 1e-9 for share in (0.1, 0.4, 0.7))


def test_the_fast_search_finds_roots_of_bent_functions_from_either_side():
    """Roots of x^3 - c and c - x^3 between 0 and 3, which are the cube roots."""
    c = np.array([0.5, 2.0, 8.5, 20.0])
    low, high = np.zeros(4), np.full(4, 3.0)
    for sign in (1.0, -1.0):
        found = _illinois(lambda x, sign=sign: sign * (x**3 - c), low, high, -sign * c, sign * (27.0 - c))
        np.testing.assert_allclose(found, np.cbrt(c), rtol=1e-5)
