"""The simulated dVRK and a session agree on their states, though each has a state machine of its own.

The session's machine reads what the arms and the console report; the state of the dVRK is derived from the names of its
own phases. Both are compared every 10 ms.
"""

import pytest

from palpate import _core
from palpate.session import machine

PERIOD = 0.01  # [s]
LATE = 2  # periods for which one of them may be ahead: the events of the dVRK arrive one period later


class Both:
    """The robot and the session's machine, with their common levels."""

    def __init__(self, robot):
        self.robot = robot("MTMR", "PSM1")
        self.machine = _core.SessionMachine()
        self.pedals = {"enabled": False, "present": False, "clutch": False, "camera": False, "hold": False}
        self.seen, self.apart = [], 0

    def send(self, *words):
        self.robot.send(*words)
        return self

    def arms(self):
        return [self.robot.state(name) for name in ("MTMR", "PSM1")]

    def dvrk(self):
        """State by the names of the dVRK's own phases."""
        states, teleop = {arm["state"] for arm in self.arms()}, self.robot.teleop("MTMR_PSM1")
        if "FAULT" in states:
            return "fault"
        if "DISABLED" in states:
            return "off"
        if "PAUSED" in states:
            return "hold"
        if not all(arm["is_homed"] and not arm["is_busy"] for arm in self.arms()):
            return "homing" if any(arm["is_busy"] for arm in self.arms()) else "powered"
        if not (self.pedals["enabled"] and self.pedals["present"]):
            return "homed"
        if self.pedals["camera"]:
            return "camera"
        if self.pedals["clutch"]:
            return "clutched"
        return "following" if teleop["following"] else "aligning"

    def levels(self):
        now, states = _core.SessionInput(), [arm["state"] for arm in self.arms()]
        now.power = "DISABLED" not in states
        now.home = any(arm["is_busy"] or arm["is_homed"] for arm in self.arms())
        now.at_home = all(arm["is_homed"] and not arm["is_busy"] for arm in self.arms())
        now.follow = self.pedals["enabled"] and self.pedals["present"]
        now.aligned = self.robot.teleop("MTMR_PSM1")["current_state"] == "ENABLED"
        now.clutch, now.camera = self.pedals["clutch"], self.pedals["camera"]
        now.hold = "PAUSED" in states
        now.fault = "FAULT" in states
        return now

    def run(self, seconds):
        for _ in range(round(seconds / PERIOD)):
            self.robot.run(PERIOD)
            ours, theirs = self.machine.step(self.levels()), self.dvrk()
            self.apart = 0 if ours == theirs else self.apart + 1
            assert self.apart <= LATE, (ours, theirs)
            if self.apart == 0 and self.seen[-1:] != [ours]:
                self.seen.append(ours)
        return self

    def pedal(self, name, topic, down):
        self.pedals[name] = bool(down)
        return self.send("console", topic, down)

    def follow(self):
        """Home, enable, take the handle and pinch."""
        for arm in ("MTMR", "PSM1"):
            self.send(arm, "state_command", "home")
        self.run(8.0)
        self.pedal("enabled", "teleop/enable", True).pedal("present", "emulate_operator_present", 1).run(3.0)
        self.send("MTMR", "hand/servo_cp", self.robot.state("MTMR")["measured_cp"])
        for pinch in (1.0, 0.1, 0.5):
            self.send("MTMR", "hand/gripper", pinch).run(0.05)
        return self


@pytest.fixture
def both(robot):
    return Both(robot)


def test_from_off_to_following_clutch_camera_and_away(both):
    both.follow()
    first_seen = [state for state in machine.NAMES if state in both.seen]  # the arms engage a tool in between: homing
    assert first_seen == sorted(first_seen, key=both.seen.index)
    assert {"off", "homing", "homed", "aligning", "following"} <= set(both.seen) <= {*machine.NAMES[:6]}
    assert both.seen[-1] == "following"
    both.seen.clear()
    both.pedal("clutch", "emulate_clutch", 1).run(0.2).pedal("clutch", "emulate_clutch", 0).run(0.3)
    assert both.seen[0] == "clutched"
    assert both.seen[-1] == "following"
    both.seen.clear()
    both.pedal("camera", "emulate_camera", 1).run(0.2)
    assert both.seen == ["camera"]
    both.pedal("camera", "emulate_camera", 0).run(0.5)
    both.pedal("present", "emulate_operator_present", 0).run(0.3)
    assert both.seen[-1] == "homed"


def test_hold_fault_and_the_way_out(both):
    both.follow()
    both.send("MTMR", "state_command", "pause").run(0.3)
    assert both.machine.state == both.dvrk() == "hold"
    both.send("MTMR", "state_command", "resume").run(0.5)
    both.send("MTMR", "hand/free", True).send("PSM1", "emulate_fault", "of a test").run(0.3)
    assert both.machine.state == both.dvrk() == "fault"
    with pytest.raises(machine.StateError):
        machine.require(both.machine.state, "home")
    assert "power_off" in machine.legal("fault")
    for arm in ("MTMR", "PSM1"):
        both.send(arm, "state_command", "disable")
    both.run(0.2)
    assert both.machine.state == both.dvrk() == "off"
    for arm in ("MTMR", "PSM1"):
        both.send(arm, "state_command", "home")
    both.run(8.0)
    assert both.machine.state == both.dvrk()
    assert both.machine.state in ("homed", "aligning", "following")


def test_a_disagreement_is_noticed(both):
    both.dvrk = lambda: "following"
    with pytest.raises(AssertionError, match="off"):
        both.run(0.1)
