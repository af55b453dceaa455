"""The age of a camera's frame in the viewer."""

import numpy as np

from palpate import Scene, Session
from palpate.viewer.clouds import EVERY, CloudDrawing, age_words

SCENE = """
objects:
  - name: organ
    cloud: {sensor: camera}
arms: {follower: {start: {xyz: [0, 0, 0], rpy_deg: [180, 0, 0]}}}
operator: {path: [{t: 0, xyz: [0, 0, 0]}, {t: 1, xyz: [0, 0, 0]}]}
"""


def test_a_frame_beyond_the_patience_is_called_stale():
    assert age_words(0.05, 0.3) == "50 ms"
    assert age_words(0.3, 0.3) == "300 ms"
    assert age_words(1.24, 0.3) == "STALE for 1.2 s, the force fades"


def test_the_drawing_names_a_stale_camera():
    class Node:
        def __init__(self, *args, **kwargs):
            self.text = ""

    class Drawn:
        def __init__(self):
            self.label = Node()

        def add_label(self, *args, **kwargs):
            return self.label

        add_point_cloud = add_frame = add_camera_frustum = Node

    cloud = np.random.default_rng(0).uniform(-0.04, 0.04, (6000, 3)) * [1, 1, 0]
    session = Session(Scene.parse(SCENE), clouds={"camera": [cloud]})
    session.step(50)
    scene = Drawn()
    drawing = CloudDrawing(scene, session.sensing)
    for t, words in ((0.1, " ms"), (1.0, "STALE")):
        for _ in range(EVERY):
            drawing.show(t)
        assert words in scene.label.text
