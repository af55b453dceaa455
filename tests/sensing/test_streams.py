"""Streams of clouds in a loop: the force against the true moving surface, and the faults of cameras."""

import time

import numpy as np
import pytest

from palpate import Haptics, Scene, Session
from palpate.base.errors import SceneError
from palpate.devices.loop import DeviceLoop, device_scene
from palpate.record.ticks import as_ticks
from palpate.sensing import CloudFrame
from palpate.sensing.gate import Gate
from palpate.sensing.motion import SurfaceMotion
from palpate.sensing.patch import patch
from palpate.sensing.sensing import Sensing

SCENE = """
objects:
  - name: organ
    cloud: {sensor: camera, region: 0.04}
    stiffness: 1000
contact: {radius: 0.003}
arms: {follower: {start: {xyz: [0, 0, 0], rpy_deg: [180, 0, 0]}}}
operator: {path: [{t: 0, xyz: [0, 0, 0]}, {t: 1, xyz: [0, 0, 0]}]}
"""
X_WC = np.array([[1.0, 0, 0, 0], [0, -1.0, 0, 0], [0, 0, -1.0, 0.5], [0, 0, 0, 1.0]])


class Paraboloid:
    """A camera above a paraboloid whose top moves along z; frames arrive 10 ms after their stamp."""

    def __init__(self, height, points=8000, noise=0.3e-3, until=np.inf):
        self.height, self.until, self.noise, self.k = height, until, noise, 0
        self.rng = np.random.default_rng(0)
        self.points = points

    def latest(self, now):
        t = self.k / 30.0
        if now < t + 0.01 or t > self.until:
            return None
        self.k += 1
        xy = self.rng.uniform(-0.05, 0.05, (self.points, 2))
        p = np.c_[xy, self.height(t) - (xy**2).sum(axis=1) / 0.12] + self.noise * self.rng.normal(size=(self.points, 3))
        return CloudFrame((p - X_WC[:3, 3]) @ X_WC[:3, :3], t, X_WC)

    def close(self):
        pass


def felt(source, seconds, extrapolate=True):
    """Times, spring force along z, share of the force and the sensing of a tool that rests at the origin."""
    loop = DeviceLoop(device_scene(Scene.parse(SCENE), "loop"))
    sensing = Sensing(loop.rig, loop, {"camera": source}, extrapolate=extrapolate)
    t, force, share = [], [], []
    for k in range(round(1000 * seconds)):
        loop.step(1e-3 * k, np.eye(4), None, 0.0, 0)
        tick = as_ticks(np.asarray(loop.latest()).reshape(1, -1))[0]
        t.append(float(tick["t"]))
        force.append(float(tick["F_spring_W"][2]))
        share.append(float(tick["live_share"][0]))
        if k % 5 == 0:
            sensing.step(float(tick["t"]))
    return np.array(t), np.array(force), np.array(share), sensing


def test_a_resting_tool_feels_the_surface_at_its_true_depth():
    t, force, _, _ = felt(Paraboloid(lambda t: 0.001), 0.4)
    assert force[t > 0.15] == pytest.approx(4.0, rel=0.05)


def test_velocity_between_frames_follows_a_surface_that_rises():
    def height(t):
        return -0.008 + 0.1 * np.clip(np.asarray(t) - 0.2, 0.0, 0.11)

    worst = {}
    for extrapolate in (True, False):
        t, force, _, _ = felt(Paraboloid(height), 0.5, extrapolate)
        moving = (t > 0.29) & (t < 0.31)
        worst[extrapolate] = np.abs(force - 1000.0 * (0.003 + height(t)).clip(0.0))[moving].max()
        assert force[t > 0.42] == pytest.approx(6.0, rel=0.1)
    assert worst[True] < 0.5 * worst[False]


def test_a_jump_of_five_millimetres_is_not_passed_through():
    t, force, _, _ = felt(Paraboloid(lambda t: 0.0005 if t < 0.2 else 0.0055), 0.4)
    assert (force[t > 0.15] > 0.0).all()
    assert force[t > 0.35] == pytest.approx(8.5, rel=0.1)


def test_a_camera_that_falls_silent_makes_the_surface_stale_and_fades_its_force():
    t, force, share, sensing = felt(Paraboloid(lambda t: 0.001, until=0.15), 1.2)
    assert share[(t > 0.2) & (t < 0.4)] == pytest.approx(1.0)
    assert share[-1] == 0.0
    assert force[-1] == 0.0
    assert "stale" in sensing.status(1.2)["organ"]


