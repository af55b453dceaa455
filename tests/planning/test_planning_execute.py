"""Execution of a plan: pace, pause, stop, abort, and the simulated dVRK as the arm."""

from dataclasses import replace

import numpy as np
import pytest
from planning_worlds import at, posts, problem, reaching

from palpate.base.errors import PlanningError
from palpate.planning.execute import STOP_TIME, Execution, Phase
from palpate.planning.verify import worst_rate
from palpate.planning.world import obstacle
from palpate.world import surfaces

A, B = reaching(-0.055, 0.0, -0.12), reaching(0.055, 0.0, -0.12)
DT = 1e-3


@pytest.fixture(scope="module")
def plan():  # type: ignore[no-untyped-def]
    return problem().plan(A, B, seed=3, timeout=60.0)


def _run(execution: Execution, most: float = 60.0, at_step=lambda k: None) -> np.ndarray:  # type: ignore[no-untyped-def]
    goals = []
    while not execution.over and len(goals) < most / DT:
        at_step(len(goals))
        goals.append(execution.step(DT))
    return np.array(goals)


def _within_limits(goals: np.ndarray, plan) -> bool:  # type: ignore[no-untyped-def]
    return bool((np.abs(np.diff(goals, axis=0)) / DT <= plan.limits.v * (1 + 1e-6)).all())


@pytest.mark.parametrize("speed", [1.0, 0.3])
def test_the_goals_follow_the_plan_at_any_speed(plan, speed: float) -> None:  # type: ignore[no-untyped-def]
    execution = Execution(problem(), plan, A, speed)
    goals = _run(execution)
    assert execution.phase is Phase.DONE
    np.testing.assert_allclose(goals[-1], B, atol=1e-9)
    assert _within_limits(goals, plan)
    assert len(goals) * DT == pytest.approx(plan.duration_s / speed, abs=0.1)


def test_a_stop_rests_within_fifty_milliseconds(plan) -> None:  # type: ignore[no-untyped-def]
    execution = Execution(problem(), plan)

    def stop(k: int) -> None:
        if k == 700:
            execution.stop()

    goals = _run(execution, at_step=stop)
    assert execution.phase is Phase.STOPPED
    assert len(goals) - 700 <= round(STOP_TIME / DT) + 1
    rest = execution.step(DT)
    np.testing.assert_array_equal(rest, execution.step(DT))
    assert _within_limits(np.vstack([goals, rest]), plan)


def test_a_pause_goes_on_where_it_rested(plan) -> None:  # type: ignore[no-untyped-def]
    execution = Execution(problem(), plan)
    _run(execution, 0.5)
    execution.pause()
    _run(execution, 0.2)
    rested = execution.step(DT)
    np.testing.assert_array_equal(rested, execution.step(DT))
    execution.resume()
    np.testing.assert_allclose(_run(execution)[-1], B, atol=1e-9)


def test_an_obstacle_that_comes_ahead_aborts_before_it_is_reached(plan) -> None:  # type: ignore[no-untyped-def]
    world = [problem().world]
    execution = Execution(problem(), plan, world=lambda: world[0])
    tip = problem().robot.arm.fk(plan.joints[-20])[:3, 3]

    def come(k: int) -> None:
        if k == 400:
            world[0] = posts().with_added([obstacle("late", surfaces.Sphere(0.003), at(*tip))])

    goals = _run(execution, at_step=come)
    assert execution.phase is Phase.ABORTED
    assert "late" in execution.reason
    assert len(goals) <= 400 + round(STOP_TIME / DT) + 1


def test_a_harmless_change_does_not_stop_the_motion(plan) -> None:  # type: ignore[no-untyped-def]
    world = [problem().world]
    execution = Execution(problem(), plan, world=lambda: world[0])

    def change(k: int) -> None:
        if k == 400:
            world[0] = posts().with_added([obstacle("far", surfaces.Sphere(0.003), at(0.0, 0.0, -0.4))])

    _run(execution, at_step=change)
    assert execution.phase is Phase.DONE


def test_a_stale_plan_does_not_move_an_arm(plan) -> None:  # type: ignore[no-untyped-def]
    tip = problem().robot.arm.fk(plan.joints[len(plan.joints) // 2])[:3, 3]
    changed = problem(posts().with_added([obstacle("late", surfaces.Sphere(0.003), at(*tip))]))
    with pytest.raises(PlanningError, match="scene has changed"):
        Execution(changed, plan)


@pytest.mark.parametrize("speed", [0.0, 1.5, float("nan")])
def test_a_speed_outside_its_range_is_refused(plan, speed: float) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(PlanningError, match="speed must lie in 0 to 1"):
        Execution(problem(), plan, speed=speed)


def test_an_arm_that_is_elsewhere_does_not_jump_to_the_start(plan) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(PlanningError, match="from the start of the plan"):
        Execution(problem(), plan, q_now=B)


def test_the_simulated_dvrk_follows_by_servo_jp(plan) -> None:  # type: ignore[no-untyped-def]
    """CRTK's servo_jp on the simulated PSM; a tick of the simulation is a third of a millisecond."""
    dvrk = pytest.importorskip("palpate.simulators.dvrk", reason="the simulated dVRK is not compiled")
    robot = dvrk.system(("PSM1",))
    robot.send("PSM1", "state_command", "home")
    robot.step(3 * 12_000)
    robot.send("PSM1", "move_jp", A.tolist())
    robot.step(3 * 4_000)
    execution = Execution(problem(), plan, _measured(robot))
    errors = []
    while not execution.over:
        goal = execution.step(DT)
        robot.send("PSM1", "servo_jp", goal.tolist())
        robot.step(3)
        errors.append(np.abs(_measured(robot) - goal).max())
    assert max(errors) < 0.02  # its servo lags by about 10 ms
    np.testing.assert_allclose(_measured(robot), B, atol=1e-3)


def _measured(robot) -> np.ndarray:  # type: ignore[no-untyped-def]
    state = robot.state("PSM1")["measured_js"]
    return np.asarray(state["position"] if isinstance(state, dict) else state[0], dtype=float)


class _Changed:
    """A trajectory whose times are wrong: played `pace` times as fast, with a jump of `kick` [rad, m] after 0.5 s."""

    def __init__(self, plan, pace: float, kick: float) -> None:  # type: ignore[no-untyped-def]
        self._right, self._pace, self._kick = plan.trajectory, pace, kick
        self.limits, self.duration = self._right.limits, self._right.duration / pace

    def at(self, t: np.ndarray) -> tuple[np.ndarray, ...]:
        q, *rest = self._right.at(np.minimum(self._pace * t, self._right.duration))
        return q + self._kick * (t[:, None] > 0.5), *rest


@pytest.mark.parametrize(("pace", "kick", "least"), [(1.1, 0.0, 1.08), (1.0, 1e-6, 1.2), (1.0, 1e-3, 100.0)])
def test_the_check_of_rates_finds_wrong_times(plan, pace: float, kick: float, least: float) -> None:  # type: ignore[no-untyped-def]
    assert worst_rate(plan) <= 1.0
    wrong = replace(plan)
    wrong.__dict__["trajectory"] = _Changed(plan, pace, kick)
    assert worst_rate(wrong) > least
