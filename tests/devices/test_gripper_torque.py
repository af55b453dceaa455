"""Torque of the gripper on the fingers: drivers with `grip`, palpate.Haptics; bounded, and zero in a fault."""

import drivers
import numpy as np
import pytest
from test_haptics import pose

import palpate
from palpate.base.errors import DeviceError, PalpateWarning
from palpate.devices import Reading
from palpate.devices.driven import DrivenLoop
from palpate.devices.driver import facts

CAP = 0.004  # [N m]


def pinching(torque=CAP):
    """The jaws stand open on the plane z = 0, their tips in it when the hand moves down by 2 mm."""
    return palpate.Scene.model_validate(
        {
            "objects": [{"name": "floor", "plane": {}, "stiffness": 400.0, "damping": 0.0}],
            "arms": {"leader": {"driver": "loop", "gripper": {"torque": torque}}, "follower": {"jaw": {"start": 0.8}}},
            "contact": {"whole_tool": True},
            "mapping": {"scale": 1.0},
            "stability": {"passivity": "off"},
            "operator": {"path": [{"t": 0.0, "xyz": [0.0, 0.0, 0.0103]}, {"t": 1.0, "xyz": [0.0, 0.0, 0.0103]}]},
        }
    )


def test_fingers_feel_the_jaws_within_the_cap_and_nothing_in_a_fault():
    with palpate.Haptics(pinching()) as haptics:
        felt = []
        for i in range(600):
            haptics.step(0.001 * (i + 1), pose(z=-0.004 * min(1.0, i / 300)), gripper=0.8)
            felt.append(haptics.gripper_torque)
        felt = np.array(felt)
        assert felt[0] == 0.0
        assert 1e-4 < felt[-1] <= CAP, "the floor opens the jaws, and so the fingers"
        assert np.abs(np.diff(felt)).max() <= CAP * 1e-3 / 0.05 * (1 + 1e-9)
        haptics.step(0.601, np.full((4, 4), np.nan))
        assert haptics.gripper_torque == 0.0


class Gripping(drivers.Still):
    """A device with a motor in its gripper; keeps the torques."""

    gripper_max = 0.002

    def __init__(self):
        super().__init__()
        self.torques = []

    def read(self):
        return Reading(self.pose(), None, 0.8, 0)

    def grip(self, torque):
        self.torques.append(torque)


def test_driver_with_a_motor_gets_the_torque_up_to_its_own_limit():
    loop = DrivenLoop(pinching(), driver := Gripping(), "mine")
    assert loop.rig.scene.arms.leader.gripper.torque == 0.002
    loop.start()
    loop.stop()
    assert driver.torques, "grip is called after write"
    assert driver.torques[-1] == 0.0
    assert all(np.isfinite(driver.torques))


def test_driver_without_a_motor_is_told_so():
    with pytest.warns(PalpateWarning, match="gripper of mine has no motor"):
        DrivenLoop(pinching(), drivers.Still(), "mine")


def test_driver_that_promises_a_motor_needs_grip():
    class Wrong:
        rate, force_max, workspace, gripper_max = 1000.0, 1.0, (0.1, 0.1, 0.1), 0.01
        open = read = write = close = print

    with pytest.raises(DeviceError, match="no function grip"):
        facts(Wrong(), "mine")
