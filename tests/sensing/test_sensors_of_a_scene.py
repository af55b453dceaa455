"""Sensors of a scene: their sources, the world that a simulated camera sees, and mistakes."""

import numpy as np
import pytest

import palpate
from palpate.base.errors import SceneError
from palpate.scene import Scene
from palpate.sensing.make import make

ARMS = "arms: {follower: {base: {xyz: [-0.12, -0.06, 0.155], rpy_deg: [0, 0, 205]}}}\n"
OBJECTS = "objects: [{name: ball, sphere: {radius: 0.03}, motion: {amplitude: [0, 0, 0.01], period: 4}}]\n"
CAMERA = "sensors: {c: {simulated: {columns: 80, rows: 60, noise_mm: 0, step_mm: 0, dropout: 0}, POSE}}\n"
POSE = "pose: {xyz: [0, 0, 0.4], rpy_deg: [180, 0, 0]}"


def test_the_camera_sees_the_moving_ball_and_the_instrument():
    session = palpate.Session(Scene.parse(CAMERA.replace("POSE", POSE) + OBJECTS + ARMS))
    source = make(session.rig, "c", session.latest)
    names = [body.name for body in source.camera.bodies]
    tops = []
    for _ in range(2):
        frame = source.latest(float(len(tops)))
        ball = source.picture.body == names.index("ball")
        p = frame.points[ball & source.picture.valid].astype(float)
        tops.append((p @ frame.X_WC[:3, :3].T + frame.X_WC[:3, 3])[:, 2].max())
        session.run(1.0)
    assert tops == pytest.approx([0.03, 0.04], abs=1e-3)
    assert (source.picture.body > 0).any()
    assert np.isfinite(frame.points).any()


@pytest.mark.parametrize(
    ("sensors", "words"),
    [
        ("sensors: {c: {POSE}}\n", "no source given"),
        ("sensors: {c: {simulated: {}, replay: x, POSE}}\n", "simulated and replay given"),
        ("sensors: {c: {topic: points}}\n", "is not a topic"),
        ("sensors: {c: {simulated: {near: 2, far: 1}}}\n", "is not below far"),
    ],
)
def test_mistakes_name_their_line(sensors, words):
    with pytest.raises(SceneError, match=words):
        Scene.parse(sensors.replace("POSE", POSE) + OBJECTS)


def test_what_does_not_exist_is_named():
    rig = palpate.Session(
        Scene.parse("sensors: {c: {replay: nowhere}, d: {simulated: {}, frame: away}}\n" + OBJECTS)
    ).rig
    for name, words in (("c", "does not exist"), ("d", "away"), ("e", "there is no sensor 'e'")):
        with pytest.raises(SceneError, match=words):
            make(rig, name, lambda: None)


def test_a_topic_of_an_object_becomes_a_sensor():
    scene = Scene.parse("objects: [{name: a, cloud: {topic: /camera/depth/points}}]\n")
    assert scene.objects[0].cloud.sensor == "/camera/depth/points"
    assert scene.sensors["/camera/depth/points"].by_tf
