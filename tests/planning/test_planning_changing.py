"""A world that changes while a motion is searched for. The search itself changes it: no clocks, no threads."""

import numpy as np
import pytest
from planning_worlds import at, posts, problem, reaching

from palpate.base.errors import PlanningError
from palpate.planning import Execution, changing
from palpate.planning.checker import Checker
from palpate.planning.problem import Problem
from palpate.planning.result import Plan
from palpate.planning.world import World, obstacle
from palpate.world import surfaces

A, B = reaching(-0.055, 0.0, -0.12), reaching(0.055, 0.0, -0.12)


class Changing:
    """Returns the worlds in turn, one after each search; counts the searches."""

    def __init__(self, *worlds: World) -> None:
        self.worlds, self.searches = worlds, 0

    def now(self) -> World:
        return self.worlds[min(self.searches, len(self.worlds) - 1)]

    def search(self, solved: Problem, left: float) -> Plan:
        found = solved.plan(A, B, seed=3, timeout=60.0)
        self.searches += 1
        return found

    def plan(self, timeout: float = 600.0) -> Plan:
        return changing.plan(problem(), self.now, self.search, timeout)


def with_ball(p: np.ndarray) -> World:
    return posts().with_added([obstacle("late", surfaces.Sphere(0.004), at(*p))])


@pytest.fixture(scope="module")
def halfway() -> np.ndarray:
    """Place of the tip in the middle of the plan in the world without a change."""
    plan = problem().plan(A, B, seed=3, timeout=60.0)
    return np.asarray(problem().robot.arm.fk(plan.trajectory.at(np.array([0.5 * plan.duration_s]))[0][0])[:3, 3])


def is_free(found: Plan, world: World) -> bool:
    checker = Checker(problem().robot, world)
    return all(checker.refusal(q, found.clearance_asked - 1e-6) is None for q in found.joints)


def test_without_a_change_the_plan_is_that_of_one_search() -> None:
    live = Changing(posts())
    found = live.plan()
    np.testing.assert_array_equal(found.joints, problem().plan(A, B, seed=3, timeout=60.0).joints)
    assert (live.searches, found.notes) == (1, ())


def test_a_change_that_leaves_the_path_free_is_noted() -> None:
    live = Changing(posts(), with_ball(np.array([0.0, 0.0, -0.4])))
    found = live.plan()
    assert found.success
    assert live.searches == 1
    assert found.notes == (changing.PROVED_AGAIN,)
    assert found.world_version == live.now().version
    Execution(problem(live.now()), found)


def test_a_change_that_blocks_the_path_begins_the_search_again(halfway: np.ndarray) -> None:
    live = Changing(posts(), with_ball(halfway))
    found = live.plan()
    assert found.success
    assert live.searches == 2
    assert found.notes == (changing.SEARCHED_AGAIN,)
    assert found.world_version == live.now().version
    assert is_free(found, live.now())
    assert not is_free(problem().plan(A, B, seed=3, timeout=60.0), live.now())


def test_without_time_left_the_result_names_what_comes_too_near(halfway: np.ndarray) -> None:
    live = Changing(posts(), with_ball(halfway))
    found = live.plan(timeout=0.0)
    assert not found.success
    assert live.searches == 1
    assert "the scene changed during the search, and " in found.reason
    assert "late" in found.reason


def test_a_start_that_is_no_longer_free_is_an_error() -> None:
    tip = problem().robot.arm.fk(A)[:3, 3]
    with pytest.raises(PlanningError, match="the start is in collision"):
        Changing(posts(), with_ball(tip)).plan()


def test_the_package_s_plan_takes_a_world() -> None:
    import palpate.planning

    worlds = [World()]
    found = palpate.planning.plan("planning", goal="home", timeout=60.0, world=lambda: worlds[0])
    assert found.success
    assert found.world_version == World().version
