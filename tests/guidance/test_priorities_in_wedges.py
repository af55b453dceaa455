"""Fixtures of lower priority never push against higher ones, in acute wedges too; damping of an admittance master."""

from itertools import pairwise

import numpy as np
from fixtures import DT, Stage, fixture, placed, plane, pose
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from palpate import _guidance


def walls(normals, depths, p, **policy):
    """Half-spaces with the outside along each normal (m, 3); the point p is `depths` [m] inside."""
    made = []
    for i, (n, depth) in enumerate(zip(normals, depths, strict=True)):
        R = Rotation.align_vectors([n], [[0.0, 0.0, 1.0]])[0].as_matrix()
        made.append(fixture(plane(pose(p + depth * n, R)), name=f"wall {i}", law_={"B": 0.0}, **policy))
    return made


LEFT, RAMP = 1e-3, 2e-4  # part of a wrench that is left [-], and depth below a border in which it fades [m]


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 6), st.floats(1e-3, 1.0))
def test_a_guide_in_a_wedge_acts_where_the_walls_leave_the_goal(seed, m, spread):
    """Reference: least squares of numpy; `spread` sets how acute the wedges are. No wall is pushed by more than 2 %."""
    rng = np.random.default_rng(seed)
    normals = rng.choice([-1.0, 1.0], (m, 1)) * np.array([0.0, 0.0, 1.0]) + spread * rng.normal(size=(m, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    p, goal = rng.normal(size=3) * 0.01, rng.normal(size=3) * 0.01
    pull = fixture(placed(_guidance.PointGeometry(), pose(goal)), "guide", name="goal", law_={"K": 300.0, "B": 0.0})
    depths = rng.uniform(0.0005, 0.002, m)
    stage = Stage(*walls(normals, depths, p, priority=1), pull)
    stage.settle(p, 250)
    F = stage.core.wrench(m)[:3]
    rows = np.concatenate([np.eye(3), normals / np.sqrt(LEFT)])
    y = p + np.linalg.lstsq(rows, np.r_[np.zeros(3), (depths - RAMP / 2) / np.sqrt(LEFT)])[0]
    J = np.linalg.inv(rows.T @ rows)  # of the same least squares
    np.testing.assert_allclose(F, J @ (300.0 * (goal - y)), atol=1e-6)
    assert np.abs(normals @ F).max() < 2e-2 * np.linalg.norm(300.0 * (goal - y)) + 1e-9


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from(["planes", "tubes"]))
def test_a_loop_over_two_soft_fixtures_of_different_priority_gives_nothing(seed, shape):
    """Slopes, or tubes to which both are drawn: random closed loops at rest, energy by the trapezoidal rule."""
    rng = np.random.default_rng(seed)
    made = []
    for i in range(2):
        R = Rotation.from_rotvec(0.7 * rng.normal(size=3)).as_matrix()
        at = 0.002 * rng.normal(size=3)
        law = {"law_": {"K": float(rng.uniform(100, 500)), "B": 0.0}, "priority": i, "name": str(i)}
        if shape == "planes":
            made.append(fixture(plane(pose(at, R)), **law))
        else:
            line = _guidance.LineGeometry(at, at + 0.1 * R[:, 2], True)
            made.append(fixture(placed(line), "guide", role_={"margin": 0.001}, **law))
    stage = Stage(*made)
    corners = 0.003 * rng.normal(size=(4, 3))
    corners = np.concatenate([corners, corners[:1]])
    way = np.concatenate([a + np.linspace(0, 1, 400)[:, None] * (b - a) for a, b in pairwise(corners)])
    stage.settle(way[0], 300)
    F = np.array([stage.settle(p, 3)["F_T_W"][:3] for p in way])
    work = -np.cumsum((0.5 * (F[1:] + F[:-1]) * np.diff(way, axis=0)).sum(axis=1))
    assert abs(work[-1]) < 2e-3 * (work.max() - work.min()) + 1e-7


def test_acute_wedge_of_hard_walls_is_kept():
    """A guide pulls into two walls at 20 degrees; the correction of one alone would violate the other."""
    normals = np.array([[np.cos(a), 0.0, np.sin(a)] for a in np.radians([100.0, 260.0])])
    p = np.zeros(3)
    pull = fixture(placed(_guidance.PointGeometry(), pose((0.05, 0.0, 0.01))), "guide", name="goal", law_={"K": 100.0})
    stage = Stage(*walls(normals, [0.001, 0.001], p, hard=True), pull)
    stage.settle(p, 2000)
    assert (normals @ stage.core.wrench(2)[:3]).min() > -1e-7


def test_damping_of_an_admittance_master_changes_no_faster_than_a_force():
    """A hand at 0.1 m/s; damping edited from 10 to 100 N s/m, switched off and on: at most 20 N/s of change."""
    line = placed(_guidance.LineGeometry(np.zeros(3), np.array([0.1, 0.0, 0.0]), True))
    V = np.array([0.1, 0.0, 0.0, 0.0, 0.0, 0.0])

    def made(B, on=True):
        return fixture(line, "guide", "admittance", law_={"B": B, "ratio": 1.0}, rise=0.01, fall=0.01, on=on)

    stage, before, felt = Stage(made(10.0)), np.zeros(3), []
    for k in range(2400):
        if k in (600, 1200, 1800):
            stage.set_fixtures({600: made(100.0), 1200: made(100.0, False), 1800: made(100.0)}[k])
        now = stage.step(np.zeros(3), V=V, takes_damping=True)["B_W"] @ V[:3]
        assert np.linalg.norm(now - before) <= 20.0 * DT * (1 + 1e-9)
        before = now
        felt.append(now[0])
    np.testing.assert_allclose([felt[k] for k in (599, 1199, 1799)], [1.0, 10.0, 0.0], atol=1e-9)
