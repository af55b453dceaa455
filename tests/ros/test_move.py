"""`palpate ros move` on the simulated PSM: it arrives, stops, refuses and aborts."""

import json
import signal
import time

import numpy as np
import pytest
from dvrk_client import Dvrk

pytest.importorskip("ompl", reason="motion planning needs the extra planning")
pytest.importorskip("coal", reason="motion planning needs the extra planning")
pytest.importorskip("ruckig", reason="motion planning needs the extra planning")

from palpate.cli import main
from palpate.planning import Problem
from palpate.scene import Scene

SCENE = """
objects: [{name: block, box: {size: [0.01, 0.05, 0.05]}, pose: {xyz: [0, 0, %g]}}]
arms:
  leader: {base: {xyz: [0.345, 0.243, 0.219], rpy_deg: [0, 0, -20]}}
  follower: {base: {xyz: [0, 0, 0.12]}}
planning: {arm: PSM1, clearance: 3 mm}
operator: {path: [{t: 0, xyz: [0.05, 0, 0]}]}
"""
START, GOAL = np.array([-0.4, 0.0, 0.13, 0, 0, 0]), np.array([0.4, 0.1, 0.13, 0.2, 0, 0])
BACK = "/PSM1/measured_js"


@pytest.fixture(scope="module")
def planned(tmp_path_factory):
    """The folder of a scene with a block in the way, and of a plan around it."""
    folder = tmp_path_factory.mktemp("planned")
    (folder / "scene.yaml").write_text(SCENE % 0.0)
    (folder / "stale.yaml").write_text(SCENE % 0.04)
    problem = Problem.of(Scene.load(folder / "scene.yaml"))
    plan = problem.plan(START, GOAL, timeout=60.0)
    assert plan.success, plan.reason
    assert plan.planner != "straight line"
    plan.save(folder / "plan.yaml", problem.robot.arm)
    return folder


@pytest.fixture
def robot(sim, node, until):
    """The PSM, homed and at the start of the plan; goals that it is sent are logged with their times."""
    from sensor_msgs.msg import JointState

    robot = Dvrk(node, until)
    robot.subscribe("/PSM1/operating_state", BACK)
    robot.home("PSM1")
    place(robot, until, START)
    robot.goals = []
    node.create_subscription(JointState, "/PSM1/servo_jp", lambda m: robot.goals.append((time.monotonic(), m)), 1000)
    return robot


def q(robot):
    return np.array(robot.last[BACK].position)


def place(robot, until, goal):
    from sensor_msgs.msg import JointState

    robot.publish("/PSM1/move_jp", JointState(position=goal.tolist()))
    state = "/PSM1/operating_state"
    until(lambda: np.abs(q(robot) - goal).max() < 5e-4 and not robot.last[state].is_busy, "the place", 20.0)


def begin(start, planned, *more):
    out = planned / "moved.json"
    out.unlink(missing_ok=True)
    return start("-m", "palpate", "ros", "move", planned / "plan.yaml", "--arm", "PSM1", "--json", out, *more)


def run(planned, *more):
    """Exit code and JSON of the command in this process."""
    out = planned / "moved.json"
    out.unlink(missing_ok=True)
    code = main(["ros", "move", str(planned / "plan.yaml"), "--arm", "PSM1", "--json", str(out), *map(str, more)])
    return code, json.loads(out.read_text()) if out.is_file() else None


def refused(robot, planned, until, *more):
    """True if the command refuses and nothing arrives."""
    code, moved = run(planned, *more)
    end = time.monotonic() + 0.2
    until(lambda: time.monotonic() > end, "time")
    return (code, moved, robot.goals) == (2, None, [])


def ended(process, planned, until):
    """Exit code and JSON of a process, while this one listens."""
    until(lambda: process.poll() is not None, "the end of the motion", 60.0)
    out = planned / "moved.json"
    return process.returncode, json.loads(out.read_text()) if out.is_file() else None


def moving(robot, until, process):
    until(lambda: len(robot.goals) > 50 or process.poll() is not None, "goals", 60.0)
    assert process.poll() is None, process.stderr.read()


def test_the_arm_arrives_at_the_goal(robot, planned, until):
    code, moved = run(planned, "--speed", "1")
    assert (code, moved["success"], moved["phase"]) == (0, True, "done"), moved
    until(lambda: len(robot.goals) == moved["goals"], "every goal")
    until(lambda: np.allclose(q(robot), GOAL, atol=1e-3), "the goal", 5.0)
    np.testing.assert_allclose(robot.goals[-1][1].position, GOAL, atol=1e-9)
    assert moved["path_error_m"] < 3e-3


