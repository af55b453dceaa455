"""The full loop on the simulated dVRK: a hand on the MTM, a teleoperation, the PSM's tool at a wall, and the force on
the hand; with the dVRK's teleoperation, and with our own.

`hand/measured_cf` is the simulated load cell between handle and hand, which measures the force on the hand.
"""

import signal
import time

import numpy as np
import pytest

RATE = 125
ARMS = ("MTMR", "PSM1", "MTML", "ECM")
START = {"MTMR": [0.0] * 7, "PSM1": [0.0, 0.0, 0.12, 0.0, 0.0, 0.0]}  # where each test begins [rad, m]
NEAR = {"MTMR": 0.06, "PSM1": 1e-3}  # [rad, m]; the MTM has friction
MOST = 0.05  # longest time from a pedal to zero force [s]
FRICTION = 0.8  # largest friction of the simulated MTM at its handle, between commanded and measured force [N]
UP = np.array([0.0, 0.0, 1.0])
SCENE = """
objects:
  - {{name: wall, plane: {{size: 0.3}}, pose: {{xyz: [{x}, {y}, {z}]}}, stiffness: 1500, damping: 5}}
arms: {{leader: {{base: {{xyz: [0, 0, 0]}}, start: [0, 0, 0, 0, 0, 0, 0]}}, follower: {{base: {{xyz: [0, 0, 0]}}}}}}
mapping: {{scale: 0.2}}
record: {{report: false}}
operator: {{path: [{{t: 0.2, xyz: [{x}, {y}, {high}]}}, {{t: 1, xyz: [{x}, {y}, {z}]}}]}}
"""


def xyz(v):
    return np.array([v.x, v.y, v.z])


