"""What priorities take away is never paid back: many loops of the hand over two fixtures, in both directions."""

import itertools

import numpy as np
import pytest
from fixtures import Stage, fixture, placed, plane, pose, sphere
from scipy.spatial.transform import Rotation

from palpate import _core, _guidance

CYCLES = 3
RAMP = {"ramps": [_core.Ramp("distance", 0.0, 0.004)]}
KINDS = {"spring": ("spring", {}), "potential": ("potential", {}), "spring, ramp": ("spring", RAMP),
         "optimise": ("optimise", {}), "optimise, ramp": ("optimise", RAMP)}  # fmt: skip


def ball_across_wall(law, policy):
    """A room in a ball, whose fixture loses what opposes a wall of higher priority."""
    R = Rotation.align_vectors([(0.5, 0.2, 0.8)], [[0.0, 0.0, 1.0]])[0].as_matrix()
    law_ = {"B": 0.0, "range": 0.002, "force": 3.0}
    return [
        fixture(plane(pose(R=R)), "forbid", law, name="wall", law_=law_, priority=1),
        fixture(sphere(0.02, pose((0.004, 0.0, 0.012))), "keep-in", law, name="ball", law_=law_, **policy),
    ]


def returned(fixtures, tips):
    """Energy that the hand has got after each of several cycles over `tips` (n, 3), and the largest stored [J]."""
    stage = Stage(*fixtures)
    stage.settle(tips[0], 2000)
    around = np.concatenate([tips] + [tips[1:]] * (CYCLES - 1))
    F = np.array([stage.step(p)["F_T_W"][:3] for p in around])
    done = -np.cumsum((0.5 * (F[1:] + F[:-1]) * np.diff(around, axis=0)).sum(axis=1))
    return -done[len(tips) - 2 :: len(tips) - 1], float(done.max() - done.min())


def ways(seed, start, n):
    """A closed way from `start`, and the same backwards."""
    inner = np.array([0.004, 0.0, 0.002]) + np.random.default_rng(seed).uniform(-0.022, 0.022, (4, 3))
    knots = np.array([start, *inner, start])
    tips = np.concatenate([np.linspace(a, b, n, endpoint=False) for a, b in itertools.pairwise(knots)] + [knots[-1:]])
    return tips, tips[::-1]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(2))
def test_loops_that_begin_outside_get_nothing(kind, seed):
    """Up to sampling, whose error falls with the step."""
    for tips in ways(seed, (0.004, 0.0, 0.012), 1000):
        got, stored = returned(ball_across_wall(*KINDS[kind]), tips)
        assert stored > 1e-3, "control: the fixtures act"
        assert np.diff(got, prepend=0.0).max() < 3e-3 * stored


@pytest.mark.parametrize("kind", KINDS)
def test_loops_that_begin_inside_get_no_more_than_what_appeared(kind):
    """Both fixtures appear where the tool is: they store the energy there by themselves, once."""
    start = np.array([-0.012, 0.004, -0.012])
    fixtures = ball_across_wall(*KINDS[kind])
    appeared = sum(one.evaluate(pose(start))["U"] for one in fixtures)
    for tips in ways(1, start, 250):
        got, stored = returned(fixtures, tips)
        assert got.max() < 1.05 * appeared + 5e-3 * stored


ROUND = 0.03  # radius of a guide of higher priority [m]


def within_a_round_guide(aim):
    """A sphere that guides, and a point in its surface that pulls with lower priority at the goal that it leaves."""
    ball = fixture(sphere(ROUND), "guide", name="ball", priority=1, law_={"B": 0.0, "K": 50.0})
    pull = fixture(placed(_guidance.PointGeometry(), pose(aim)), "guide", name="pull", law_={"B": 0.0, "K": 100.0})
    return Stage(ball, pull)


@pytest.mark.parametrize("share", [0.9, 0.6, 0.36, 0.3, 0.1, 0.02])
def test_a_goal_that_moves_farther_than_the_hand_pulls_with_at_most_three_times_the_wrench(share):
    """The place on the guide moves by R / rho of the hand's motion, near the centre without bound."""
    stage = within_a_round_guide((ROUND, 0.002, 0.0))
    stage.settle(np.array([share * ROUND, 0.0, 0.0]))
    expected = 0.2 * min(1.0 / share, 3.0)
    np.testing.assert_allclose(stage.core.wrench(1)[:3], [0.0, expected, 0.0], atol=6e-3 * expected)


@pytest.mark.parametrize("deep", [0.45, 0.1, 0.02])
def test_loops_into_the_region_of_that_limit_get_nothing(deep):
    """Along rays and arcs about the centre, in both directions; without the limit only at .45 of the radius."""
    corners = np.array([(0.6, 0.0), (deep, 0.0), (deep, 1.2), (0.6, 1.2), (0.6, 0.0)]) * [ROUND, 1.0]
    for way in (corners, corners[::-1]):
        polar = np.concatenate(
            [np.linspace(a, b, 400, endpoint=False) for a, b in itertools.pairwise(way)] + [way[-1:]]
        )
        tips = np.stack(
            [polar[:, 0] * np.cos(polar[:, 1]), polar[:, 0] * np.sin(polar[:, 1]), 0.0 * polar[:, 0]], axis=1
        )
        stage = within_a_round_guide((ROUND, 0.0, 0.0))
        stage.settle(tips[0], 800)
        around = np.concatenate([tips, tips[1:], tips[1:]])
        F = np.array([stage.settle(p, 2)["F_T_W"][:3] for p in around])
        done = -np.cumsum((0.5 * (F[1:] + F[:-1]) * np.diff(around, axis=0)).sum(axis=1))
        assert np.diff(done[len(tips) - 2 :: len(tips) - 1], prepend=0.0).min() > -2e-3 * np.ptp(done)