def test_points_under_the_tool_are_remembered_and_age():
    _, _, _, sensing = felt(Paraboloid(lambda t: -0.006 + 0.03 * min(t, 0.2)), 0.4)
    stream = sensing.streams["organ"]
    assert 0 < len(stream.remembered) < 1000
    assert "remembered" in sensing.status(0.4)["organ"]
    old = stream._hidden(stream._t + 6.0, X_WC[:3, 3], stream._balls, np.zeros(3))
    assert len(old.points) == 0


@pytest.mark.parametrize(
    ("t", "now", "key"),
    [
        (1.0, 1.01, "doubled"),
        (0.9, 1.01, "backwards"),
        (1.1, 1.6, "late"),
        (1.5, 1.1, "future"),
        (np.nan, 1.1, "future"),
    ],
)
def test_stamps_that_cannot_be_used_are_counted(t, now, key):
    gate = Gate(patience=0.3)
    gate.accept(1.0)
    assert gate.take(CloudFrame(np.zeros((3, 3)), t), now) is None
    assert getattr(gate.counts, key) == 1


def test_frames_that_repeat_their_points_or_are_no_frames_are_counted():
    gate, points = Gate(patience=0.3), np.random.default_rng(0).normal(size=(500, 3))
    assert gate.take(CloudFrame(points, 1.0), 1.0) is not None
    gate.accept(1.0)
    assert gate.take(CloudFrame(points, 1.1), 1.1) is None
    assert gate.take(CloudFrame(points[:, :2], 1.2), 1.2) is None
    assert gate.take(CloudFrame(points, 1.2, np.zeros((4, 4))), 1.2) is None
    assert (gate.counts.frozen, gate.counts.invalid) == (1, 2)


def test_frames_without_points_never_stop_the_loop():
    class Blind(Paraboloid):
        def latest(self, now):
            frame = super().latest(now)
            return frame and CloudFrame(np.full((500, 3), np.nan) + 0 * frame.t, frame.t, X_WC)

    _, force, _, sensing = felt(Blind(lambda t: 0.0), 0.2)
    counts = sensing.streams["organ"].gate.counts
    assert counts.empty == 1
    assert not force.any()


def test_velocity_needs_two_displacements_alike():
    motion = SurfaceMotion()
    assert not motion.update(np.array([0, 0, 0.005]), 0.033).any()  # a jump is not extrapolated
    assert not motion.update(np.zeros(3), 0.033).any()
    motion.update(np.array([0, 0, 0.0033]), 0.033)
    assert motion.update(np.array([0, 0, 0.0033]), 0.033) == pytest.approx([0, 0, 0.1])
    assert not motion.update(None, 0.033).any()


def test_a_hole_is_closed_by_the_surface_around_it():
    xy = np.random.default_rng(0).uniform(-0.03, 0.03, (4000, 2))
    points = np.c_[xy, -(xy**2).sum(axis=1) / 0.12]
    points = points[np.hypot(*xy.T) > 0.008]
    found, normals = patch(points, np.array([0, 0, 0.5]), np.zeros(3), 0.008, 1e-3)
    assert len(found) > 100
    assert found[:, 2] == pytest.approx(-(found[:, :2] ** 2).sum(axis=1) / 0.12, abs=1e-5)
    assert (normals[:, 2] > 0.9).all()
    assert not len(patch(points[:5], np.array([0, 0, 0.5]), np.zeros(3), 0.008, 1e-3)[0])


def test_an_object_without_source_and_a_source_without_object_are_named():
    with pytest.raises(SceneError, match="no sensor 'camera'"):
        Session(Scene.parse(SCENE))
    with pytest.raises(SceneError, match="source 'other'"):
        Session(Scene.parse(SCENE), clouds={"camera": [], "other": []})


def test_a_session_takes_an_iterator_of_arrays():
    xy = np.random.default_rng(0).uniform(-0.04, 0.04, (6000, 2))
    clouds = (np.c_[xy, -0.02 + 1e-6 * k + 0 * xy[:, :1]] for k in range(100))
    session = Session(Scene.parse(SCENE), clouds={"camera": clouds})
    session.step(100)
    assert session.sensing.streams["organ"].gate.counts.used == 3


def test_haptics_takes_clouds_beside_a_loop_of_ones_own():
    xy = np.random.default_rng(0).uniform(-0.04, 0.04, (6000, 2))
    clouds = (np.c_[xy, 0.001 + 1e-6 * k + 0 * xy[:, :1]] for k in range(10_000))
    with Haptics(Scene.parse(SCENE), clouds={"camera": clouds}) as haptics:
        end = time.monotonic() + 20.0
        wrench = np.zeros(6)
        while np.linalg.norm(wrench[:3]) < 0.5 and time.monotonic() < end:
            wrench = haptics.step(time.monotonic(), np.eye(4))
            time.sleep(1e-3)
    assert np.linalg.norm(wrench[:3]) >= 0.5