class Robot:
    """The simulated dVRK with a hand on its MTM."""

    def __init__(self, dvrk, node, until):
        self.dvrk, self.node, self.until = dvrk, node, until
        self.sent = []  # (stamp [s], force (3,)) of each wrench
        self.pedals = {}  # stamp of the last change of each pedal

    def subscribe_wrenches(self, topic):
        from geometry_msgs.msg import WrenchStamped

        def keep(m):
            self.sent.append((m.header.stamp.sec + 1e-9 * m.header.stamp.nanosec, xyz(m.wrench.force)))

        def keep_all(m):
            """Also what waits behind this message: one a turn would leave a busy machine seconds behind."""
            keep(m)
            while waits := wrenches.handle.take_message(WrenchStamped, False):
                keep(waits[0])

        self.sent.clear()
        wrenches = self.node.create_subscription(WrenchStamped, topic, keep_all, 1000)

    @property
    def push(self):
        """Last commanded force [N]."""
        return float(np.linalg.norm(self.sent[-1][1])) if self.sent else 0.0

    @property
    def felt(self):
        """Upward force on the hand from the load cell [N]."""
        return float(xyz(self.dvrk.last["/MTMR/hand/measured_cf"].wrench.force) @ UP)

    def position_of(self, arm):
        return xyz(self.dvrk.last[f"/{arm}/measured_cp"].pose.position)

    def wait(self, seconds):
        end = time.monotonic() + seconds
        self.until(lambda: time.monotonic() > end, "time passes")

    def home(self):
        """Home all arms, and move MTM and instrument to the start: the instrument past its cannula."""
        from sensor_msgs.msg import JointState

        last = self.dvrk.last
        for arm in ARMS:
            self.dvrk.subscribe(f"/{arm}/operating_state")
        for arm in START:
            self.dvrk.subscribe(f"/{arm}/measured_cp", f"/{arm}/measured_js")
        self.dvrk.home(*ARMS)
        self.dvrk.subscribe("/MTMR/hand/measured_cf")
        for arm, q in START.items():
            self.dvrk.publish(f"/{arm}/move_jp", JointState(position=q))

        def there(arm):
            away = np.abs(np.subtract(last[f"/{arm}/measured_js"].position, START[arm]))
            return away.max() < NEAR[arm] and not last[f"/{arm}/operating_state"].is_busy

        self.until(lambda: all(there(arm) for arm in START), "the arms at the start", 20.0)
        self.wait(0.5)
        assert all(there(arm) for arm in START), "at rest at the start"

    def leave(self):
        """Let go of handle and pedals, and end the teleoperation, for the next test."""
        for name in ("operator_present", "clutch", "camera"):
            self.pedal(name, 0)
        self.dvrk.subscribe("/MTMR_PSM1/current_state")
        self.dvrk.publish("/console/teleop/enable", data=False)
        self.dvrk.publish("/MTMR/hand/free")
        self.until(lambda: self.dvrk.last["/MTMR_PSM1/current_state"].data == "DISABLED", "the teleoperation off")

    def pedal(self, name, button):
        """Press or release a pedal; returns the time [s]."""
        from sensor_msgs.msg import Joy

        topic = f"/console/{name}"
        if topic not in self.pedals:
            self.dvrk.subscribe(topic, wait=False)
            self.pedals[topic] = True
        self.dvrk.publish(f"/console/emulate_{name}", Joy(buttons=[button]))
        last = self.dvrk.last
        self.until(lambda: topic in last and last[topic].buttons[0] == button, f"{name} {button}")
        stamp = last[topic].header.stamp
        return stamp.sec + 1e-9 * stamp.nanosec

    def follow(self):
        """Start the dVRK teleoperation and close the gripper until it follows."""
        last = self.dvrk.last
        self.dvrk.subscribe("/MTMR_PSM1/current_state", "/MTMR_PSM1/following", "/MTMR_PSM1/scale")
        self.dvrk.publish("/console/teleop/enable", data=True)
        self.pedal("operator_present", 1)
        self.pinch()
        self.until(lambda: last["/MTMR_PSM1/following"].data, "following", 30.0)

    def pinch(self):
        end = time.monotonic() + 20.0
        self.until(lambda: self.dvrk.last["/MTMR_PSM1/current_state"].data != "SETTING_ARMS_STATE", "aligning")
        while self.dvrk.last["/MTMR_PSM1/current_state"].data != "ENABLED":
            assert time.monotonic() < end, "the MTM does not align"
            for angle in (0.9, 0.1, 0.9):
                self.dvrk.publish("/MTMR/hand/gripper", data=angle)
                self.wait(0.2)

    def press(self, newtons, most=0.08):
        """Move the hand down at 2 cm/s until the force reaches `newtons` [N]."""
        from geometry_msgs.msg import PoseStamped

        goal = PoseStamped(pose=self.dvrk.last["/MTMR/measured_cp"].pose)
        top = goal.pose.position.z
        while self.push < newtons:
            assert goal.pose.position.z > top - most, f"no wall: {self.push:.2f} N, tool at {self.position_of('PSM1')}"
            goal.pose.position.z -= 0.0004
            self.dvrk.publish("/MTMR/hand/servo_cp", goal)
            self.wait(0.02)
        self.wait(0.5)

    def freed(self, pedalled):
        """Time from a pedal to the last force sent [s]; this subscriber may be late, so the stamps count."""
        self.until(lambda: self.sent[-1][0] > pedalled and self.push == 0.0, "zero", 20.0)
        self.wait(0.5)
        assert self.push == 0.0
        return max([t - pedalled for t, force in self.sent if force.any()])


@pytest.fixture(scope="module")
def sim(start_once):
    """The simulated dVRK, shared by the tests of this file."""
    return start_once("-m", "palpate", "ros", "sim", "--arms", *ARMS, "--rate", RATE)


@pytest.fixture
def robot(sim, node, until):
    from dvrk_client import Dvrk

    robot = Robot(Dvrk(node, until), node, until)
    robot.home()
    yield robot
    robot.leave()


@pytest.fixture
def start_haptics(start, tmp_path, robot):
    """A function that starts the haptic node with a wall 3 mm below the tool."""

    def run(*options):
        x, y, z = robot.position_of("PSM1")
        (tmp_path / "wall.yaml").write_text(SCENE.format(x=x, y=y, z=z - 0.003, high=z))
        fixed = ("--rate", RATE, "--out", tmp_path / "runs", "--force-cap", 2.0)
        return start("-m", "palpate", "ros", "haptics", tmp_path / "wall.yaml", *fixed, *options)

    return run


