"""Partial surfaces: right answers near and far from the start, and wrong answers that are told as wrong."""

import builtins
import os
from pathlib import Path

import numpy as np
import pytest

from palpate.base.arrays import rigid
from palpate.base.errors import MissingExtraError, RegistrationError
from palpate.world import registration
from palpate.world.registration import icp, trust
from palpate.world.registration.clouds import Cloud, sampled
from palpate.world.shapes.organs import organ
from palpate_lab.studies.registration import surfaces

VERTICES, TRIANGLES = organ(3000)
FIXED = sampled(VERTICES, TRIANGLES, 12_000)
POOL = sampled(VERTICES, TRIANGLES, 4000, seed=1)
DATA = Path(os.environ.get("PALPATE_DATA") or Path(__file__).resolve().parents[3] / "shared" / "data") / "clouds"


@pytest.fixture(scope="module")
def view():
    """A view in its own frame, the truth, and a rough pose."""
    rng = np.random.default_rng(0)
    X = rigid.rigid(rigid.exp(rng.normal(size=3)), rng.uniform(-0.05, 0.05, 3))
    seen = surfaces.view(rng, POOL)
    start = surfaces.rough(rng, seen, X, (0.5, 0.52), 0.03)
    return rigid.transform(np.linalg.inv(X), seen), X, start


def error(found, m, X):
    return np.sqrt(np.square(rigid.transform(found.X, m) - rigid.transform(X, m)).sum(axis=1).mean())


def test_view_is_registered_from_a_rough_pose(view):
    m, X, start = view
    found = registration.surface(m, FIXED, start, [[0.0, 0.0, 0.0]])
    assert error(found, m, X) < 2e-3
    assert found.trusted, found.doubts
    assert found.fle == pytest.approx(1e-3, rel=0.15)
    assert found.tre[0] > 0.0
    assert 0.9 < found.explained < 0.99


def test_view_is_registered_without_a_start(view):
    m, X, _ = view
    found = registration.surface(m, FIXED)
    assert error(found, m, X) < 2e-3
    assert found.trusted


def test_mirrored_view_is_not_trusted(view):
    m, _, start = view
    assert not registration.surface(m * [1, 1, -1], FIXED, start).trusted


def test_each_doubt_is_raised_by_its_own_fault(view):
    """The right answer is spoiled in one way at a time."""
    m, X, _ = view
    moving, fixed = Cloud(m), Cloud(FIXED)
    right = trust.judge(X, moving, fixed, 1.05e-3, 0.85, 4000)
    assert right.doubts == ()

    def doubts(X=X, moving=moving, fixed=fixed, sigma=1.05e-3, overlap=0.85):
        return " ".join(trust.judge(X, moving, fixed, sigma, overlap, 4000).doubts)

    away = X.copy()
    away[:3, 3] += 8e-3
    assert "lie on the surface" in doubts(away)
    tilted = rigid.displaced(X, [0.0, 0.0, 0.0, 0.0, 0.02, 0.02])
    tilted[:3, 3] += rigid.transform(X, m).mean(axis=0) - rigid.transform(tilted, m).mean(axis=0)
    assert "neighbouring residuals agree" in doubts(tilted)
    assert "as large as the noise" in doubts(sigma=0.5e-3, overlap=0.1)
    plane = np.random.default_rng(1).uniform(-0.05, 0.05, (3000, 3)) * [1, 1, 0]
    noisy = plane[:1000] + np.random.default_rng(2).normal(scale=1e-3, size=(1000, 3))
    slides = doubts(
        np.eye(4), Cloud(noisy), Cloud(plane + [0, 0, 1e-7] * np.random.default_rng(3).normal(size=(3000, 3)))
    )
    assert "slide" in slides
    assert trust.doubts_of_rival(1.05) != ()
    assert trust.doubts_of_rival(2.0) == ()


def test_step_reduces_the_cost_and_keeps_poses_rigid(view):
    m, _, start = view
    X, after = icp.iterate(start[None], m[:200], Cloud(FIXED), 2e-3, 10)
    assert after[0] < icp.costs(start[None], m[:200], Cloud(FIXED), 2e-3)[0]
    assert X[0, :3, :3] @ X[0, :3, :3].T == pytest.approx(np.eye(3), abs=1e-12)


