"""Guidance fixtures for the tests of roles, laws, policies and the guidance stage."""

from __future__ import annotations

import numpy as np

from palpate import _core, _guidance

DT = 1e-3
RESERVE = _core.GuidanceOptions().reserve
LINE = _guidance.LineGeometry(np.zeros(3), np.array([0.1, 0.0, 0.0]), True)


def pose(p=(0.0, 0.0, 0.0), R=None):
    X = np.eye(4)
    X[:3, 3] = p
    if R is not None:
        X[:3, :3] = R
    return X


def point_at_height(z, x=0.0):
    """The point (x, 0, z) [m]."""
    return np.array([x, 0.0, z])


def placed(geometry, X=None, motion=None):
    frame = _core.MotionFrame(np.eye(4), motion or _core.Motion())
    return _guidance.PlacedGeometry(geometry, np.eye(4) if X is None else X, frame)


def plane(X=None, motion=None):
    """A half-space; its inside is z < 0 in the frame X."""
    return placed(_guidance.SurfaceGeometry(_core.Plane()), X, motion)


def sphere(radius=0.03, X=None, motion=None):
    return placed(_guidance.SurfaceGeometry(_core.Sphere(radius)), X, motion)


def filled(options, values):
    for name, value in values.items():
        setattr(options, name, value)
    return options


def fixture(geometry, role="forbid", law="spring", name="one", on=True, role_=None, law_=None, **policy):
    """A fixture. role_, law_: options by name; other keywords are fields of the policy, or `timeout` [s]."""
    timeout = policy.pop("timeout", np.inf)
    return _guidance.Fixture(
        name,
        geometry,
        role,
        filled(_core.GuidanceRoleOptions(), role_ or {}),
        law,
        filled(_core.GuidanceLawOptions(), law_ or {}),
        filled(_core.Policy(), policy),
        on,
        timeout,
    )


class Stage:
    """The guidance stage alone; the tool is at its goal, or follows it by a servo of `bandwidth` [Hz]."""

    def __init__(self, *fixtures, bandwidth=0.0, **options):
        self.core = _guidance.Guidance(filled(_core.GuidanceOptions(), {"servo_bandwidth": bandwidth} | options), DT)
        self.k, self.X, self.X_tool, self.v = 0, None, None, np.zeros(3)
        self.w = 2 * np.pi * bandwidth
        self.set_fixtures(*fixtures)

    def set_fixtures(self, *fixtures):
        self.core.take(_guidance.Fixtures(list(fixtures)))

    def step(self, X, **more):
        """One tick with the commanded tool pose or position X; returns the outputs of the stage."""
        X = pose(X) if np.shape(X) == (3,) else X
        V = more.pop("V") if "V" in more else self._twist(X)
        if self.X_tool is None:
            self.X_tool = X.copy()
        out = self.core.step(self.k * DT, X, V, self.X_tool, **more)
        self.X, self.k = X, self.k + 1
        self._follow(out["X_WT_goal"])
        return out

    def _twist(self, X):
        """Velocity from the previous pose to X in one tick (6,)."""
        V = np.zeros(6)
        if self.X is not None and self.X is not X:
            V[:3] = (X[:3, 3] - self.X[:3, 3]) / DT
            if not np.array_equal(X[:3, :3], self.X[:3, :3]):
                V[3:] = _turn(self.X[:3, :3], X[:3, :3]) / DT
        return V

    def _follow(self, goal):
        """Exact step of a critically damped servo."""
        if not self.w:
            self.X_tool = goal.copy()
            return
        e, w = self.X_tool[:3, 3] - goal[:3, 3], self.w
        c = self.v + w * e
        decay = np.exp(-w * DT)
        self.X_tool = goal.copy()
        self.X_tool[:3, 3] = goal[:3, 3] + (e + c * DT) * decay
        self.v = (self.v - w * c * DT) * decay

    def settle(self, X, ticks=400, **more):
        X = pose(X) if np.shape(X) == (3,) else X
        for _ in range(ticks):
            out = self.step(X, **more)
        return out


def _turn(R_a, R_b):
    from scipy.spatial.transform import Rotation

    return Rotation.from_matrix(R_b @ R_a.T).as_rotvec()
