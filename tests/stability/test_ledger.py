"""The energy ledger against plain sums, and against what a spring and a damper are known to do."""

import numpy as np
import pytest

from palpate import _core


def run(x, F, F_damping, F_cut, spring):
    ledger = _core.Ledger()
    steps = (ledger.step(*row) for row in zip(x, F, F_damping, F_cut, spring, strict=True))
    return np.array([(e.port, e.spring, e.damping, e.cut) for e in steps])


def test_each_force_times_the_motion_while_it_was_held():
    rng = np.random.default_rng(3)
    x, F, Fd, Fc = (rng.normal(size=(500, 3)) for _ in range(4))
    spring = rng.uniform(size=500)
    energy = run(x, F, Fd, Fc, spring)
    dx = np.diff(x, axis=0)
    for column, force in ((0, F), (2, Fd), (3, Fc)):
        expected = np.concatenate([[0], np.cumsum(-np.einsum("ij,ij->i", force[:-1], dx))])
        np.testing.assert_allclose(energy[:, column], expected, atol=1e-12)
    np.testing.assert_array_equal(energy[:, 1], spring)


def test_a_sampled_spring_generates_what_colgate_says():
    """A spring held between samples, pressed and released: the port gives K dx^2 per pair of samples."""
    K, steps, d = 400.0, 100, 1e-4
    depth = d * np.concatenate([np.arange(steps + 1), np.arange(steps - 1, -1, -1)])
    x = np.outer(-depth, [0, 0, 1.0])
    F = np.outer(K * depth, [0, 0, 1.0])
    zero = np.zeros_like(F)
    energy = run(x, F, zero, zero, 0.5 * K * depth**2)
    assert energy[steps, 0] == pytest.approx(0.5 * K * depth.max() ** 2 - 0.5 * K * d**2 * steps)
    assert energy[-1, 0] == pytest.approx(-K * d**2 * steps)  # below zero: the zero-order hold made it


def test_a_damper_only_takes():
    b, dt = 5.0, 1e-3
    t = dt * np.arange(2000)
    v = 0.1 * np.sin(20 * t)
    x = np.zeros((2000, 3))
    x[1:, 0] = np.cumsum(v[:-1] * dt)
    F = np.outer(-b * v, [1.0, 0, 0])
    energy = run(x, F, F, np.zeros_like(F), np.zeros(2000))
    assert (np.diff(energy[:, 2]) >= 0).all()
    np.testing.assert_array_equal(energy[:, 0], energy[:, 2])
    assert energy[-1, 2] == pytest.approx(np.sum(b * v[:-1] ** 2 * dt))
