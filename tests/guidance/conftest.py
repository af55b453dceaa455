"""Files, frames, points and an object for the tests of fixtures in Python and YAML."""

import numpy as np
import pytest
import trimesh

from palpate import _core
from palpate.scene.guidance import FixtureContext
from palpate.world import surfaces


@pytest.fixture(scope="module")
def here(tmp_path_factory):
    folder = tmp_path_factory.mktemp("files")
    ball = trimesh.creation.icosphere(3, 20.0)
    ball.export(folder / "ball.stl")
    ball.update_faces(np.arange(len(ball.faces)) > 5)
    ball.export(folder / "open.stl")
    np.savetxt(folder / "cloud.csv", 1e3 * np.random.default_rng(0).normal(size=(50, 3)) * 0.02, delimiter=",")
    np.savetxt(folder / "suture.csv", [[0, 0, 0], [10, 5, 0], [20, 0, 5]], delimiter=";")
    frames = {"world": _core.MotionFrame(), "liver": _core.MotionFrame(np.eye(4), _core.Motion(v=np.ones(3)))}
    places = {"entry": [0, 0, 0.1], "target": [0, 0, 0.02]}
    return FixtureContext(lambda name: folder / name, frames, places, {"liver": surfaces.Sphere(0.03)})
