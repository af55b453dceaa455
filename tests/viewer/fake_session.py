"""A mock session for the viewer: a tool above a floor with a contact force, and a hand that can be dragged."""

import copy
import time
from types import SimpleNamespace

import numpy as np

from palpate.arm import Arm
from palpate.record.ticks import TICK
from palpate.viewer.stage import ArmPlace, Stage, TouchedObject
from palpate.world.shapes.organs import organ


def pose(p, R=None):
    X = np.eye(4)
    X[:3, 3] = p
    if R is not None:
        X[:3, :3] = R
    return X


def turn(degrees):
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


X_WL, X_WB = pose([0.293, 0.226, 0.130], turn(-15.0)), pose([-0.11, 0.003, 0.151], turn(215.0))
Q_LEADER = np.radians([0.0, 8.6, 5.7, -25.2, 59.0, -25.5, -0.3])
Q_FOLLOWER = np.array([-0.466, -0.44, 0.1364, -1.897, 0.0, 0.0])
LEADER = Arm.mtm("right")
P_FLOOR, K, SCALE = 0.046, 400.0, 0.5
P_TOOL, P_HAND_L = np.array([-0.035, -0.012, 0.052]), LEADER.fk(Q_LEADER)[:3, 3]


def stage():
    vertices, triangles = organ(6000)
    return Stage(
        title="Palpation",
        objects=[TouchedObject("liver", vertices, triangles, np.eye(4))],
        leader=ArmPlace("leader", LEADER, X_WL),
        follower=ArmPlace("follower", Arm.psm("lnd"), X_WB),
        radius=0.002,
        stiffness=K,
        damping=2.0,
        force_cap=3.0,
        motion_scale=SCALE,
        focus=np.array([0.09, 0.0, 0.05]),
    )


class FakeSession:
    def __init__(self):
        self._controls = SimpleNamespace(
            following=True, clutch=False, paused=False, hold=False, stiffness_scale=1.0, damping_scale=1.0,
            p_hand_offset_W=np.zeros(3),
        )  # fmt: skip
        self._t0 = time.monotonic()

    @property
    def controls(self):
        return copy.copy(self._controls)

    @controls.setter
    def controls(self, value):
        self._controls = value

    def start(self):
        pass

    def stop(self):
        pass

    def latest(self):
        c, tick = self._controls, np.zeros((), dtype=TICK)
        offset = np.array(c.p_hand_offset_W)
        p_WT = P_TOOL + (0.0 if c.clutch else SCALE) * offset
        depth = max(0.0, P_FLOOR - p_WT[2] + 0.002)
        force = np.array([0.0, 0.0, K * c.stiffness_scale * depth])
        tick["t"] = time.monotonic() - self._t0
        tick["status"] = (1 << 7) * c.clutch
        tick["p_LH"] = tick["p_hand_L"] = P_HAND_L + offset
        tick["q_follower"][: len(Q_FOLLOWER)], tick["q"] = Q_FOLLOWER, Q_LEADER
        tick["gripper"] = tick["jaw"] = 0.35
        tick["p_WT"], tick["p_WP"] = p_WT, p_WT + np.array([0.0, 0.0, depth])
        tick["depth"], tick["delta_x"], tick["contacts"] = depth, [0, 0, depth], depth > 0
        tick["F_H_L"], tick["F_H_H"] = force, force[[2, 1, 0]]
        tick["cycle_us"] = 5.0
        return tick
