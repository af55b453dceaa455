"""Way points: whatever the arm does between two of them keeps the clearance."""

from itertools import pairwise

import numpy as np
import pytest
from planning_worlds import at, posts, problem, psm, reaching

from palpate.base.errors import PlanningError
from palpate.planning.checker import Checker
from palpate.planning.curves import line
from palpate.planning.waypoints import SPREAD, blocked, waypoints
from palpate.planning.world import World, obstacle
from palpate.world import surfaces

A, B = reaching(-0.055, 0.0, -0.12), reaching(0.055, 0.0, -0.12)


def half_difference(share: np.ndarray) -> float:
    """Largest distance of the joints' shares (k, n) from the middle between first and last."""
    return float(0.5 * np.ptp(share, axis=1).max())


def test_joints_of_the_simulated_dvrk_are_not_in_step_but_within_the_spread() -> None:
    dvrk = pytest.importorskip("palpate.simulators.dvrk", reason="the simulated dVRK is not compiled")
    goals = ([0.7, 0.05, 0.13, 0, 0, 0], [-0.3, 0.5, 0.2, 1.5, 0.5, -1.0], [0.0, -0.02, 0.1, 1.4, 0.4, -0.1])
    robot, worst = dvrk.system(("PSM1",)), 0.0
    robot.send("PSM1", "state_command", "home")
    robot.step(3 * 12_000)
    for goal in goals:
        rows = [np.array(robot.state("PSM1")["setpoint_js"]["position"])]
        robot.send("PSM1", "move_jp", goal)
        for _ in range(600):
            robot.step(15)
            rows.append(np.array(robot.state("PSM1")["setpoint_js"]["position"]))
        way = np.array(goal) - rows[0]
        assert np.abs(rows[-1] - goal).max() < 1e-9
        moves = np.abs(way) > 1e-3
        worst = max(worst, half_difference((np.array(rows) - rows[0])[:, moves] / way[moves]))
    assert 0.02 < worst <= SPREAD


def test_profiles_with_limited_jerk_are_within_the_spread() -> None:
    """From the shortest ramps to none, symmetric profiles of speed with linear or constant acceleration."""
    tau = np.linspace(0.0, 1.0, 2001)
    shares = []
    for ramp in (1e-3, 0.1, 0.25, 0.5):  # of the duration, in which the speed grows
        for smooth in (True, False):
            x = np.clip(np.minimum(tau, 1.0 - tau) / ramp, 0.0, 1.0)
            speed = np.where(x < 0.5, 2.0 * x**2, 1.0 - 2.0 * (1.0 - x) ** 2) if smooth else x
            share = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]))])
            shares.append(share / share[-1])
    worst = half_difference(np.array(shares).T)
    assert SPREAD - 2e-3 < worst <= SPREAD


def test_a_leg_is_free_only_if_all_motions_within_the_spread_are() -> None:
    """A ball where the straight motion does not come, but one whose first joint is late."""
    e = np.array([-SPREAD, SPREAD, SPREAD, 0, 0, 0])
    a, b = A, A + np.array([0.5, 0.3, 0.05, 0, 0, 0])
    tip = psm().arm.fk(a + (0.5 + e) * (b - a))[:3, 3]
    checker = Checker(psm(), World((obstacle("ball", surfaces.Sphere(0.001), at(*tip)),)))
    assert checker.free_line(a, b, 1e-3)
    found = blocked(checker, a, b, 1e-3)
    assert found is not None
    assert found.pair[1] == "ball"
    assert checker.refusal(a + (0.5 + e) * (b - a), 1e-3) is not None


def test_random_motions_between_way_points_keep_the_clearance() -> None:
    """Judged by distances at single configurations, without the proof."""
    solved = problem()
    plan = solved.plan(A, B, seed=3, timeout=60.0)
    checker = Checker(solved.robot, solved.world)
    clearance = 0.9 * plan.clearance_asked
    rows = waypoints(checker, plan, clearance)
    np.testing.assert_array_equal(rows[[0, -1]], [plan.curves[0].controls[0], plan.curves[-1].controls[-1]])
    rng = np.random.default_rng(1)
    for a, b in pairwise(rows):
        assert checker.blocked(line(a, b), clearance) is None
        for _ in range(15):
            share = np.clip(rng.uniform() + SPREAD * rng.choice([-1.0, 1.0], 6), 0.0, 1.0)
            assert checker.refusal(a + share * (b - a), clearance - 1e-6) is None


def test_a_plan_that_is_too_near_for_an_interpolation_is_refused() -> None:
    solved = problem()
    plan = solved.plan(A, B, seed=3, timeout=60.0)
    checker = Checker(solved.robot, posts())
    with pytest.raises(PlanningError, match=r"cannot be sent as way points: between two of them .* post"):
        waypoints(checker, plan, plan.clearance_m)
