"""`palpate ros sim` from the side of a client of the real dVRK: over ROS 2, from another process."""

import math
import os
import signal
import time

import numpy as np
import pytest
from dvrk_topics import ROWS, WHOLE_ROWS


@pytest.fixture
def dvrk(sim, node, until):
    from dvrk_client import Dvrk

    assert sim.poll() is None, sim.stderr.read()
    return Dvrk(node, until)


@pytest.fixture
def mtm(dvrk):
    dvrk.subscribe("/MTMR/operating_state", "/MTMR/measured_js", "/MTMR/measured_cp", "/MTMR/goal_reached")
    dvrk.home("MTMR")
    return dvrk


def joints(dvrk, arm="MTMR"):
    return np.array(dvrk.last[f"/{arm}/measured_js"].position)


def tip(dvrk, arm="MTMR"):
    p = dvrk.last[f"/{arm}/measured_cp"].pose.position
    return np.array([p.x, p.y, p.z])


def wait(until, seconds):
    end = time.monotonic() + seconds
    until(lambda: time.monotonic() > end, "time", seconds + 1)


def joint_state(**fields):
    from sensor_msgs.msg import JointState

    return JointState(**fields)


def wrench(x=0.0, y=0.0, z=0.0):
    from geometry_msgs.msg import WrenchStamped

    message = WrenchStamped()
    message.wrench.force.x, message.wrench.force.y, message.wrench.force.z = x, y, z
    return message


def joy(button):
    from sensor_msgs.msg import Joy

    return Joy(buttons=[button])


def test_every_topic_of_the_real_dvrk_exists(sim, node, until):
    assert wrong_topics(node, until, ROWS) == []


def wrong_topics(node, until, rows):
    """Rows of which name, type, direction, latching or the number of ends differ in the ROS graph."""
    services = {}

    def seen(topic, row):
        if row.direction == "srv":
            services.update(node.get_service_names_and_types())
            return services.get(topic)
        ends = node.get_publishers_info_by_topic if row.direction == "out" else node.get_subscriptions_info_by_topic
        return ends(topic)

    from rclpy.qos import DurabilityPolicy, ReliabilityPolicy

    wrong = []
    until(lambda: all(seen(topic, row) for topic, row in rows), [t for t, r in rows if not seen(t, r)])
    for topic, row in rows:
        package, _, name = row.type.partition("/")
        found = seen(topic, row)
        if row.direction == "srv":
            if f"{package}/srv/{name}" not in found:
                wrong.append((topic, found))
            continue
        latched = found[0].qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
        reliable = found[0].qos_profile.reliability == ReliabilityPolicy.RELIABLE
        if (found[0].topic_type, latched, reliable, len(found)) != (f"{package}/msg/{name}", row.latched, True, 1):
            wrong.append((topic, found[0].topic_type, latched, reliable, len(found)))
    return wrong


@pytest.fixture(scope="module")
def whole(start_once):
    """A robot with both MTMs, an endoscope and setup joints, in a domain of its own."""
    domain = (int(os.environ["ROS_DOMAIN_ID"]) + 13) % 100 + 1
    command = ("-m", "palpate", "ros", "sim", "--arms", "MTMR", "MTML", "PSM1", "ECM", "--rate", "200")
    process = start_once(*command, domain=domain)
    lines = []
    for line in process.stdout:
        lines.append(line)
        if "Ctrl-C" in line:
            return domain
    pytest.fail("".join([*lines, process.stderr.read()]))


@pytest.fixture
def there(whole, rclpy):
    """A node and a function that spins it, beside the whole robot."""
    from rclpy.context import Context
    from rclpy.executors import SingleThreadedExecutor

    context = Context()
    rclpy.init(context=context, domain_id=whole)
    node = rclpy.create_node(f"whole_{os.getpid()}", context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)

    def until(condition, description, seconds=20.0):
        end = time.monotonic() + seconds
        while not (value := condition()):
            assert time.monotonic() < end, f"timeout of {seconds:g} s: {description}"
            executor.spin_once(timeout_sec=0.01)
        return value

    yield node, until
    executor.shutdown()
    node.destroy_node()
    rclpy.shutdown(context=context)


