"""`palpate ros move` on the simulated PSM: it arrives, stops, refuses and aborts."""

import json
import signal
import time

import numpy as np
import pytest
import yaml
from dvrk_client import Dvrk, message_type

pytest.importorskip("ompl", reason="motion planning needs the extra planning")
pytest.importorskip("coal", reason="motion planning needs the extra planning")
pytest.importorskip("ruckig", reason="motion planning needs the extra planning")

from palpate.cli import main
from palpate.planning import Problem, load
from palpate.planning.checker import Checker
from palpate.planning.world import obstacle
from palpate.ros import topic
from palpate.ros.move_goals import GoalMover
from palpate.scene import Scene
from palpate.world import surfaces

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
    state = robot.last["/PSM1/operating_state"]
    if state.state != "ENABLED" or not state.is_homed:  # the tests share the robot
        robot.home("PSM1")
        rest(robot, until)  # homed is told before the motion to the home position begins
    robot.goals = []
    if state.is_busy or np.abs(q(robot) - START).max() >= 5e-4:
        place(robot, until, START)
    for verb in ("servo_jp", "move_jp"):
        node.create_subscription(JointState, f"/PSM1/{verb}", lambda m: robot.goals.append((time.monotonic(), m)), 1000)
    return robot


def q(robot):
    return np.array(robot.last[BACK].position)


def rest(robot, until, seconds=0.3):
    """Wait until the arm has not moved for a time [s]."""
    seen = [time.monotonic(), q(robot)]

    def still():
        if np.abs(q(robot) - seen[1]).max() > 1e-3 or robot.last["/PSM1/operating_state"].is_busy:
            seen[:] = [time.monotonic(), q(robot)]
        return time.monotonic() - seen[0] > seconds

    until(still, "rest", 20.0)


def place(robot, until, goal):
    from sensor_msgs.msg import JointState

    robot.publish("/PSM1/move_jp", JointState(position=goal.tolist()))
    state = "/PSM1/operating_state"
    until(lambda: np.abs(q(robot) - goal).max() < 5e-4 and not robot.last[state].is_busy, "the place", 20.0)
    robot.goals.clear()  # its own goal is no goal of the plan


def begin(start, planned, *more):
    out = planned / "moved.json"
    out.unlink(missing_ok=True)
    return start("-m", "palpate", "ros", "move", planned / "plan.yaml", "--arm", "PSM1", "--json", out, *more)


def run(planned, *more, plan="plan.yaml"):
    """Exit code and JSON of the command in this process."""
    out = planned / "moved.json"
    out.unlink(missing_ok=True)
    code = main(["ros", "move", str(planned / plan), "--arm", "PSM1", "--json", str(out), *map(str, more)])
    return code, json.loads(out.read_text()) if out.is_file() else None


def refused(robot, planned, until, *more, **plan):
    """True if the command refuses and nothing arrives."""
    code, moved = run(planned, *more, **plan)
    end = time.monotonic() + 0.2
    until(lambda: time.monotonic() > end, "time")
    return (code, moved, robot.goals) == (2, None, [])


def ended(process, planned, until):
    """Exit code and JSON of a process, while this one listens."""
    until(lambda: process.poll() is not None, "the end of the motion", 60.0)
    out = planned / "moved.json"
    assert out.is_file(), f"exit code {process.returncode}: {process.stdout.read()}{process.stderr.read()}"
    return process.returncode, json.loads(out.read_text())


def moving(robot, until, process, goals=50):
    until(lambda: len(robot.goals) > goals or process.poll() is not None, "goals", 60.0)
    assert process.poll() is None, process.stdout.read() + process.stderr.read()