def waves(rng, n, noise, extent=0.04):
    """Points (n, 3) on z = f(x, y) with noise along the normal [m]."""
    x, y = rng.uniform(-extent, extent, (2, n))
    z = 0.006 * np.sin(50 * x) * np.cos(35 * y) + 0.004 * np.sin(20 * x + 35 * y)
    slope_x = 0.3 * np.cos(50 * x) * np.cos(35 * y) + 0.08 * np.cos(20 * x + 35 * y)
    slope_y = -0.21 * np.sin(50 * x) * np.sin(35 * y) + 0.14 * np.cos(20 * x + 35 * y)
    normal = np.stack([-slope_x, -slope_y, np.ones(n)], axis=1)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return np.stack([x, y, z], axis=1) + noise * rng.normal(size=(n, 1)) * normal


@pytest.mark.parametrize("n", [2500, 20_000])
def test_covariance_of_the_last_step_is_right_for_any_number_of_points(n):
    """The fit uses 4000 points at most, and the covariance counts these alone."""
    rng, noise, squares = np.random.default_rng(5), 0.4e-3, []
    fixed = Cloud(waves(rng, 40_000, 0.0, 0.045))
    for _ in range(12):
        moving = Cloud(waves(rng, n, noise))
        X = icp.least_squares(np.eye(4), moving.thinned(4000), fixed, noise, 4)
        found = trust.judge(X, moving, fixed, noise, 0.85, 4000)
        xi = rigid.displacement(X, np.eye(4))
        squares.append(xi @ np.linalg.solve(found.covariance, xi) / 6.0)
        assert found.doubts == ()
    assert 0.5 < np.mean(squares) < 1.7  # 72 degrees of freedom, and shares of patches


@pytest.mark.parametrize(("n", "noise"), [(3000, 0.2e-3), (30_000, 0.5e-3), (30_000, 1e-3)])
def test_noise_is_estimated_where_it_exceeds_the_spacing(n, noise):
    assert Cloud(waves(np.random.default_rng(6), n, noise)).noise == pytest.approx(noise, rel=0.12)


def test_samples_of_a_mesh_are_spread_by_area():
    """Two triangles, one with four times the area of the other, both in known planes."""
    v = np.array([[0, 0, 0], [2, 0, 0], [0, 2, 0], [0, 0, 5], [1, 0, 5], [0, 1, 5]], dtype=float)
    p = sampled(v, np.array([[0, 1, 2], [3, 4, 5]]), 5000)
    assert (p[:, 2] < 1).mean() == pytest.approx(0.8, abs=0.01)
    assert p[p[:, 2] < 1].mean(axis=0) == pytest.approx([2 / 3, 2 / 3, 0], abs=0.03)


@pytest.mark.parametrize(
    ("moving", "fixed", "message"),
    [
        (POOL[:20], FIXED, "at least 50"),
        (1e3 * POOL[:200], FIXED, "ratio near 1000"),
        (np.where(np.arange(600).reshape(200, 3) == 9, np.inf, POOL[:200]), FIXED, "point 3"),
    ],
)
def test_bad_clouds_are_refused(moving, fixed, message):
    with pytest.raises(RegistrationError, match=message):
        registration.surface(moving, fixed)


def test_missing_small_gicp_names_the_extra(view, monkeypatch):
    real_import = builtins.__import__

    def without(name, *args, **more):
        if name == "small_gicp":
            raise ModuleNotFoundError(name)
        return real_import(name, *args, **more)

    monkeypatch.setattr(builtins, "__import__", without)
    m, _, start = view
    with pytest.raises(MissingExtraError, match=r"palpate\[registration\]"):
        registration.surface(m, FIXED, start)


@pytest.mark.skipif(not DATA.is_dir(), reason="the real clouds are absent (PALPATE_DATA)")
def test_real_pair_agrees_with_small_gicp():
    found = surfaces.real()
    assert found["trusted"]
    assert found["explained"] > 0.9
    assert found["from_small_gicp_m"] < 5e-3
    assert found["moved_m"] > 0.02
