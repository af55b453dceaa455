"""A sensed organ and a tracked one in a scene: each moves as it does alone, whatever their order."""

import numpy as np
import pytest

from palpate import Session
from palpate.scene import Scene
from palpate.sensing import CloudFrame
from palpate.sensing.trackers import Sighting
from palpate.sensing.trackers.tracking import Tracking

ORGAN = "  - {name: organ, cloud: {sensor: camera, region: 0.04}, stiffness: 1000}\n"
BONE = "  - {name: bone, box: {size: [0.02, 0.02, 0.02]}, frame: patient, stiffness: 1000}\n"
SCENE = """\
frames: [{child: patient, tracker: t, pose: {xyz: [0.2, 0, 0.1]}}]
trackers: {t: {simulated: {}}}
contact: {radius: 0.003}
operator: {path: [{t: 0, xyz: [0, 0, 0]}, {t: 9, xyz: [0, 0, 0]}]}
objects:
"""
X_WC = np.array([[1.0, 0, 0, 0], [0, -1.0, 0, 0], [0, 0, -1.0, 0.5], [0, 0, 0, 1.0]])


def x_marker(t):
    return 0.2 + 0.02 * np.asarray(t)


class Camera:
    """A camera over a plane at z = 1 mm, whose first frame arrives at 0.3 s."""

    def __init__(self):
        self.k, self.rng = 9, np.random.default_rng(0)

    def latest(self, now):
        t = self.k / 30.0
        if now < t + 0.01:
            return None
        self.k += 1
        p = np.c_[self.rng.uniform(-0.05, 0.05, (8000, 2)), np.full(8000, 1e-3)]
        return CloudFrame((p - X_WC[:3, 3]) @ X_WC[:3, :3], t, X_WC)

    def close(self): ...


class Marker:
    """A tracker of a marker that moves along x at 20 mm/s."""

    def poll(self, now):
        X = np.eye(4)
        X[:3, 3] = x_marker(now), 0.0, 0.1
        return [Sighting("patient", X, now)]

    def close(self): ...


@pytest.mark.parametrize("objects", [ORGAN + BONE, BONE + ORGAN], ids=["organ first", "bone first"])
def test_a_sensed_organ_and_a_tracked_bone_move_as_alone(objects):
    session = Session(Scene.parse(SCENE + objects), clouds={"camera": Camera()})
    session.tracking = Tracking(session.rig, session.simulation, {"t": Marker()}, session.sensing._shared)
    ticks = np.array([session.step().tick for _ in range(1000)])
    slot = 0 if objects.startswith(BONE) else 1
    t, x = ticks["t"], ticks["live_p"][:, 3 * slot]
    late = t > 0.6
    depth = 1e-3 + 0.003 - ticks["p_WT"][late, 2]
    assert depth.min() > 1e-3
    assert ticks["F_spring_W"][late, 2] == pytest.approx(1000.0 * depth, rel=0.02)
    assert x[late] == pytest.approx(x_marker(t[late]), abs=1e-4)
    assert np.abs(np.diff(x[t > 0.2])).max() < 1.5e-3 * 0.04, "no step when the organ gets its first surface"
    assert ticks["live_share"][late, :2].min() == 1.0
    assert session.sensing.status(1.0)["organ"].endswith("ms old")
    assert session.tracking.status(1.0) == {"patient": "tracked"}
