"""Every row of the table of session states, walked in contact: no step of force or of the tool's goal."""

import math

import numpy as np
import pytest
from crtk_rig import DT, Device, crtk_options
from loop_rig import Q_FOLLOWER
from scipy.spatial.transform import Rotation

from palpate import _core
from palpate.arm import Arm
from palpate.session import machine

IN = 0.034  # handle position below its start [m]; the tool's centre is then 5 mm below the floor
RATE_CAP, FORCE_CAP, RELEASE = 50.0, 3.0, 0.03
READY = {
    "power": True, "home": True, "at_home": True, "follow": True, "aligned": True, "clutch": False, "camera": False,
    "hold": False, "fault": False, "settled": True,
}  # fmt: skip
REST = {
    "off": {"power": False}, "powered": {"home": False}, "homing": {"at_home": False}, "homed": {"follow": False},
    "aligning": {"aligned": False}, "following": {}, "clutched": {"clutch": True}, "camera": {"camera": True},
    "hold": {"hold": True}, "fault": {"fault": True}, "recover": {"settled": False},
}  # fmt: skip
"""Levels, other than `READY`, at which a machine that has come to a state rests in it."""
CAUSE = {
    "power_on": {"power": True}, "power_off": {"power": False}, "home": {"home": True}, "follow": {"follow": True},
    "stop": {"follow": False}, "clutch": {"clutch": True}, "unclutch": {"clutch": False}, "camera": {"camera": True},
    "uncamera": {"camera": False}, "hold": {"hold": True}, "resume": {"hold": False}, "recover": {"fault": False},
    "at_home": {"at_home": True}, "not_home": {"at_home": False}, "aligned": {"aligned": True},
    "fault": {"fault": True}, "settled": {"settled": True},
}  # fmt: skip
ROWS = {row for row in machine.TRANSITIONS if "executing" not in row}
"""The table without planned motions, whose steps tests/session/test_plan_execution.py bounds."""
DWELL = {"recover": 0.04, "settled": 0.09, "aligned": 0.1}
"""Time in a state, or after a cause [s]; 0.05 s in all others. The cycle leaves `recover` by itself after 0.08 s."""


class Walker(Device):
    """A hand that slides over the floor while the levels of the session change."""

    def __init__(self, release=RELEASE):
        o = crtk_options(mapping__align_tolerance=0.1)
        o.release, o.settle, o.stability = release, 0.08, caps(o.stability)
        super().__init__(_core.CrtkCycle(o, Arm.psm("lnd")))
        self.controls, self.levels, self.turned = _core.Controls(), dict(READY), 0.0
        self.state, self.taken, self.quat = "following", set(), self.pose(0.0)[1]
        self.run(0.2)
        self.run(0.4, to=IN)

    def send(self):
        """The handle slides to and fro, and turns by 0.3 rad while it shall not be aligned."""
        goal = 0.0 if self.levels["aligned"] else 0.3
        if goal != self.turned:
            self.turned = float(np.clip(goal, self.turned - 6.0 * DT, self.turned + 6.0 * DT))
            turn = Rotation.from_rotvec([0.0, 0.0, self.turned])
            self.quat = (Rotation.from_matrix(self.X0[:3, :3]) * turn).as_quat()
        p = self.X0[:3, 3] + self.depth * self.down
        p[0] += 0.01 * math.sin(math.pi * self.t)
        self.cycle.leader_pose(self.wall, p, self.quat, self.t, self.wall)

    def take(self, row):
        """Change the levels so that the machine takes a row and rests in its second state."""
        before, cause, after = row
        levels = READY | CAUSE[cause] | REST[after]
        if after == "aligning":  # the handle turns while it is still free
            self.go(self.levels | {"aligned": False}, 0.06)
        assert self.go(levels, DWELL.get(after, DWELL.get(cause, 0.05))) == after, row
        self.state = after
        self.taken.add((before, cause, after))

    def go(self, levels, seconds):
        """Set the levels for some time; returns the state at its end."""
        self.levels, c, g = levels, self.controls, self.gates
        c.power, c.home, c.hold_all = levels["power"], levels["home"], levels["hold"]
        self.cycle.set_controls(c)
        g.leader_enabled = g.follower_enabled = levels["at_home"]
        g.following, g.clutch, g.camera = levels["follow"], levels["clutch"], levels["camera"]
        g.second_writer = levels["fault"]
        return machine.name_of(self.run(seconds)[0]["session_state"])

    def walk(self):
        """Take every row of the table, each next one that is near."""
        left = set(ROWS)
        while left:
            row = min(sorted(left), key=lambda r: len(machine.path(self.state, r[0])))
            for cause in machine.path(self.state, row[0]):
                self.take(next(r for r in ROWS if r[:2] == (self.state, cause)))
            self.take(row)
            left -= self.taken
        return self


def caps(stability):
    stability.force_cap, stability.rate_cap, stability.passivity = FORCE_CAP, RATE_CAP, "off"
    return stability


