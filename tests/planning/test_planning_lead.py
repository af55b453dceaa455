"""Leading a hand along a plan: a hand that leaves the tube gets a new path without a step of the force."""

import numpy as np
import pytest
from planning_worlds import problem, reaching

from palpate import Scene, Session
from palpate.planning.checker import Checker
from palpate.planning.lead import Lead
from palpate.planning.problem import Problem
from palpate.record.ticks import as_ticks
from palpate.scene.guidance.one_line import LEAD, WALL

SCENE = """
objects:
  - {name: post, box: {size: [0.01, 0.01, 0.03]}, pose: {xyz: [0.0, 0.03, 0.0]}}
arms: {follower: {base: {xyz: [-0.05, 0.0, 0.16]}}}
planning: {clearance: 3 mm}
operator:
  path:
    - {t: 0, xyz: [-0.04, 0.0, 0.03]}
    - {t: 0.5, xyz: [-0.02, 0.0, 0.03]}
    - {t: 1.0, xyz: [-0.01, 0.03, 0.035]}
    - {t: 3.0, xyz: [-0.01, 0.03, 0.035]}
"""


def test_a_hand_outside_the_tube_gets_a_new_path_without_a_step_of_the_force() -> None:
    session = Session(Scene.parse(SCENE))
    whole = Problem.of(session.scene, rig=session.rig)
    X_WT = session.rig.arms.X_WB @ session.rig.arms.follower.fk(session.rig.arms.q_follower0)
    X_WT[0, 3] = 0.04
    plan = whole.plan(session.rig.arms.q_follower0, X_WT, timeout=60.0)
    lead = Lead(session, whole, plan)
    before, rows, replaced = lead.path, [], []
    for k in range(100):
        rows.append(session.simulation.run(20))
        if lead.step():
            replaced.append(20 * (k + 1))
    assert replaced
    assert lead.searches >= len(replaced)
    np.testing.assert_allclose(lead.path[-1], before[-1], atol=1e-4)  # the same goal
    ticks = as_ticks(np.concatenate(rows))
    F = ticks["F_guidance_W"]
    moved = np.linalg.norm(np.diff(ticks["p_WT_goal"], axis=0), axis=1)
    steps = np.linalg.norm(np.diff(F, axis=0), axis=1)
    allowed = (LEAD + WALL) * moved + 20e-3 + 0.05  # motion, the rate of an edit, and the damping of the springs
    for k in replaced:
        assert steps[k - 1] <= allowed[k - 1]
    assert np.linalg.norm(F, axis=1).max() > 0.5  # there was a force to step from


def test_a_new_path_starts_at_the_tool_and_keeps_the_clearance() -> None:
    whole = problem()
    plan = whole.plan(reaching(-0.055, 0.0, -0.12), reaching(0.055, 0.0, -0.12), timeout=60.0)

    class Nobody:
        fixtures = ()

    lead = Lead(Nobody(), whole, plan)
    q = reaching(-0.05, -0.04, -0.11)
    path, clearance = lead.replanned(q, 60.0)
    assert clearance == pytest.approx(0.003)
    np.testing.assert_allclose(path[0], whole.robot.arm.fk(q)[:3, 3], atol=1e-12)
    np.testing.assert_allclose(path[-1], lead.path[-1], atol=1e-12)
    checker = Checker(whole.robot, whole.world)
    distances = [near.distance for q in _inverse(path) for near in checker.nearest(q, 0.01)]
    assert distances
    assert min(distances) > 0.0029


def _inverse(path: np.ndarray) -> list[np.ndarray]:
    return [reaching(*p) for p in path]