def test_ctrl_c_stops_within_fifty_milliseconds(robot, planned, start, until):
    """The best of three on a busy machine: from the signal to the arrival of the last goal; then the arm rests."""
    waits = []
    for _ in range(3):
        process = begin(start, planned)
        moving(robot, until, process)
        asked = time.monotonic()
        process.send_signal(signal.SIGINT)
        code, moved = ended(process, planned, until)
        assert code == 130
        assert (moved["success"], moved["phase"]) == (False, "stopped")
        waits.append(robot.goals[-1][0] - asked)
        last = np.array(robot.goals[-1][1].position)
        assert np.abs(last - GOAL).max() > 0.1
        until(lambda last=last: np.abs(q(robot) - last).max() < 1e-3, "rest at the last goal", 5.0)
        if waits[-1] <= 0.05:
            break
        place(robot, until, START)
        robot.goals.clear()
    assert min(waits) <= 0.05, waits


def test_topics_pause_resume_and_stop(robot, planned, start, until, node):
    from std_msgs.msg import Empty

    process = begin(start, planned)
    ends = {name: node.create_publisher(Empty, f"/palpate_move_PSM1/{name}", 1) for name in ("pause", "resume", "stop")}
    moving(robot, until, process)
    until(lambda: all(end.get_subscription_count() for end in ends.values()), "the node's topics")
    ends["pause"].publish(Empty())

    def rests():
        last = [m.position for _, m in robot.goals[-20:]]
        return all(one == last[0] for one in last)

    until(rests, "a pause")
    rested = len(robot.goals)
    ends["resume"].publish(Empty())
    until(lambda: len(robot.goals) > rested + 20 and not rests(), "it goes on")
    ends["stop"].publish(Empty())
    code, moved = ended(process, planned, until)
    assert (code, moved["phase"]) == (1, "stopped")


def test_an_arm_that_is_disabled_on_the_way_aborts(robot, planned, start, until):
    process = begin(start, planned)
    moving(robot, until, process)
    robot.publish("/PSM1/state_command", string="disable")
    code, moved = ended(process, planned, until)
    assert (code, moved["phase"]) == (1, "aborted")
    assert "not ENABLED" in moved["reason"]
    assert moved["along_s"] < moved["duration_s"]
    robot.home("PSM1")


def test_an_arm_that_falls_silent_aborts(sim, robot, planned, start, until):
    process = begin(start, planned)
    moving(robot, until, process)
    sim.send_signal(signal.SIGSTOP)
    try:
        code, moved = ended(process, planned, until)
    finally:
        sim.send_signal(signal.SIGCONT)
    assert (code, moved["phase"]) == (1, "aborted")
    assert "PSM1 is silent" in moved["reason"]


def test_an_arm_that_is_led_away_aborts(robot, planned, start, until):
    """Another program sends goals at the same time."""
    from sensor_msgs.msg import JointState

    process = begin(start, planned)
    moving(robot, until, process)
    elsewhere = START + np.array([0.0, -0.1, 0.0, 0, 0, 0])
    end = time.monotonic() + 20.0

    def over():
        robot.publish("/PSM1/servo_jp", JointState(position=elsewhere.tolist()))
        assert time.monotonic() < end
        return process.poll() is not None

    until(over, "the abort", 20.0)
    code, moved = ended(process, planned, until)
    assert (code, moved["phase"]) == (1, "aborted")
    assert "left the path" in moved["reason"]


def test_a_wrong_start_is_refused_and_nothing_is_sent(robot, planned, until, capsys):
    place(robot, until, START + np.array([0, 0, 0.01, 0, 0, 0]))
    assert refused(robot, planned, until)
    assert "insertion is at 0.14" in capsys.readouterr().err


def test_a_stale_plan_is_refused_and_nothing_is_sent(robot, planned, until, capsys):
    assert refused(robot, planned, until, "--scene", planned / "stale.yaml")
    assert "scene has changed" in capsys.readouterr().err


def test_a_disabled_arm_is_refused_and_nothing_is_sent(robot, planned, until, capsys):
    robot.publish("/PSM1/state_command", string="disable")
    until(lambda: robot.state("PSM1") == "DISABLED", "disabled")
    assert refused(robot, planned, until)
    assert "DISABLED, not ENABLED" in capsys.readouterr().err
