"""Plans with open jaws: the proof against the jaws as the model places them at each angle."""

import numpy as np
import pytest
from planning_worlds import at, problem, psm, reaching

from palpate.cli.commands.plan import _lines
from palpate.planning import geometry, load
from palpate.planning.ahead import Ahead
from palpate.planning.checker import Checker
from palpate.planning.problem import Problem
from palpate.planning.verify import verify
from palpate.planning.world import World, obstacle
from palpate.scene import Scene
from palpate.world import surfaces

Q = reaching(0.0, 0.0, -0.12)


def exact(robot, q, jaw, body) -> float:
    """Distance of the drawn parts of the arm, with its jaws at one angle, from an obstacle, by Coal."""
    import coal

    links, least = robot.arm.link_poses(q, jaw), np.inf
    for part in robot.arm.visuals:
        X = robot.X_WB @ links[part.link] @ part.X_link_visual
        shape = {"box": coal.Box, "cylinder": coal.Cylinder, "sphere": coal.Sphere}[part.shape](*part.size)
        value = coal.distance(shape, geometry.transform(X[:3, :3], X[:3, 3]), body.solid.coal, body.transform,
                              coal.DistanceRequest(), coal.DistanceResult())  # fmt: skip
        least = min(least, value)
    return least


@pytest.mark.parametrize("span", [(0.0, 1.0), (0.3, 0.4), (0.6, 0.6)])
def test_the_range_of_the_jaws_contains_every_angle(span) -> None:
    robot = psm().with_jaws(*span)
    rng = np.random.default_rng(0)
    tight = np.inf
    for _ in range(40):
        q = Q.copy()
        q[3:] += rng.uniform(-0.7, 0.7, 3)
        p = (robot.X_WB @ robot.arm.fk(q))[:3, 3] + 0.02 * rng.normal(size=3)
        body = obstacle("ball", surfaces.Sphere(0.002), at(*p))
        told = Checker(robot, World((body,))).nearest(q)[0].distance
        true = min(exact(robot, q, jaw, body) for jaw in np.linspace(*span, 21))
        if true > 1e-3:
            assert told <= true + 1e-6
            tight = min(tight, true - told)
    assert tight < 3e-4


def beside_the_open_jaw(gap: float) -> World:
    """A ball `gap` [m] beside the path of the end of a jaw that is open by 1 rad; closed jaws are farther away."""
    robot = psm()
    closed, opened = (ends(robot.with_jaws(jaw, jaw)) for jaw in (0.0, 1.0))
    outward = opened - closed
    outward /= np.linalg.norm(outward)
    return World((obstacle("ball", surfaces.Sphere(0.002), at(*(opened + (0.0045 + gap) * outward))),))


def ends(robot) -> np.ndarray:
    """Lower end of the capsule of a jaw at Q."""
    (k,) = [k for k, body in enumerate(robot.bodies) if body.name == "jaw_1"]
    return min(robot.placed(Q[None]).ends_W[0, k], key=lambda p: p[2])


def near(robot, world, clearance: float) -> Problem:
    made = problem(world)
    return Problem(robot, world, made.states, made.limits, clearance)


TURN = np.array([0.0, 0.0, -0.01, 0.0, 0.0, 0.0])  # a short retreat and back, beside the ball


def test_open_jaws_come_nearer_and_the_plan_says_so() -> None:
    world, told = beside_the_open_jaw(0.001), []
    for span in ((0.0, 0.0), (0.0, 1.0)):
        here = near(psm().with_jaws(*span), world, 0.0005)
        plan = here.plan(Q + TURN, Q, timeout=30.0)
        assert plan.success
        assert plan.jaw == span
        verdict = verify(here, plan)
        assert (verdict.violations, verdict.own_contacts) == (0, 0)
        samples = np.concatenate([curve.at(np.linspace(0, 1, 40)) for curve in plan.curves])
        true = min(exact(here.robot, q, jaw, world.obstacles[0]) for q in samples for jaw in np.linspace(*span, 5))
        assert plan.clearance_m is not None
        assert true - 4e-4 <= plan.clearance_m <= true + 1e-6 or span == (0.0, 0.0)
        told.append(plan.clearance_m)
    assert told[1] < told[0] - 1e-3


def test_a_plan_for_closed_jaws_is_proved_again_for_open_ones() -> None:
    world = beside_the_open_jaw(-0.001)
    plan = near(psm(), world, 0.001).plan(Q + TURN, Q, timeout=30.0)
    assert plan.success
    assert Ahead(psm(), plan).prove(world, 0.0, plan.duration_s) == ""
    assert Ahead(psm().with_jaws(0.0, 5e-4), plan).prove(world, 0.0, plan.duration_s) == ""
    for span in ((1.0, 1.0), (0.0, 1.0)):
        assert "jaw" in Ahead(psm().with_jaws(*span), plan).prove(world, 0.0, plan.duration_s)


SCENE = """
objects: [{name: ball, sphere: {radius: 0.002}, pose: {xyz: [0, %s, -0.126]}}]
arms: {follower: {base: {xyz: [0, 0, 0]}, start: {xyz: [0, 0, -0.12], rpy_deg: [180, 0, 90]}%s}}
planning: {clearance: 1 mm%s}
operator: {path: [{t: 0, xyz: [0, 0, -0.12]}, {t: 1, xyz: [0, 0, -0.12]}]}
"""


@pytest.mark.parametrize(("jaws", "planning", "span"), [
    ("", "", (0.0, 0.0)),
    (", jaw: {start: 0.7}", "", (0.7, 0.7)),
    (", jaw: {start: 0.7}", ", jaw: 0.2", (0.2, 0.2)),
    ("", ", jaw: [0, 0.9]", (0.0, 0.9)),
])  # fmt: skip
def test_the_jaws_of_the_scene_are_those_of_the_plan(jaws, planning, span, tmp_path) -> None:
    (tmp_path / "scene.yaml").write_text(SCENE % (0.05, jaws, planning))
    made = Problem.of(Scene.load(tmp_path / "scene.yaml"))
    assert made.robot.span == span
    plan = made.plan("current", made.states["current"] + 0.02)
    plan.save(tmp_path / "plan.yaml", made.robot.arm)
    assert load(tmp_path / "plan.yaml").jaw == plan.jaw == span


def test_a_falling_range_of_the_jaws_is_refused(tmp_path) -> None:
    (tmp_path / "scene.yaml").write_text(SCENE % (0.05, "", ", jaw: [0.9, 0.2]"))
    with pytest.raises(Exception, match=r"jaw: \[0.9, 0.2\] falls"):
        Scene.load(tmp_path / "scene.yaml")


@pytest.mark.parametrize(("jaws", "words"), [("", "capsules"), (", jaw: 0.2", "capsules, jaws at 0.2 rad"),
                                             (", jaw: [0, 0.9]", "meshes, jaws from 0 to 0.9 rad")])  # fmt: skip
def test_the_command_says_for_which_jaws_it_plans(jaws, words, tmp_path) -> None:
    (tmp_path / "scene.yaml").write_text(SCENE % (0.05, "", jaws))
    made = Problem.of(Scene.load(tmp_path / "scene.yaml"))
    assert _lines(made.plan("current", made.states["current"] + 0.02))[0].endswith(words)
