"""`palpate ros device`: a driver as a CRTK master, with a client that has no code of ours but the node."""

import threading
import time

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from palpate.devices.driver import Driver, Reading, facts

TURN = Rotation.from_euler("xyz", [90, 0, 0], degrees=True).as_matrix()


class Moving(Driver):
    """Moves by 0.1 m/s along x; its handle is turned by 90 degrees about x."""

    rate, force_max, moment_max = 200.0, 2.0, 0.1
    own_buttons = ("stylus", "side")
    pressed = 5 | 0x200
    hole = 0.0

    def __init__(self):
        self.written, self.t0, self.hang, self.fails, self.closed = [], 0.0, 0.0, False, False

    def open(self):
        self.t0 = time.monotonic()

    def read(self):
        if self.fails:
            raise OSError("cable pulled")
        time.sleep(self.hang)
        X = np.eye(4)
        X[:3, :3] = TURN
        X[0, 3] = 0.1 * (time.monotonic() - self.t0) + self.hole
        return Reading(X, None, 0.25, self.pressed)

    def write(self, wrench):
        self.written.append((time.monotonic(), wrench.copy()))

    def close(self):
        self.closed = True


@pytest.fixture
def master(built):
    """The driver, its master and a node of a client, while the master runs."""
    from palpate import ros
    from palpate.ros import topic
    from palpate.ros.device_master import DeviceMaster

    driver = Moving()
    domain = ros.load().Context(network=False).domain
    with DeviceMaster("OMEGA", driver, facts(driver, "moving"), domain) as made, topic.node(name="client") as client:
        stop = threading.Event()
        thread = threading.Thread(target=made.run, args=(30.0,), daemon=True)
        thread.start()
        made.thread = thread
        yield driver, made, client
        driver.hang, driver.fails = 0.0, True
        thread.join(5.0)
        stop.set()


def hear(client, name, kind, count=1, latched=False):
    from rclpy.qos import DurabilityPolicy, QoSProfile

    from palpate.ros import topic

    found = []
    quality = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL) if latched else 10
    listening = client.create_subscription(topic.message_type(kind), name, found.append, quality)
    end = time.monotonic() + 20.0
    while len(found) < count and time.monotonic() < end:
        topic.spin(client, 0.1)
    client.destroy_subscription(listening)
    assert len(found) >= count, f"{name} is silent"
    return found


def push(client, name, force, seconds, torque=(0.0, 0.0, 0.0)):
    """Send a wrench at 100 Hz for a time."""
    from geometry_msgs.msg import WrenchStamped

    publisher = client.create_publisher(WrenchStamped, name, 1)
    end = time.monotonic() + 20.0
    while not publisher.get_subscription_count() and time.monotonic() < end:
        time.sleep(0.02)
    message = WrenchStamped()
    f, t = message.wrench.force, message.wrench.torque
    f.x, f.y, f.z = map(float, force)
    t.x, t.y, t.z = map(float, torque)
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        publisher.publish(message)
        time.sleep(0.01)
    client.destroy_publisher(publisher)
    return time.monotonic()


def test_pose_velocity_gripper_buttons_and_state_go_out(master):
    _, _, client = master
    first, *_, last = hear(client, "/OMEGA/measured_cp", "geometry_msgs/PoseStamped", 20)
    q = first.pose.orientation
    assert Rotation.from_quat([q.x, q.y, q.z, q.w]).as_matrix() == pytest.approx(TURN, abs=1e-9)
    assert first.header.frame_id == "OMEGA_base"
    t = [m.header.stamp.sec + 1e-9 * m.header.stamp.nanosec for m in (first, last)]
    assert (last.pose.position.x - first.pose.position.x) / (t[1] - t[0]) == pytest.approx(0.1, rel=0.3)
    twist = hear(client, "/OMEGA/measured_cv", "geometry_msgs/TwistStamped", 5)[-1].twist
    assert twist.linear.x == pytest.approx(0.1, rel=0.3)
    assert hear(client, "/OMEGA/gripper/measured_js", "sensor_msgs/JointState")[0].position[0] == 0.25
    assert list(hear(client, "/OMEGA/buttons", "sensor_msgs/Joy", latched=True)[0].buttons)[:3] == [1, 0, 1]
    state = hear(client, "/OMEGA/operating_state", "crtk_msgs/OperatingState", latched=True)[0]
    assert (state.state, state.is_homed) == ("ENABLED", True)