@pytest.fixture
def client(there):
    from dvrk_client import Dvrk

    node, until = there
    return Dvrk(node, until, WHOLE_ROWS)


def test_every_topic_of_the_whole_dvrk_exists(there):
    """Setup joints, camera's teleoperation, endoscope, focus, statistics."""
    assert wrong_topics(*there, WHOLE_ROWS) == []


def test_setup_joints_move_the_base_and_the_answers_of_the_kinematics(client, there):
    from crtk_msgs.srv import QueryForwardKinematics

    node, until = there
    topics = ("/SUJ/PSM1/operating_state", "/SUJ/PSM1/measured_cp", "/SUJ/PSM1/measured_js", "/PSM1/measured_cp")
    client.subscribe("/PSM1/operating_state", *topics)
    client.home("PSM1")
    client.publish("/SUJ/PSM1/state_command", string="enable")
    until(lambda: client.state("SUJ/PSM1") == "ENABLED", "enabled")
    assert client.last["/SUJ/PSM1/measured_js"].name == ["lift", "shoulder", "elbow", "wrist", "tilt", "roll"]
    until(lambda: client.last["/PSM1/measured_cp"].header.stamp.sec > 0, "a valid pose")
    before = client.last["/PSM1/measured_cp"].pose.position.z
    lift = 0.1 if client.last["/SUJ/PSM1/measured_js"].position[0] < 0.05 else 0.0
    client.publish("/SUJ/PSM1/move_jp", joint_state(position=[lift, 0.0, 0.0, 0.0, 0.0, 0.0]))
    rise = 0.1 if lift else -0.1
    until(lambda: abs(client.last["/PSM1/measured_cp"].pose.position.z - before - rise) < 1e-3, "the base is lifted")
    ask = node.create_client(QueryForwardKinematics, "/PSM1/forward_kinematics")
    until(ask.service_is_ready, "the service")
    answer = ask.call_async(QueryForwardKinematics.Request(jp=[0.0, 0.0, 0.1, 0.0, 0.0, 0.0]))
    until(answer.done, "an answer")
    at_zero = answer.result().cp.position.z
    assert abs(at_zero - lift + 0.1) < 0.02, "the tip is 0.1 m below the lifted base"


def test_frames_of_arms_and_setup_joints_are_on_tf(client, there):
    """Each frame has one parent; the chain from the cart gives measured_cp."""
    from tf2_msgs.msg import TFMessage

    node, until = there
    client.subscribe("/PSM1/operating_state", "/PSM1/measured_cp")
    client.home("PSM1")
    edges = {}

    def keep(message):
        for t in message.transforms:
            edges.setdefault(t.child_frame_id, {})[t.header.frame_id] = t.transform.translation

    node.create_subscription(TFMessage, "/tf", keep, 100)
    until(lambda: "PSM1" in edges and "PSM1_base" in edges, "frames of PSM1")
    assert {child: list(parents) for child, parents in edges.items()}["PSM1_base"] == ["Cart"]
    assert all(len(parents) == 1 for parents in edges.values()), edges.keys()
    tip, base, measured = edges["PSM1"]["PSM1_base"], edges["PSM1_base"]["Cart"], client.last["/PSM1/measured_cp"]
    assert abs(base.z + tip.z - measured.pose.position.z) < 5e-3
    assert measured.header.frame_id == "PSM1_base"


def test_statistics_of_the_threads_are_plausible(there):
    from cisst_msgs.msg import IntervalStatistics

    node, until = there
    got = {}
    for name in ("mtmr_arm", "events"):
        node.create_subscription(
            IntervalStatistics, f"/stats/{name}/period_statistics", lambda m, name=name: got.update({name: m}), 10
        )
    until(lambda: len(got) == 2 and all(m.number_of_samples for m in got.values()), "statistics")
    servo, events = got["mtmr_arm"], got["events"]
    assert servo.period_avg == pytest.approx(1.0 / servo.number_of_samples, rel=0.05), "of a window of a second"
    assert servo.period_min <= servo.period_avg <= servo.period_max
    assert 0.0 < servo.compute_time_avg <= servo.compute_time_max
    assert events.number_of_samples == pytest.approx(200, rel=0.6)
    assert events.statistics_interval == 1.0