def test_the_arm_arrives_at_the_goal(robot, planned, until):
    code, moved = run(planned, "--speed", "1")
    assert (code, moved["success"], moved["phase"]) == (0, True, "done"), moved
    until(lambda: len(robot.goals) >= 0.9 * moved["goals"], "the goals: a slow listener may miss some")
    until(lambda: np.allclose(q(robot), GOAL, atol=1e-3), "the goal", 5.0)
    until(
        lambda: np.allclose(robot.goals[-1][1].position, GOAL, rtol=0.0, atol=1e-9), "the last goal is the plan's end"
    )
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
    """Another program sends goals at the same time, so near that the servos do not fault."""
    from sensor_msgs.msg import JointState

    process = begin(start, planned, "--speed", "0.2")
    moving(robot, until, process)
    elsewhere = q(robot) + np.array([0.0, -0.05, 0.0, 0, 0, 0])
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


def test_another_arm_is_refused_and_nothing_is_sent(robot, planned, until, capsys):
    code = main(["ros", "move", str(planned / "plan.yaml"), "--arm", "PSM2"])
    assert code == 2
    assert "the plan was proved for PSM1, not for PSM2" in capsys.readouterr().err


def test_base_that_the_arm_reports_elsewhere_is_refused(robot, planned, until, capsys, node):
    """Setup joints or somebody's set_base_frame have moved it: the obstacles are elsewhere for this arm."""
    from geometry_msgs.msg import PoseStamped

    moved = PoseStamped()
    moved.pose.position.x, moved.pose.orientation.w = 0.085, 1.0
    robot.publish("/PSM1/set_base_frame", moved)
    try:
        assert refused(robot, planned, until)
        assert "reports its base" in capsys.readouterr().err
    finally:
        moved.pose.position.x = 0.0
        robot.publish("/PSM1/set_base_frame", moved)


def test_another_instrument_is_refused(robot, planned, until, capsys):
    from std_msgs.msg import String

    robot.publish("/PSM1/set_tool_type", String(data="PROGRASP_FORCEPS:400093"))
    try:
        assert refused(robot, planned, until)
        assert "holds PROGRASP_FORCEPS:400093" in capsys.readouterr().err
    finally:
        robot.publish("/PSM1/set_tool_type", String(data="LARGE_NEEDLE_DRIVER:400006[12]"))


def test_a_disabled_arm_is_refused_and_nothing_is_sent(robot, planned, until, capsys):
    robot.publish("/PSM1/state_command", string="disable")
    until(lambda: robot.state("PSM1") == "DISABLED", "disabled")
    assert refused(robot, planned, until)
    assert "DISABLED, not ENABLED" in capsys.readouterr().err


# --- way points, by move_jp -----------------------------------------------------------------------------------------

BY_GOALS = ("--by", "move_jp")


def test_way_points_lead_to_the_goal_with_the_clearance(robot, planned, start, until, node):
    """Every measured position keeps the clearance, less what a servo lags; the arm's speed is set and restored."""
    rows, ratios = [], []
    keep = lambda m: rows.append(np.array(m.position))  # noqa: E731
    node.create_subscription(message_type("sensor_msgs/JointState"), "/PSM1/setpoint_js", keep, 1)
    keep_ratio = lambda m: ratios.append(m.data)  # noqa: E731
    node.create_subscription(message_type("std_msgs/Float64"), "/PSM1/trajectory_j/ratio_v", keep_ratio, 10)
    process = begin(start, planned, *BY_GOALS, "--speed", "0.9")
    code, moved = ended(process, planned, until)
    assert (code, moved["success"], moved["phase"], moved["by"]) == (0, True, "done", "move_jp"), moved["reason"]
    until(lambda: ratios[-1] == 1.0, f"the old ratio after {ratios}")
    assert 0.9 in ratios
    until(lambda: np.allclose(q(robot), GOAL, atol=1e-3), "the goal", 5.0)
    way = np.array([START, *(m.position for _, m in robot.goals)])
    assert 3 < len(way) < 40
    problem = Problem.of(Scene.load(planned / "scene.yaml"))
    checker = Checker(problem.robot, problem.world)
    assert len(rows) > 300
    assert all(checker.refusal(one, problem.clearance - 1e-4) is None for one in rows[::5])