def test_each_own_button_goes_out_by_its_name_when_it_changes(master):
    driver, _, client = master
    heard = {name: hear(client, f"/OMEGA/{name}", "sensor_msgs/Joy", latched=True) for name in driver.own_buttons}
    assert {name: list(found[0].buttons) for name, found in heard.items()} == {"stylus": [0], "side": [1]}
    driver.pressed = 5 | 0x100
    end = time.monotonic() + 10.0
    while list(hear(client, "/OMEGA/side", "sensor_msgs/Joy", latched=True)[-1].buttons) != [0]:
        assert time.monotonic() < end
    assert list(hear(client, "/OMEGA/stylus", "sensor_msgs/Joy", latched=True)[-1].buttons) == [1]


@pytest.mark.parametrize(
    ("name", "force", "felt"),
    [("servo_cf", (0.5, 1.0, -1.5), (0.5, 1.0, -1.5)), ("body/servo_cf", (0.0, 0.0, 1.0), (0.0, -1.0, 0.0)),
     ("servo_cf", (0.0, 0.0, 10.0), (0.0, 0.0, 2.0))],
    ids=["base", "body", "capped"],
)  # fmt: skip
def test_a_force_comes_in_its_frame_within_the_cap_and_goes_stale(master, name, force, felt):
    driver, made, client = master
    end = push(client, f"/OMEGA/{name}", force, 0.5)
    time.sleep(0.2)
    during = [F for t, F in driver.written if t < end and F.any()]
    assert during[-1][:3] == pytest.approx(felt, abs=1e-9)
    after = [t for t, F in driver.written if F.any()]
    assert max(after) < end + 0.1
    assert not driver.written[-1][1].any()
    assert made.outcome.stale >= 1


@pytest.mark.parametrize("latches", [True, False])
def test_moments_are_capped_and_absolute_axes_are_those_of_the_base(master, latches):
    """CRTK's Python clients latch the flag, and may send it before they are found; a dVRK and Palpate's node do not."""
    from rclpy.qos import DurabilityPolicy, QoSProfile
    from std_msgs.msg import Bool

    driver, _, client = master
    durability = DurabilityPolicy.TRANSIENT_LOCAL if latches else DurabilityPolicy.VOLATILE
    flag = "/OMEGA/body/set_cf_orientation_absolute"
    publisher = client.create_publisher(Bool, flag, QoSProfile(depth=1, durability=durability))
    end = time.monotonic() + 10.0
    while not latches and not publisher.get_subscription_count() and time.monotonic() < end:
        time.sleep(0.02)
    publisher.publish(Bool(data=True))
    time.sleep(1.5)
    push(client, "/OMEGA/body/servo_cf", (0.0, 0.0, 1.0), 0.4, (0.0, 3.0, 0.0))
    felt = [F for _, F in driver.written if F.any()][-1]
    assert felt == pytest.approx([0.0, 0.0, 1.0, 0.0, 0.1, 0.0])


def test_a_force_that_is_not_finite_is_zero(master):
    driver, made, client = master
    push(client, "/OMEGA/servo_cf", (np.nan, 0.0, 1.0), 0.3)
    assert made.outcome.refused > 0
    assert not any(F.any() for _, F in driver.written)


def test_a_driver_that_hangs_or_fails_gets_zero(master):
    driver, made, client = master
    push(client, "/OMEGA/servo_cf", (0.0, 0.0, 1.0), 0.3)
    driver.hang = 0.2
    push(client, "/OMEGA/servo_cf", (0.0, 0.0, 1.0), 0.6)
    assert made.outcome.stalls >= 1
    driver.hang, driver.fails = 0.0, True
    made.thread.join(5.0)
    assert made.outcome.fault == "OSError: cable pulled"
    assert driver.closed
    assert not driver.written[-1][1].any()


def test_the_command_serves_a_simulated_device(built, capsys):
    import json

    from palpate.cli import main

    assert main(["ros", "device", "simulated", "--duration", "0.5", "--json", "-"]) == 0
    done = json.loads(capsys.readouterr().out)
    assert done["name"] == "MTMR"
    assert done["rounds"] > 50
    assert main(["ros", "device", "simulated", "--arm", "a/b"]) == 2
    assert "is no name of an arm" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["servo_cf", "body/servo_cf"])
def test_a_pose_that_is_not_a_number_gives_no_force_and_is_not_published(master, name):
    driver, made, client = master
    driver.hole = np.nan
    time.sleep(0.05)
    begin = time.monotonic()
    end = push(client, f"/OMEGA/{name}", (0.5, 1.0, -1.5), 0.3)
    assert made.outcome.forces > 0
    written = [wrench for t, wrench in driver.written if begin < t < end]
    assert len(written) > 20
    assert not np.any(written)
    driver.hole = 0.0
    push(client, f"/OMEGA/{name}", (0.5, 1.0, -1.5), 0.3)
    assert any(wrench.any() for t, wrench in driver.written if t > end)
