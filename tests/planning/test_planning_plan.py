"""Plans: found, kept clear, in time, the same for the same seed, and clear messages where there is none."""

from pathlib import Path

import numpy as np
import pytest
from planning_worlds import at, posts, problem, reaching

from palpate.base.errors import PlanningError
from palpate.planning import load, planners
from palpate.planning.verify import verify
from palpate.planning.world import World, obstacle
from palpate.world import surfaces

A, B = reaching(-0.055, 0.0, -0.12), reaching(0.055, 0.0, -0.12)


@pytest.fixture(scope="module")
def found():  # type: ignore[no-untyped-def]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(planners, "retracting", lambda *_: None)  # leaves the search to OMPL
        return problem().plan(A, B, seed=3, timeout=60.0)


def test_a_retracted_instrument_pivots_freely() -> None:
    plan = problem().plan(A, B, seed=3, timeout=60.0)
    assert plan.success
    assert plan.planner == planners.RETRACT
    np.testing.assert_allclose(plan.joints[[0, -1]], [A, B], atol=1e-9)


def test_a_plan_goes_around_and_an_independent_check_finds_nothing(found) -> None:  # type: ignore[no-untyped-def]
    assert found.success
    assert found.planner == "RRTConnect"
    np.testing.assert_allclose(found.joints[[0, -1]], [A, B], atol=1e-9)
    verdict = verify(problem(), found)
    assert verdict.largest_step <= 2.5e-4
    assert verdict.violations == 0
    assert verdict.worst_rate <= 1.0 + 1e-3
    assert found.clearance_m is not None
    assert 0.003 <= found.clearance_m <= verdict.smallest + 2e-4  # capsules contain the exact parts
    assert found.nearest[1] in ("vessel", "post", "ball")


def test_the_independent_check_finds_a_violation(found) -> None:  # type: ignore[no-untyped-def]
    on_the_way = found.joints[len(found.joints) // 2]
    tip = problem().robot.arm.fk(on_the_way)[:3, 3]
    with_more = posts().with_added([obstacle("late", surfaces.Sphere(0.002), at(*tip))])
    assert verify(problem(with_more), found).violations > 0


def test_the_independent_check_finds_a_time_that_is_too_short(found) -> None:  # type: ignore[no-untyped-def]
    from dataclasses import replace

    from palpate.planning.timing import Limits

    limits = found.limits
    faster = replace(found, limits=Limits(2 * limits.v, 2 * limits.a, 2 * limits.j))
    ratio = verify(problem(), replace(faster, curves=faster.curves[:1])).worst_rate
    assert ratio <= 1.0 + 1e-3  # against its own limits
    t = np.arange(0.0, faster.trajectory.duration, 1e-3)
    assert np.abs(np.diff(faster.trajectory.at(t)[0], axis=0) / 1e-3 / limits.v).max() > 1.0


def test_the_same_seed_gives_the_same_plan(found, monkeypatch: pytest.MonkeyPatch) -> None:  # type: ignore[no-untyped-def]
    monkeypatch.setattr(planners, "retracting", lambda *_: None)
    again = problem().plan(A, B, seed=3, timeout=60.0)
    np.testing.assert_array_equal(again.joints, found.joints)
    other = problem().plan(A, B, seed=4, timeout=60.0)
    assert other.joints.shape != found.joints.shape or np.abs(other.joints - found.joints).max() > 1e-6


def test_a_plan_file_gives_the_same_motion(found, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    found.save(tmp_path / "plan.yaml", problem().robot.arm)
    read = load(tmp_path / "plan.yaml")
    np.testing.assert_allclose(read.joints, found.joints, atol=1e-12)
    assert read.world_version == problem().world.version
    (tmp_path / "plan.yaml").write_text("kind: something")
    with pytest.raises(PlanningError, match="not a plan"):
        load(tmp_path / "plan.yaml")


def test_a_pose_is_reached_by_one_of_several_solutions() -> None:
    arm = problem().robot.arm
    plan = problem().plan(A, arm.fk(B), seed=1, timeout=60.0)
    assert plan.success
    np.testing.assert_allclose(arm.fk(plan.joints[-1]), arm.fk(B), atol=1e-6)


def test_a_sequence_stops_at_each_place() -> None:
    made = problem()
    back = made.retreat(A, 0.05)
    plan = made.through([A, back, B], seed=1, timeout=60.0)
    assert plan.success
    t = np.arange(0.0, plan.duration_s, 1e-3)
    q, v, _ = plan.trajectory.at(t)
    passed = int(np.argmin(np.abs(q - back).max(axis=1)))
    assert np.abs(v[passed]).max() < 0.01
    np.testing.assert_allclose(plan.joints[[0, -1]], [A, B], atol=1e-9)
    with pytest.raises(PlanningError, match="two places"):
        made.through([A])


def test_an_unreachable_pose_names_the_limit() -> None:
    X = problem().robot.arm.fk(B)
    X[2, 3] -= 0.4
    plan = problem().plan(A, X)
    assert not plan.success
    assert "unreachable: insertion is at its upper limit 0.24" in plan.reason


def test_without_a_path_the_blocking_pair_is_named() -> None:
    wall = World((obstacle("wall", surfaces.Box([0.004, 0.6, 1.0]), at(0.0, 0.0, -0.54)),))  # the cannula does not pass
    plan = problem(wall).plan(A, B, 0.001, timeout=0.5)
    assert not plan.success
    assert plan.reason.startswith("no path found within 0.5 s")
    assert plan.nearest[1] == "wall"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"start": reaching(0.03, 0.0, -0.12)}, "start is in collision: .* deep in vessel"),
        ({"goal": reaching(0.0, 0.03, -0.13)}, "goal is in collision: .* deep in ball"),
        ({"clearance": 0.05}, "start is nearer than the clearance"),
        ({"clearance": -1.0}, "clearance must be a number"),
        ({"clearance": float("nan")}, "clearance must be a number"),
        ({"timeout": 0.0}, "timeout must be a number"),
        ({"goal": "nowhere"}, "goal 'nowhere' is not understood"),
        ({"goal": [0.0, 1.0]}, "must be 6 joint positions"),
        ({"goal": [9.0, 0, 0.1, 0, 0, 0]}, "puts yaw at 9"),
        ({"goal": np.diag([2.0, 1, 1, 1])}, "not a rotation matrix"),
        ({"goal": Path("missing.yaml")}, "file of the goal cannot be read"),
        ({"planner": "Magic"}, "no planner 'Magic'"),
    ],
)
def test_what_cannot_be_planned_is_explained(change: dict, message: str) -> None:
    with pytest.raises(PlanningError, match=message):
        problem().plan(**({"start": A, "goal": B} | change))


def test_a_start_in_collision_comes_with_a_free_state() -> None:
    with pytest.raises(PlanningError) as error:
        problem().plan(reaching(0.03, 0.0, -0.12), B)
    text = error.value.mend.split("joints:")[1].split(",")[:6]
    q = np.array([float(x.split()[0]) for x in text])
    assert problem().plan(q, q).success
