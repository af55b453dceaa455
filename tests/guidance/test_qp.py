"""The quadratic program against an interior-point solver and the optimality conditions; degenerate problems."""

import clarabel
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import sparse

from palpate import _guidance


def program(seed, m=20, tight=0.2):
    """A feasible random program: the origin satisfies every row."""
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(m, 6))
    return A, -tight * rng.random(m), rng.normal(size=6)


def reference(A, b, y0):
    """The solution of clarabel."""
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = 1e-12
    cones = [clarabel.NonnegativeConeT(len(b))]
    P, A_ = sparse.csc_matrix(np.eye(6)), sparse.csc_matrix(-A)
    return np.array(clarabel.DefaultSolver(P, -y0, A_, -b, cones, settings).solve().x)


def residuals(A, b, y0, found):
    """Residuals of the Karush-Kuhn-Tucker conditions: stationarity, rows, multipliers, complementarity."""
    y, lam = found["y"], found["multipliers"]
    slack = A @ y - b
    return [np.abs(y - y0 - A.T @ lam).max(), max(-slack.min(), 0.0), max(-lam.min(), 0.0), np.abs(lam * slack).max()]


@pytest.mark.parametrize("m", [1, 3, 12, 100])
def test_solution_agrees_with_an_interior_point_solver(m):
    qp = _guidance.Qp()
    for seed in range(40):
        A, b, y0 = program(seed, m)
        found = qp.solve(A, b, y0)
        assert found["status"] == "solved"
        np.testing.assert_allclose(found["y"], reference(A, b, y0), atol=2e-6)
        assert max(residuals(A, b, y0, found)) < 1e-8


def test_warm_start_gives_the_same_solution_in_fewer_steps():
    """The problem changes a little from tick to tick."""
    warm, rng = _guidance.Qp(), np.random.default_rng(3)
    A, b, y0 = program(5, 100)
    steps = {"warm": 0, "cold": 0}
    for _ in range(200):
        y0 = y0 + 0.01 * rng.normal(size=6)
        one, other = warm.solve(A, b, y0), _guidance.Qp().solve(A, b, y0)
        np.testing.assert_allclose(one["y"], other["y"], atol=1e-9)
        steps["warm"] += one["steps"]
        steps["cold"] += other["steps"]
    assert steps["warm"] < steps["cold"]


def test_contradicting_rows_yield_by_rank():
    a = np.eye(6)[0]
    A, b = np.array([a, -a]), np.array([1.0, 1.0])  # y0 >= 1 and y0 <= -1
    for ranks, kept in (([0, 1], 1), ([1, 0], 0)):
        found = _guidance.Qp().solve(A, b, np.zeros(6), ranks)
        assert found["status"] == "relaxed"
        assert found["gave_way"] == [kept != 0, kept != 1]
        np.testing.assert_allclose(found["y"], (1.0 if kept == 0 else -1.0) * a, atol=1e-12)


def test_rows_of_higher_rank_are_satisfied_despite_contradictions():
    """All rows of rank 1 are feasible together; those of rank 0 are not."""
    rng = np.random.default_rng(0)
    for _ in range(50):
        A, b, y0 = program(rng.integers(1 << 30), 30)
        wild = rng.normal(size=(10, 6)), rng.normal(size=10) + 2.0
        ranks = [0] * 10 + [1] * 30
        found = _guidance.Qp().solve(np.vstack([wild[0], A]), np.concatenate([wild[1], b]), y0, ranks)
        assert (A @ found["y"] - b).min() > -1e-8
        assert not any(found["gave_way"][10:])


def test_invalid_rows_are_reported_and_the_others_solved():
    A = np.array([np.full(6, np.nan), np.zeros(6), np.eye(6)[1], np.eye(6)[2] * 1e300])
    found = _guidance.Qp().solve(A, [0.0, 1.0, 0.5, np.inf], np.zeros(6))
    assert found["rows"][:2] == [-1, -1]
    assert found["rows"][3] == -1
    np.testing.assert_allclose(found["y"], 0.5 * np.eye(6)[1], atol=1e-12)


@settings(max_examples=200, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 120), st.sampled_from([0.0, 1e-12, 1e-7, 1e-3, 1.0]))
def test_solver_ends_with_finite_values_for_degenerate_rows(seed, m, spread):
    """Rows nearly equal, parallel, opposite, contradictory: within the step limit, finite, with a true status."""
    rng = np.random.default_rng(seed)
    A = rng.choice([-1.0, 1.0], (m, 1)) * np.eye(6)[rng.integers(0, 2, m)] + spread * rng.normal(size=(m, 6))
    b, y0 = rng.normal(size=m) * rng.choice([0.0, 1.0]), rng.normal(size=6)
    found = _guidance.Qp().solve(A, b, y0, rng.integers(0, 3, m).tolist())
    assert np.isfinite(found["y"]).all()
    assert found["steps"] <= 121
    kept = ~np.array(found["gave_way"])
    if found["status"] == "solved":
        assert kept.all()
    if found["status"] != "stopped":
        scale = np.linalg.norm(A[kept], axis=1)
        assert ((A[kept] @ found["y"] - b[kept]) / scale).min(initial=0.0) > -1e-8


def test_infeasible_rows_are_violated_minimally_by_priority():
    """Half-spaces around the origin that all exclude it: the result is the least sum of squares by rank."""
    from scipy.optimize import minimize

    rng = np.random.default_rng(4)
    A = rng.normal(size=(300, 6))
    A /= np.linalg.norm(A, axis=1, keepdims=True)
    b, ranks = rng.uniform(0.1, 1.0, 300), np.r_[np.zeros(200, int), np.full(100, 1)]
    found = _guidance.Qp().solve(A, b, np.zeros(6), ranks.tolist())
    assert found["status"] == "stopped"

    def cost(y, w):
        lacks = np.maximum(b - A @ y, 0.0)
        return (w * lacks**2).sum(), -2.0 * A.T @ (w * lacks)

    high = np.where(ranks == 1, 1.0, 0.0)
    best = minimize(cost, np.zeros(6), (high,), jac=True, options={"gtol": 1e-12})
    assert cost(found["y"], high)[0] <= best.fun * (1 + 1e-3) + 1e-8, "the violation of the higher rank is minimal"
    weighed = np.where(ranks == 1, 1e4, 1.0)
    best = minimize(cost, found["y"], (weighed,), jac=True, options={"gtol": 1e-9})
    assert cost(found["y"], weighed)[0] <= best.fun * (1 + 1e-4)