def test_status_warning_and_error_are_in_the_log(client, there):
    from rcl_interfaces.msg import Log
    from rclpy.qos import DurabilityPolicy, QoSProfile

    node, until = there
    log = []
    qos = QoSProfile(depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    node.create_subscription(Log, "/rosout", lambda m: log.append((int(m.level), m.name, m.msg)), qos)
    client.publish("/ECM/state_command", string="dance")
    client.publish("/ECM/set_endoscope_type", data="8K")
    client.publish("/SUJ/ECM/state_command", string="enable")

    def level(text):
        return {one[0] for one in log if text in one[2] and one[1] == "dvrk"}

    until(lambda: level("dance") and level("8K"), f"entries of the log: {log[-5:]}")
    assert level("dance") == {30}
    assert level("8K") == {40}
    client.publish("/system/power_on")
    until(lambda: level("enable requested for every arm") == {20}, "status")


def test_focus_and_camera_teleoperation_answer(client):
    client.subscribe("/endoscope_focus/focusing_in", "/MTML_MTMR_ECM/current_state", "/MTML_MTMR_ECM/scale",
                     "/ECM/endoscope_type")  # fmt: skip
    assert client.last["/ECM/endoscope_type"].data == "HD_STRAIGHT"
    assert client.last["/MTML_MTMR_ECM/current_state"].data == "DISABLED"
    client.publish("/endoscope_focus/focus_in", data=True)
    client._until(lambda: client.last["/endoscope_focus/focusing_in"].data, "focusing")
    client.publish("/endoscope_focus/focus_in", data=False)
    client.publish("/MTML_MTMR_ECM/set_scale", data=0.5)
    client._until(lambda: client.last["/MTML_MTMR_ECM/scale"].data == 0.5, "the scale")


HAND = """
import sys, time
import rclpy
from geometry_msgs.msg import PoseStamped
rclpy.init()
node = rclpy.create_node("hand")
to = node.create_publisher(PoseStamped, "/MTMR/hand/servo_cp", 10)
while not to.get_subscription_count():
    time.sleep(0.02)
pose = PoseStamped()
p = pose.pose.position
p.x, p.y, p.z = map(float, sys.argv[1:4])
o = pose.pose.orientation
o.x, o.y, o.z, o.w = 0.5, 0.5, 0.5, -0.5
to.publish(pose)
print("held", flush=True)
sys.stdin.read()
node.destroy_node()
rclpy.shutdown()
"""


def test_hand_that_holds_ends_with_its_client(client, there, start, whole):
    """While the client runs the handle stays where it holds it; when it has ended the hand exerts no force."""
    client.subscribe("/MTMR/operating_state", "/MTMR/measured_cp", "/MTMR/hand/measured_cf")
    client.home("MTMR")
    client._until(lambda: client.last["/MTMR/measured_cp"].header.stamp.sec > 0, "a valid pose")
    x, y, z = tip(client) + np.array([0.0, -0.03, 0.0])
    hand = start("-c", HAND, x, y, z, domain=whole)
    assert hand.stdout.readline() == "held\n"

    def force():
        f = client.last["/MTMR/hand/measured_cf"].wrench.force
        return math.hypot(f.x, f.y, f.z)

    client._until(lambda: force() > 0.5, f"the hand pulls the held arm: {force()} N")
    end = time.monotonic() + 1.0
    client._until(lambda: time.monotonic() > end, "time", 3.0)
    assert force() > 0.5, "it goes on while the client runs"
    hand.stdin.close()
    hand.wait(20)
    client._until(lambda: force() == 0.0, f"the hand has let go: {force()} N", 5.0)


def test_no_measurement_is_valid_when_powered_off(dvrk):
    """Invalid data have a zero stamp, as on the real robot."""
    dvrk.subscribe("/MTMR/operating_state", "/MTMR/measured_cp")
    if dvrk.state("MTMR") != "DISABLED":
        dvrk.publish("/MTMR/state_command", string="disable")
        dvrk._until(lambda: dvrk.state("MTMR") == "DISABLED", "disabled")
        dvrk.publish("/MTMR/state_command", string="unhome")
    dvrk._until(lambda: dvrk.last["/MTMR/measured_cp"].header.stamp.sec == 0, "a zero stamp")
    dvrk.home("MTMR")
    dvrk._until(lambda: dvrk.last["/MTMR/measured_cp"].header.stamp.sec > 0, "a stamp")
    stamp = dvrk.last["/MTMR/measured_cp"].header.stamp
    assert abs(time.time() - stamp.sec - 1e-9 * stamp.nanosec) < 1.0


def test_measured_states_of_a_homed_arm_are_consistent(mtm, until):
    """Joint names, shapes, and forward kinematics of the measured joints, which gives the measured pose."""
    topics = ("/MTMR/body/jacobian", "/MTMR/body/measured_cf", "/MTMR/gripper/measured_js", "/MTMR/setpoint_js")
    mtm.subscribe(*topics)
    assert len(mtm.last["/MTMR/measured_js"].name) == 7
    assert mtm.last["/MTMR/gripper/measured_js"].name == ["gripper"]
    jacobian = mtm.last["/MTMR/body/jacobian"]
    assert [(d.label, d.size) for d in jacobian.layout.dim] == [("rows", 6), ("cols", 7)]
    assert len(jacobian.data) == 42
    assert np.allclose(joints(mtm), mtm.last["/MTMR/setpoint_js"].position, atol=0.05)


def test_move_jp_reaches_its_goal(mtm, until):
    goal = np.array(mtm.last["/MTMR/measured_js"].position)
    goal[0] += 0.1
    goal[3] -= 0.1
    mtm.last.pop("/MTMR/goal_reached", None)
    mtm.publish("/MTMR/move_jp", joint_state(position=goal.tolist()))
    until(lambda: "/MTMR/goal_reached" in mtm.last, "goal_reached")
    assert mtm.last["/MTMR/goal_reached"].data
    until(lambda: np.allclose(joints(mtm), goal, atol=0.02), "the goal")


def test_kinematics_services(mtm, rclpy, node, until):
    from crtk_msgs.srv import QueryForwardKinematics, QueryInverseKinematics

    def call(name, kind, **fields):
        client = node.create_client(kind, f"/MTMR/{name}")
        until(client.service_is_ready, name)
        future = client.call_async(kind.Request(**fields))
        until(future.done, name)
        return future.result()

    q = [0.1, 0.2, 0.1, 0.3, 0.4, 0.2, 0.1]
    forward = call("forward_kinematics", QueryForwardKinematics, jp=q)
    assert forward.result, forward.message
    inverse = call("inverse_kinematics", QueryInverseKinematics, cp=forward.cp, jp=q)
    assert inverse.result, inverse.message
    again = call("forward_kinematics", QueryForwardKinematics, jp=inverse.jp).cp
    assert math.isclose(again.position.x, forward.cp.position.x, abs_tol=1e-5)
    assert math.isclose(again.position.z, forward.cp.position.z, abs_tol=1e-5)
    short = call("forward_kinematics", QueryForwardKinematics, jp=[0.0])
    assert not short.result
    assert "needs 7" in short.message


def test_servo_cf_moves_the_arm_and_has_no_timeout(mtm, until):
    """The arm moves under a wrench in base axes and keeps the last one, without a timeout."""
    mtm.publish("/MTMR/use_gravity_compensation", data=True)
    mtm.publish("/MTMR/body/set_cf_orientation_absolute", data=True)
    mtm.publish("/MTMR/body/servo_cf", wrench())
    wait(until, 0.3)
    start = tip(mtm)
    mtm.publish("/MTMR/body/servo_cf", wrench(y=1.5))
    until(lambda: tip(mtm)[1] > start[1] + 0.01, "a push of 1.5 N along y moves it by 10 mm")
    mtm.publish("/MTMR/hold")
    wait(until, 0.3)
    assert np.abs(np.array(mtm.last["/MTMR/measured_js"].velocity)).max() < 0.1


def test_arm_falls_without_gravity_compensation(mtm, until):
    mtm.publish("/MTMR/use_gravity_compensation", data=True)
    mtm.publish("/MTMR/free")
    wait(until, 0.4)
    held = tip(mtm)
    mtm.publish("/MTMR/use_gravity_compensation", data=False)
    until(lambda: tip(mtm)[2] < held[2] - 0.02, "it falls by 20 mm")
    mtm.publish("/MTMR/use_gravity_compensation", data=True)
    mtm.publish("/MTMR/hold")
    mtm.home("MTMR")


def test_refused_commands_are_reported(mtm, until):
    mtm.subscribe("/MTMR/warning", "/MTMR/error")
    mtm.publish("/MTMR/state_command", string="dance")
    until(lambda: "/MTMR/warning" in mtm.last or "/MTMR/error" in mtm.last, "a warning for an unknown state command")


def test_teleoperation_with_emulated_pedals(mtm, until):
    """Once enabled and aligned, the instrument follows the scaled hand while the operator is present."""
    mtm.subscribe(
        "/PSM1/operating_state", "/PSM1/measured_js", "/PSM1/measured_cp", "/MTMR_PSM1/following", "/MTMR_PSM1/scale"
    )
    mtm.subscribe("/MTMR_PSM1/current_state", "/console/teleop/enabled")
    mtm.subscribe("/console/operator_present", wait=False)  # the operator has not been present yet
    mtm.home("PSM1")
    q = joints(mtm, "PSM1")
    q[2] = 0.12
    mtm.publish("/PSM1/move_jp", joint_state(position=q.tolist()))
    until(lambda: abs(joints(mtm, "PSM1")[2] - 0.12) < 2e-3, "the instrument past the cannula")
    mtm.publish("/console/teleop/select", data="MTMR_PSM1")
    mtm.publish("/console/teleop/enable", data=True)
    until(lambda: mtm.last["/console/teleop/enabled"].data, "teleoperation enabled")
    mtm.publish("/console/emulate_operator_present", joy(1))
    pedal = "/console/operator_present"
    until(lambda: pedal in mtm.last and mtm.last[pedal].buttons[0] == 1, "the operator")
    state = "/MTMR_PSM1/current_state"
    until(lambda: mtm.last[state].data == "ALIGNING_MTM", "aligning")
    for angle in (0.9, 0.1, 0.9):  # the operator closes the gripper to start
        mtm.publish("/MTMR/hand/gripper", data=angle)
        wait(until, 0.2)
    until(lambda: mtm.last[state].data == "ENABLED", "MTM aligned, teleop enabled", 20.0)
    until(lambda: mtm.last["/MTMR_PSM1/following"].data, "following")
    hand, tool = tip(mtm), tip(mtm, "PSM1")
    mtm.publish("/MTMR_PSM1/following/mtm/body/servo_cf", wrench(z=2.0))
    until(lambda: np.linalg.norm(tip(mtm) - hand) > 0.02, "the official hook moves the hand")
    mtm.publish("/MTMR_PSM1/following/mtm/body/servo_cf", wrench())
    wait(until, 0.5)
    moved, followed = tip(mtm) - hand, tip(mtm, "PSM1") - tool
    assert np.linalg.norm(followed - mtm.last["/MTMR_PSM1/scale"].data * moved) < 2e-3
    mtm.publish("/console/emulate_operator_present", joy(0))
    until(lambda: not mtm.last["/MTMR_PSM1/following"].data, "no longer following")


@pytest.mark.parametrize("end", [signal.SIGINT, signal.SIGTERM])
def test_sim_ends_cleanly(start, end):
    domain = (int(os.environ["ROS_DOMAIN_ID"]) + 23 + end) % 100 + 1  # the others' robot has a PSM1, too
    process = start("-m", "palpate", "ros", "sim", "--arms", "PSM1", domain=domain)
    while "Ctrl-C" not in (line := process.stdout.readline()):
        assert line, process.stderr.read()
    process.send_signal(end)
    out, err = process.communicate(timeout=20)
    assert process.returncode == 0, err
    assert "arms powered off" in out
    assert err == ""


def test_mistakes_are_reported(start):
    for arguments, message in ((["--arms", "MTMX"], "no arm 'MTMX'"), (["--rate", "2000"], "from 1 to 1000 Hz")):
        process = start("-m", "palpate", "ros", "sim", *arguments)
        _, err = process.communicate(timeout=20)
        assert process.returncode == 2
        assert message in err