def ended(process):
    process.send_signal(signal.SIGTERM)
    out, err = process.communicate(timeout=30)
    assert process.returncode == 0, err
    return out


@pytest.mark.parametrize("frame", ["absolute", pytest.param("tip", marks=pytest.mark.long)])
def test_force_with_the_teleoperation_of_the_dvrk(robot, start_haptics, frame):
    process = start_haptics(*(["--tip-frame"] * (frame == "tip")))
    hook = "/MTMR_PSM1/following/mtm/body/servo_cf"
    robot.subscribe_wrenches(hook)
    robot.follow()
    robot.until(lambda: len(robot.sent) > RATE, "a second of wrenches", 60.0)
    assert not any(force.any() for _, force in robot.sent), "no force in free space"
    hand, tool = robot.position_of("MTMR"), robot.position_of("PSM1")
    robot.press(1.5)
    moved, followed = robot.position_of("MTMR") - hand, robot.position_of("PSM1") - tool
    assert np.linalg.norm(followed - robot.dvrk.last["/MTMR_PSM1/scale"].data * moved) < 2e-3
    assert abs(robot.felt - robot.push) < FRICTION, "the commanded force reaches the hand, upwards"

    took = []
    for _ in range(3):
        took.append(robot.freed(robot.pedal("clutch", 1)))
        assert abs(robot.felt) < FRICTION
        robot.pedal("clutch", 0)
        robot.pinch()
        robot.press(1.5)
        if took[-1] < MOST:
            break
    assert min(took) < MOST
    assert robot.freed(robot.pedal("operator_present", 0)) < 2 * MOST
    ended(process)


def test_node_restores_the_wrench_frame_after_the_camera_pedal(robot, start_haptics):
    """The camera teleoperation makes the MTM's wrench frame absolute and leaves it so without a message."""
    cf = ("/MTMR/body/measured_cf", "/MTMR/spatial/measured_cf")
    robot.dvrk.subscribe(*cf)

    def absolute():
        """True if the measured body force has base axes, as the spatial one."""
        robot.wait(0.3)
        body, spatial = (xyz(robot.dvrk.last[topic].wrench.force) for topic in cf)
        assert np.linalg.norm(spatial) > 0.1, "the arm carries its weight"
        return np.linalg.norm(body - spatial) < 0.05 * np.linalg.norm(spatial)

    process = start_haptics("--tip-frame")
    robot.subscribe_wrenches("/MTMR_PSM1/following/mtm/body/servo_cf")
    robot.follow()
    robot.until(lambda: robot.sent, "wrenches", 60.0)
    assert not absolute()
    robot.press(1.0)
    assert robot.freed(robot.pedal("camera", 1)) < 2 * MOST
    assert absolute(), "the camera teleoperation controls the MTMs"
    robot.pedal("camera", 0)
    robot.pinch()
    robot.until(lambda: robot.dvrk.last["/MTMR_PSM1/following"].data, "following again", 30.0)
    assert not absolute()
    robot.press(1.5)
    assert abs(robot.felt - robot.push) < FRICTION, "the force is still upwards"
    ended(process)


def test_force_with_our_own_teleoperation(robot, start_haptics):
    robot.dvrk.subscribe("/MTMR_PSM1/current_state")
    process = start_haptics("--teleop", "none")
    robot.subscribe_wrenches("/MTMR/body/servo_cf")
    robot.pedal("operator_present", 1)
    robot.until(lambda: len(robot.sent) > RATE, "a second of wrenches", 60.0)
    hand, tool = robot.position_of("MTMR"), robot.position_of("PSM1")
    robot.press(1.5)
    moved, followed = robot.position_of("MTMR") - hand, robot.position_of("PSM1") - tool
    assert np.linalg.norm(followed - 0.2 * moved) < 2e-3
    assert abs(robot.felt - robot.push) < FRICTION
    assert robot.freed(robot.pedal("operator_present", 0)) < MOST
    ended(process)
    assert robot.push == 0.0
