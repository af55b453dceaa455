"""Starts and goals recorded by a pedal, and plans through them."""

import numpy as np
import pytest
import yaml

pytest.importorskip("ompl", reason="motion planning needs the extra planning")
pytest.importorskip("coal", reason="motion planning needs the extra planning")
pytest.importorskip("ruckig", reason="motion planning needs the extra planning")

import palpate
from palpate.base.errors import OutputError, PlanningError
from palpate.planning import Problem, goals
from palpate.session.places import PlaceRecorder

SCENE = """
objects: [{name: block, box: {size: [0.01, 0.05, 0.05]}, pose: {xyz: [0, 0, -0.05]}}]
arms:
  leader: {base: {xyz: [0.345, 0.243, 0.219], rpy_deg: [0, 0, -20]}}
  follower: {base: {xyz: [0, 0, 0.12]}}
operator: {path: [{t: 0, xyz: [-0.04, 0, 0.005]}, {t: 0.8, xyz: [0.04, 0.01, 0.01]}]}
"""


def test_a_pedal_records_places_that_a_plan_goes_through(tmp_path):
    scene, file = palpate.Scene.parse(SCENE), tmp_path / "places.yaml"
    session = palpate.Session(scene)
    recorder = PlaceRecorder(session, file)
    with pytest.raises(PlanningError, match="no recorded place"):
        goals.read_places(file)
    seen = []
    for ticks in (100, 400, 600):
        session.step(ticks)
        session.console.press("coag")
        session.console.press("clutch")  # another pedal records nothing
        session.console.release("clutch")
        session.console.release("coag")
        seen.append(session.latest()["q_follower"][:6].copy())
    np.testing.assert_allclose(recorder.places, seen, atol=1e-8)
    assert len(yaml.safe_load(file.read_text())["places"]) == 3
    problem = Problem.of(scene, rig=session.rig)
    places = goals.read_places(file)
    plan = problem.through(problem.with_trocar_motions(places, retreat=0.02, approach=0.01))
    assert plan.success
    for q in seen:
        assert np.abs(plan.joints - q).max(axis=1).min() < 0.02
    np.testing.assert_allclose(plan.joints[[0, -1]], [seen[0], seen[2]], atol=1e-7)
    for first, last, depth in ((0, 1, 0.02), (-2, -1, -0.01)):
        rows = [curve.controls for curve in plan.curves]
        q = [rows[0][0], rows[0][-1]] if first == 0 else [rows[last][0], rows[last][-1]]
        np.testing.assert_allclose(np.delete(q[0] - q[1], 2), 0.0, atol=1e-9)  # along the trocar alone
        assert np.sign(q[0][2] - q[1][2]) == np.sign(depth)
    start, goal = (goals.read(file, problem.robot.arm, problem.states, what) for what in ("start", "goal"))
    np.testing.assert_allclose([start, goal], [seen[0], seen[2]], atol=1e-8)


def test_a_file_that_cannot_be_written_is_refused_at_once(tmp_path):
    with pytest.raises(OutputError, match="places cannot be written"):
        PlaceRecorder(palpate.Session(palpate.Scene.parse(SCENE)), tmp_path / "none" / "places.yaml")


def test_the_pedal_of_several_pairs_records_the_joints_of_each(tmp_path):
    from palpate.session import PairsSession

    session = PairsSession(palpate.Scene.load("two_hands"))
    each = {name: PlaceRecorder(one, tmp_path / name, console=session.console) for name, one in session.pairs.items()}
    session.step(100)
    session.console.press("coag")
    for name, recorder in each.items():
        q = session.pairs[name].latest()["q_follower"][: len(recorder.places[0])]
        np.testing.assert_allclose(recorder.places, [q], atol=1e-8)
    session.close()
