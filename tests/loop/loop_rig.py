"""A rig for the loop: the real arms over a flat floor at z = 0, handle and tool aligned at the start."""

from __future__ import annotations

import numpy as np

from palpate import _core
from palpate.arm import Arm
from palpate.record.ticks import as_ticks

Q_LEADER = np.array([0.0, 0.0, 0.0, 0.0, np.pi / 2, 0.0, 0.0])
Q_FOLLOWER = np.array([0.0, 0.0, 0.12, 0.0, 0.0, 0.0])
HEIGHT = 0.012  # height of the tool above the floor at the start [m]
CLUTCHED, NOT_FOLLOWING, IK_FAILED = 128, 256, 64


def floor(K=(400.0,) * 3, B=(0.0,) * 3, mu=0.0, half=0.1):
    """A closed block whose top is the plane z = 0."""
    corners = np.array([[x, y, z] for z in (-0.05, 0.0) for y in (-half, half) for x in (-half, half)])
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    triangles = np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))], np.int32)
    material = _core.Material(K=np.array(K, float), B=np.array(B, float), mu=mu)
    return _core.Snapshot([_core.Object("floor", _core.Mesh(corners, triangles), np.eye(4), material)])


def press_path(depth=0.006, slide=0.02):
    """The intended path of the tool: approach, press, slide and retract."""
    z = [HEIGHT, -depth, -depth, -depth, HEIGHT]
    x = [0, 0, 0, slide, slide]
    return _core.HandPath([0.1, 0.8, 1.2, 2.2, 2.8], np.column_stack([x, np.zeros(5), z]))


def options(**changes):
    o = _core.SimulationOptions()
    leader, follower = Arm.mtm("right"), Arm.psm("lnd")
    o.leader, o.follower = leader.leader_options(), follower.follower_options()
    o.q_leader0, o.q_follower0 = Q_LEADER, Q_FOLLOWER
    X_WB = np.eye(4)
    X_WB[2, 3] = HEIGHT - follower.fk(Q_FOLLOWER)[2, 3]
    X_WL = np.eye(4)
    X_WL[:3, :3] = follower.fk(Q_FOLLOWER)[:3, :3] @ leader.fk(Q_LEADER)[:3, :3].T
    o.X_WB, o.X_WL = X_WB, X_WL
    for name, value in changes.items():
        target = o
        *path, last = name.split("__")
        for part in path:
            target = getattr(target, part)
        setattr(target, last, value)
    return o


def simulation(scene=None, path=None, leader=None, **changes):
    leader = leader or Arm.mtm("right")
    return _core.Simulation(options(**changes), leader, leader, Arm.psm("lnd"), scene or floor(), path or press_path())


def run(sim, seconds, rate=1000):
    return as_ticks(sim.run(round(seconds * rate)))
