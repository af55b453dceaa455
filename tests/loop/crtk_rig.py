"""A CRTK leader that only sends messages, above the rig's floor; the tool is virtual by default."""

import numpy as np
from loop_rig import Q_FOLLOWER, Q_LEADER, floor, options
from scipy.spatial.transform import Rotation

from palpate import _core
from palpate.arm import Arm
from palpate.record.ticks import STATUS, as_ticks

DT = 1e-3
WALL0 = 1.7e9  # system clock at t = 0 [s]
BIT = {name: bit for name, (bit, _) in STATUS.items()}
IN = 0.034  # handle position below its start [m]; the tool's centre is then 5 mm below the floor
RATE_CAP, FORCE_CAP = 50.0, 3.0


def crtk_options(**changes):
    o = options(**{name: changes.pop(name) for name in list(changes) if "__" in name})
    made = _core.CrtkOptions(o, Q_FOLLOWER)
    made.virtual_follower = True
    stability = made.stability
    for name, value in changes.items():
        target = made
        if name in ("force_cap", "rate_cap", "moment_cap", "passivity"):
            target = stability
        setattr(target, name, value)
    made.stability = stability
    return made


class Device:
    """Sends the messages of a leader at 1 kHz and steps the cycle; every step is one row."""

    def __init__(self, cycle=None, scene=None, **changes):
        self.options = crtk_options(**changes)
        self.cycle = cycle or _core.CrtkCycle(self.options, Arm.psm("lnd"))
        self.scene = floor() if scene is None else scene
        if self.scene:  # False: no scene
            self.cycle.set_scene(self.scene)
        self.gates = _core.CrtkGates()
        for name in ("following", "operator_present", "leader_enabled", "follower_enabled"):
            setattr(self.gates, name, True)
        self.X0 = Arm.mtm("right").fk(Q_LEADER)
        self.quat0 = Rotation.from_matrix(self.X0[:3, :3]).as_quat()
        self.down = options().X_WL[:3, :3].T @ np.array([0.0, 0.0, -1.0])  # downwards, in the leader's frame
        self.t, self.skew, self.depth, self.rows, self.F = 0.0, 0.0, 0.0, [], []
        self.silent = False

    @property
    def wall(self):
        return WALL0 + self.t

    def pose(self, depth):
        """Pose of the handle `depth` [m] below its start: position [m], quaternion x y z w."""
        return self.X0[:3, 3] + depth * self.down, self.quat0

    def send(self, stamp=None, p=None, quat=None):
        at, turn = self.pose(self.depth)
        stamp = self.wall + self.skew if stamp is None else stamp
        self.cycle.leader_pose(stamp, at if p is None else p, turn if quat is None else quat, self.t, self.wall)

    def step(self):
        row, *rest = self._step()
        return as_ticks(row.reshape(1, -1))[0], *rest

    def _step(self):
        self.cycle.set_gates(self.gates)
        row, F, goal, jaw = self.cycle.step(self.t, self.wall)
        self.rows.append(row)
        self.F.append(F)
        return row, F, goal, jaw

    def run(self, seconds, to=None, message=None):
        """Run while the handle moves to `to` [m] below its start; `message(self)` replaces the valid message."""
        n = round(seconds / DT)
        depths = np.linspace(self.depth, self.depth if to is None else to, n + 1)[1:]
        for depth in depths:
            self.t += DT
            self.depth = depth
            if message is not None:
                message(self)
            elif not self.silent:
                self.send()
            row, *rest = self._step()
        return as_ticks(row.reshape(1, -1))[0], *rest

    @property
    def ticks(self):
        return as_ticks(np.array(self.rows))

    @property
    def forces(self):
        """Magnitude of the commanded force (n,) [N]; zero if nothing was sent."""
        return np.array([0.0 if F is None else np.linalg.norm(F[:3]) for F in self.F])


def pressed(**changes):
    device = Device(**changes)
    device.run(0.2)
    device.run(0.5, to=IN)
    device.run(0.3)
    assert device.forces[-1] > 1.0
    return device


def silent(d):
    pass


def nan(d):
    d.send(p=np.array([np.nan, 0, 0]))


def assert_zero_soon_without_a_step_back(device, from_row, within=0.05):
    """Check that the force is zero `within` [s] after a row, and that it grows below the rate cap."""
    forces = device.forces
    assert not forces[from_row + round(within / DT) : from_row + round(within / DT) + 50].any()
    vectors = np.array([np.zeros(6) if F is None else F for F in device.F])
    assert (np.diff(forces) <= RATE_CAP * DT * 1.5 + 1e-9).all()
    assert np.isfinite(vectors).all()


GATES = {
    "following": ("following", False, "not_following"),
    "clutch": ("clutch", True, "clutched"),
    "arm_in_fault": ("leader_enabled", False, "not_enabled"),
    "second_writer": ("second_writer", True, "second_writer"),
    "other_teleop": ("other_teleop", True, "other_teleop"),
    "guarded": ("guarded", True, "guarded"),
    "frame_unsure": ("frame_unsure", True, "frame_unsure"),
    "two_sources": ("two_sources", True, "two_sources"),
    "no_listener": ("no_listener", True, "no_listener"),
    "base_moved": ("base_moved", True, "base_moved"),
}
