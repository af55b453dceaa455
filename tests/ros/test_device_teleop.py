"""A Haply drives a simulated PSM through a teleoperation in the manner of the dVRK's own script, which knows no device
of ours: it enables and homes both arms, copies motions, and commands the master's force by `body/servo_cf`.

Real processes: a stand-in of the vendor's service, `palpate ros device` and `palpate ros sim`.
"""

import time

import numpy as np
import pytest
from crtk_client import Script

pytest.importorskip("websockets", reason="the stand-in needs the extra haply")

from scipy.spatial.transform import Rotation

from palpate.devices.haply.messages import Grip
from palpate.devices.haply.stand_in import Options, StandIn

TURN = Rotation.from_euler("xyz", [40, -30, 70], degrees=True)
"""The grip's orientation: a force in the axes of the tip would be another one in those of the base."""
SCALE, PUSH = 0.3, np.array([0.0, 0.0, 1.2])  # [-]; upwards, on the master [N]


@pytest.fixture(scope="module")
def service():
    with StandIn(0, Options(grip=Grip(orientation=tuple(TURN.as_quat())), idle_after=5.0)) as made:
        yield made


@pytest.fixture(scope="module")
def robot(start_sim):
    return start_sim("PSM1")


@pytest.fixture
def device(start, robot, service):
    url = f"url=ws://127.0.0.1:{service.port}"
    return start("-m", "palpate", "ros", "device", f"haply:{url},rate=200", "--arm", "MTMR")


@pytest.fixture
def script(rclpy):
    with Script(rclpy, "teleoperation") as made:
        yield made


def arms(script):
    mtm = script.arm("MTMR").use(
        "operating_state", "measured_cp", "measured_cv", "setpoint_cp", "gripper/measured_js", "state_command",
        "body/servo_cf", "body/set_cf_orientation_absolute", "use_gravity_compensation", "hold",
    )  # fmt: skip
    psm = script.arm("PSM1").use("operating_state", "setpoint_cp", "measured_cp", "servo_cp", "state_command")
    script.spin()
    return mtm, psm


def follow(mtm, psm, seconds, force=None):
    """Teleoperate at 100 Hz; motions of the master and of the instrument's set point since the start, (n, 3) each [m].

    force: on the master in the axes of its base [N]; None: none is sent.
    """
    from geometry_msgs.msg import PoseStamped, WrenchStamped

    def p(message):
        return np.array([message.pose.position.x, message.pose.position.y, message.pose.position.z])

    m0, goal, end, moved = p(mtm.read("setpoint_cp", 5.0)), PoseStamped(), time.monotonic() + seconds, []
    start = psm.read("setpoint_cp", 5.0)
    goal.pose.orientation, p0 = start.pose.orientation, p(start)
    wrench = WrenchStamped()
    while time.monotonic() < end:
        motion = p(mtm.script.last["/MTMR/measured_cp"]) - m0
        at = goal.pose.position
        at.x, at.y, at.z = (p0 + SCALE * motion).tolist()
        psm.send("servo_cp", goal)
        if force is not None:
            f = wrench.wrench.force
            f.x, f.y, f.z = force.tolist()
            mtm.send("body/servo_cf", wrench)
        moved.append((motion, p(psm.script.last["/PSM1/setpoint_cp"]) - p0))
        time.sleep(0.01)
    return (np.array(one) for one in zip(*moved, strict=True))


def test_the_instrument_follows_and_the_force_comes_in_the_axes_of_the_base(device, script, service):
    mtm, psm = arms(script)
    mtm.send("body/set_cf_orientation_absolute", data=True)  # latched, and before the device is found
    for arm in (mtm, psm):
        arm.enable(30.0)
        arm.home(30.0)
    master, instrument = follow(mtm, psm, 4.0, PUSH)
    end = time.monotonic()
    assert np.ptp(master[:, 2]) > 0.03, "the stand-in's hand moves"
    lag = 10  # 0.1 s, in which the hand moves by up to 5 mm
    best = min(np.abs(instrument[lag:] - SCALE * master[lag - k : len(master) - k]).max() for k in range(lag))
    assert best < 0.005 * SCALE
    time.sleep(0.3)
    felt = np.array([F for t, F in list(service.log) if end - 1.0 < t < end])
    assert felt[len(felt) // 2] == pytest.approx(PUSH, abs=1e-5)
    assert not service.log[-1][1].any(), "stale"
    assert max(t for t, F in list(service.log) if F.any()) < end + 0.1
    assert mtm.read("gripper/measured_js").position[0] == 0.5
    speed = mtm.read("measured_cv").twist.linear
    assert 1e-4 < np.linalg.norm([speed.x, speed.y, speed.z]) < 0.3


def test_a_disabled_master_gets_no_force_until_it_is_enabled_and_hold_ends_one(device, script, service):
    mtm, psm = arms(script)
    mtm.enable(30.0)
    psm.enable(30.0)
    psm.home(30.0)
    mtm.command("disable", lambda s: s.state == "DISABLED", 10.0)
    begin = time.monotonic()
    follow(mtm, psm, 0.5, PUSH)
    assert not any(F.any() for t, F in list(service.log) if t > begin)
    mtm.enable(10.0)
    follow(mtm, psm, 0.5, PUSH)
    assert any(F.any() for t, F in list(service.log) if t > begin)
    mtm.send("hold")


def test_an_unplugged_device_ends_with_zero_and_in_words(device, script, service):
    mtm, psm = arms(script)
    mtm.enable(30.0)
    follow(mtm, psm, 0.5, PUSH)
    begin = service.fail("unplug")
    try:
        assert device.wait(20.0) == 1
    finally:
        service.mend("unplug")
    assert not any(F.any() for t, F in list(service.log) if t > begin + 0.1)
    assert mtm.script.last["/MTMR/operating_state"].state == "FAULT"
    assert "vanished" in device.stdout.read() + device.stderr.read()