def test_a_pause_between_way_points_holds_and_a_stop_ends(robot, planned, start, until, node):
    from std_msgs.msg import Empty

    process = begin(start, planned, *BY_GOALS, "--speed", "0.2")
    ends = {name: node.create_publisher(Empty, f"/palpate_move_PSM1/{name}", 1) for name in ("pause", "resume", "stop")}
    moving(robot, until, process, 0)
    until(lambda: all(end.get_subscription_count() for end in ends.values()), "the node's topics")
    state = "/PSM1/operating_state"
    until(lambda: robot.last[state].is_busy and np.abs(q(robot) - START).max() > 0.02, "motion")
    ends["pause"].publish(Empty())
    until(lambda: not robot.last[state].is_busy, "a hold")
    held, count = q(robot), len(robot.goals)
    end = time.monotonic() + 0.3
    until(lambda: time.monotonic() > end, "time")
    assert np.abs(q(robot) - held).max() < 0.02
    assert len(robot.goals) == count
    ends["resume"].publish(Empty())
    until(lambda: robot.last[state].is_busy and len(robot.goals) > count, "it goes on")
    np.testing.assert_array_equal(robot.goals[-1][1].position, robot.goals[-2][1].position)  # the same way point
    process.send_signal(signal.SIGINT)
    code, moved = ended(process, planned, until)
    assert (code, moved["phase"], moved["success"]) == (130, "stopped", False)
    assert not robot.last[state].is_busy
    assert np.abs(np.array(moved["end"]) - GOAL).max() > 0.1


def test_a_move_that_another_program_ends_aborts(robot, planned, start, until):
    process = begin(start, planned, *BY_GOALS, "--speed", "0.2")
    moving(robot, until, process, 0)
    until(lambda: np.abs(q(robot) - START).max() > 0.02, "motion")
    robot.publish("/PSM1/hold")
    code, moved = ended(process, planned, until)
    assert (code, moved["phase"]) == (1, "aborted")
    assert "gave up way point" in moved["reason"]


def test_way_points_that_the_arm_could_leave_are_refused_and_nothing_is_sent(robot, planned, until, capsys):
    tight = yaml.safe_load((planned / "plan.yaml").read_text())
    tight["clearance_asked_m"] = tight["clearance_m"] - 1e-4  # still proved free; the interpolation has nothing left
    (planned / "tight.yaml").write_text(yaml.safe_dump(tight))
    assert refused(robot, planned, until, *BY_GOALS, plan="tight.yaml")
    assert "cannot be sent as way points" in capsys.readouterr().err
    assert refused(robot, planned, until, *BY_GOALS, "--clearance", "5mm")
    assert "--clearance must lie in 0 to 3 mm" in capsys.readouterr().err
    assert refused(robot, planned, until, *BY_GOALS, "--rate", "100")
    assert "--rate has no effect" in capsys.readouterr().err
    assert refused(robot, planned, until, "--clearance", "2mm")
    assert "--clearance has no effect" in capsys.readouterr().err


def test_no_way_point_is_sent_into_a_world_that_has_changed(robot, planned, until, node):
    """The version of the world is looked at before each leg and on the way: the arm holds before the new obstacle."""
    problem = Problem.of(Scene.load(planned / "scene.yaml"))
    plan = load(planned / "plan.yaml")
    worlds = [problem.world]
    with topic.node(name="palpate_changed") as here:
        mover = GoalMover(here, "PSM1", problem, plan, 0.5, world=lambda: worlds[-1])
        ball = obstacle("ball", surfaces.Sphere(0.01), problem.robot.X_WB @ problem.robot.arm.fk(GOAL))

        here.create_timer(0.5, lambda: worlds.append(problem.world.with_added([ball])))
        moved = mover.run()
    assert moved.phase == "aborted"
    assert "ball" in moved.reason
    robot.publish("/PSM1/hold")