def jumps(walker, forces=None, goals=None):
    """Largest step in a tick over the largest allowed one: of the commanded force, and of the tool's goal.

    A force grows and turns at the rate cap, and falls at the same rate or to zero within `RELEASE`.
    """
    F = np.array([np.zeros(3) if one is None else one[:3] for one in walker.F]) if forces is None else forces
    p = walker.ticks["p_WT_goal"] if goals is None else goals
    steepest = max(RATE_CAP, FORCE_CAP / RELEASE) * DT
    return (
        float(np.linalg.norm(np.diff(F, axis=0), axis=1).max() / steepest),
        float(np.linalg.norm(np.diff(p, axis=0), axis=1).max() / (0.05 * DT)),
    )


@pytest.fixture(scope="module")
def walked():
    return Walker().walk()


def test_no_transition_of_the_table_makes_a_step_of_force_or_goal(walked):
    assert walked.taken == ROWS
    force, goal = jumps(walked)
    assert force <= 1.0 + 1e-6
    assert goal <= 1.0
    ticks, F = walked.ticks, walked.forces
    state = ticks["session_state"]
    changes = np.flatnonzero(np.diff(state)) + 1
    assert len(changes) >= len(ROWS)
    following = state == machine.NAMES.index("following")
    left = [k for k in changes if following[k - 1]]
    assert np.mean([F[k - 1] > 0.5 for k in left]) > 0.9, "the hand feels the floor when it stops to follow"
    late = np.convolve(following, np.ones(round(RELEASE / DT) + 2))[: len(following)] == 0
    assert not F[late].any(), "no force outside of following, after its ramp"
    held = ~following[1:] & ~following[:-1]
    rest = np.linalg.norm(np.diff(ticks["p_WT_goal"], axis=0)[held], axis=1)
    assert rest.max() < 2e-7, "outside of following the goal rests, or changes to the pose that the tool has reached"


def test_a_planted_step_is_noticed(walked):
    rough = Walker(release=1e-9)
    rough.take(("following", "clutch", "clutched"))
    force, goal = jumps(rough)
    assert force > 2.0, "a force that is switched off at once"
    assert goal <= 1.0
    goals = walked.ticks["p_WT_goal"].copy()
    goals[3000:] += [1e-4, 0.0, 0.0]
    assert jumps(walked, goals=goals)[1] > 1.0, "a goal that is anchored 0.1 mm beside"
    forces = np.array([np.zeros(3) if one is None else one[:3] for one in walked.F])
    forces[3000:] += [0.2, 0.0, 0.0]
    assert jumps(walked, forces=forces)[0] > 1.0


class Followed(Device):
    """A real follower, which is where it was sent, or where somebody else moves it."""

    def __init__(self):
        o = crtk_options(virtual_follower=False, own_teleop=True)
        super().__init__(_core.CrtkCycle(o, Arm.psm("lnd")))
        self.X_BT, self.moved, self.goal = Arm.psm("lnd").fk(Q_FOLLOWER), np.zeros(3), None

    def send(self):
        super().send()
        quat = Rotation.from_matrix(self.X_BT[:3, :3]).as_quat()
        self.cycle.follower_pose(self.wall, self.X_BT[:3, 3] + self.moved, quat, self.t, self.wall)

    def _step(self):
        row, F, goal, jaw = super()._step()
        if goal is not None:
            self.X_BT, self.moved, self.goal = goal, np.zeros(3), goal[:3, 3]
        return row, F, goal, jaw

    def push(self, p, seconds):
        """Somebody moves the follower by p (3,) [m] in this time; returns the commanded goals (n, 3)."""
        n = round(seconds / DT)
        for k in range(n):
            self.moved = p * (k + 1) / n
            self.run(DT)
        return self.X_BT[:3, 3] + self.moved


@pytest.mark.parametrize(("gate", "metres"), [("leader_enabled", 0.015), ("operator_present", 0.008)])
def test_a_follower_that_others_have_moved_starts_where_it_is(gate, metres):
    device = Followed()
    device.run(0.3, to=0.004)
    assert device.goal is not None
    setattr(device.gates, gate, False)  # the arms home, or nobody is at the console
    device.run(0.1)
    where = device.push(np.array([metres, 0.0, 0.0]), 0.8)
    device.goal = None
    setattr(device.gates, gate, True)
    while device.goal is None:
        device.run(DT)
    np.testing.assert_allclose(device.goal, where, atol=1e-6)


def test_a_pedal_pressed_in_motion_leaves_the_goal_where_it_was_sent():
    device = Followed()
    device.run(0.3, to=0.004)
    last = device.goal
    device.gates.clutch = True
    device.moved = np.array([0.005, 0.0, 0.0])  # the lag of a servo, which then arrives
    device.run(0.05)
    device.push(np.array([0.0005, 0.0, 0.0]), 0.6)
    device.gates.clutch, device.goal = False, None
    device.run(2 * DT)
    np.testing.assert_allclose(device.goal, last, atol=1e-9)
