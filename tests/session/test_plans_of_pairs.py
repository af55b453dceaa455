"""Plans among several pairs: one pair executes, the others go on, and their instruments are in its way."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("coal")
pytest.importorskip("ompl")

from palpate.base.errors import PlanningError, SceneError
from palpate.cli import main
from palpate.planning import Problem
from palpate.scene import Scene
from palpate.session import PairsSession

SCENE = Path(__file__).parents[2] / "scenes" / "two_hands.yaml"


@cache
def planned(goal="home"):
    """A motion of the right instrument, and the goal of its tip in W (3,)."""
    problem = Problem.of(Scene.load(SCENE), "right")
    plan = problem.plan("current", goal)
    assert plan.success
    q = plan.trajectory.at(np.array([plan.duration_s]))[0][0]
    return plan, (problem.robot.X_WB @ problem.robot.arm.fk(q))[:3, 3]


def test_one_pair_executes_and_the_other_goes_on():
    plan, goal = planned()
    alone = PairsSession(Scene.load(SCENE))
    alone.step(1500)
    session = PairsSession(Scene.load(SCENE))
    execution, away = session.execute(plan), []
    for _ in range(150):
        session.step(10)
        away.append(np.linalg.norm(session.pairs["right"].latest()["p_WT"] - goal))
    assert execution.phase == "done", execution.reason
    assert min(away) < 1e-3
    assert away[-1] > 0.02, "then the hand takes over"
    ours, theirs = session.pairs["left"].latest(), alone.pairs["left"].latest()
    assert np.array_equal(ours["p_WT"], theirs["p_WT"]), "the left hand does what it does without the plan"
    session.close()
    alone.close()


def test_the_other_instrument_is_an_obstacle_where_it_stands():
    """The tip of the left instrument as a goal of the right one: each part that would meet it has its name."""
    scene = Scene.load(SCENE)
    session = PairsSession(scene)
    left, right = session.rigs["left"].arms, session.rigs["right"].arms
    X_WT = left.X_WB @ left.follower.fk(left.q_follower0)
    inside = right.X_WB @ right.follower.fk(right.q_follower0)
    inside[:3, 3] = X_WT[:3, 3]
    q = right.follower.ik(np.linalg.inv(right.X_WB) @ inside, right.q_follower0)
    with pytest.raises(PlanningError, match="left/"):
        Problem.of(scene, "right").plan("current", q)
    session.close()


def test_an_instrument_that_comes_into_the_way_ends_the_motion():
    """The left hand is led across the path of a slow plan; the judge is the distance of the two tips."""
    plan, _ = planned()
    data = Scene.load(SCENE).model_dump(mode="json", exclude_unset=True)
    path = [plan.trajectory.at(np.array([t]))[0][0] for t in np.linspace(0.3, 1.0, 3) * plan.duration_s]
    rig = PairsSession(Scene.load(SCENE)).rigs["right"].arms
    way = [(rig.X_WB @ rig.follower.fk(q))[:3, 3] for q in path]
    start = [-0.05, 0.0, 0.05]
    data["pairs"]["left"]["operator"] = {"path": [{"t": 0, "xyz": start}, {"t": 3.0, "xyz": way[1].tolist()}]}
    data.pop("ecm")
    session = PairsSession(Scene.model_validate(data))
    execution = session.execute(plan, speed=0.1)
    nearest = np.inf
    for _ in range(400):
        session.step(10)
        tips = [np.asarray(session.pairs[name].latest()["p_WT"]) for name in ("right", "left")]
        if execution.over:
            break
        nearest = min(nearest, float(np.linalg.norm(tips[0] - tips[1])))
    assert execution.phase == "aborted"
    assert "left/" in execution.reason
    assert nearest > 0.002, "the motion ends before they meet"
    session.close()


def test_in_real_time_and_by_the_command(tmp_path, capsys):
    plan, _ = planned()
    file = tmp_path / "plan.yaml"
    plan.save(file, Problem.of(Scene.load(SCENE), "right").robot.arm)
    assert main(["run", str(SCENE), "--headless", "--duration", "2", "--plan", str(file), "--realtime", "--out",
                 str(tmp_path / "runs"), "--json", str(tmp_path / "out.json")]) == 0  # fmt: skip
    told = capsys.readouterr().out
    assert "right: plan: done at" in told
    assert set(json.loads((tmp_path / "out.json").read_text())["pairs"]) == {"right", "left"}


def test_plans_of_no_pair_are_refused():
    plan, _ = planned()
    with pytest.raises(SceneError, match=r"several pairs.*\n.*palpate plan --arm NAME"):
        Problem.of(Scene.load(SCENE))
    with pytest.raises(SceneError, match="there is no pair 'middle'"):
        Problem.of(Scene.load(SCENE), "middle")
    session = PairsSession(Scene.load(SCENE))
    with pytest.raises(PlanningError, match="the plan moves right, not left"):
        session.pairs["left"].execute(plan)
    session.remove("right")
    with pytest.raises(PlanningError, match="the plan moves right, and the pairs are left"):
        session.execute(plan)
    session.close()
