"""`palpate serve follower --video ros:TOPIC`: a camera of another process reaches the operator with its delay."""

import io
import threading
import time
from array import array
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("cryptography", reason="links need the extra remote")
pytest.importorskip("PIL", reason="pictures need the extra viewer")

from PIL import Image

from palpate.base.errors import PalpateError
from palpate.cli import main
from palpate.ros.pictures import RosPictures, age
from palpate.scene import Scene
from palpate.scene.rig import build
from palpate.session import Session
from palpate.session.network.keys import make_key, read_key
from palpate.session.network.video import LARGEST
from palpate.session.remote.link import RemoteLink

SCENE = {"objects": [{"name": "table", "plane": {}}]}
CAMERA = """
import io, sys, time
import numpy as np, rclpy
from PIL import Image as Pillow
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import CompressedImage, Image
kind, encoding, lag = sys.argv[1], sys.argv[2], float(sys.argv[3])
rclpy.init()
node = rclpy.create_node("test_camera")
topic = node.create_publisher(CompressedImage if kind == "packed" else Image, "/test/image", qos_profile_sensor_data)
print("ready", flush=True)
for k in range(100000):
    picture = np.zeros((48, 64, 3), np.uint8)
    picture[:, :32, 0], picture[:, 32:, 2] = 200, 250  # red beside blue
    if kind == "packed":
        out = io.BytesIO()
        Pillow.fromarray(picture).save(out, "JPEG")
        message = CompressedImage(format="jpeg")
        message.data = out.getvalue()
    else:
        message = Image(height=48, width=64, encoding=encoding)
        rows = picture[:, :, ::-1] if encoding == "bgr8" else picture
        rows = np.pad(rows.reshape(48, -1), ((0, 0), (0, 7)))  # rows may be longer than their pixels
        message.step = rows.shape[1]
        message.data = rows.tobytes()
    t = time.time() - lag
    message.header.stamp.sec, message.header.stamp.nanosec = int(t), int(1e9 * (t % 1.0))
    topic.publish(message)
    time.sleep(0.05)
"""


@pytest.fixture
def camera(start, tmp_path):
    """Starts a process that publishes pictures."""

    def begin(kind="raw", encoding="bgr8", lag=0.0):
        file = tmp_path / "camera.py"
        file.write_text(CAMERA)
        process = start(file, kind, encoding, lag)
        assert process.stdout.readline() == "ready\n"
        return process

    return begin


def seen(video, count=3, seconds=20.0):
    """The first pictures of a source (n, h, w, 3), their ages when they come [s], and the words for the user."""
    stopped, found, ages, told = threading.Event(), [], [], []
    timer = threading.Timer(seconds, stopped.set)
    timer.start()
    for picture in video.pictures(stopped, told.append):
        ages.append(time.monotonic() - picture.t)
        found.append(np.asarray(Image.open(io.BytesIO(picture.jpeg))))
        if len(found) == count:
            stopped.set()
    timer.cancel()
    return np.array(found), ages, told


@pytest.mark.parametrize(("kind", "encoding"), [("raw", "bgr8"), ("raw", "rgb8"), ("packed", "")])
def test_pictures_of_both_types_have_their_colours_and_the_age_of_their_stamp(camera, kind, encoding):
    camera(kind, encoding, lag=0.3)
    found, ages, _ = seen(RosPictures("/test/image"))
    assert found.shape == (3, 48, 64, 3)
    assert np.abs(found[:, :, 8:24].astype(int) - [200, 0, 0]).max() <= 6
    assert np.abs(found[:, :, 40:56].astype(int) - [0, 0, 250]).max() <= 6
    assert 0.3 <= min(ages) <= 0.8


def test_an_operator_sees_the_camera_of_a_follower_in_another_process(camera, start, tmp_path):
    camera()
    scene, key = tmp_path / "scene.json", tmp_path / "key"
    scene.write_text(Scene.model_validate(SCENE).model_dump_json(exclude_unset=True))
    make_key(key)
    server = start("-m", "palpate", "serve", "follower", scene, "--key", key, "--port", 0, "--video", "ros:/test/image")
    while "listening" not in (line := server.stdout.readline()):
        assert line, server.stderr.read()
    port = int(line.split("port ")[1].split(";")[0])
    session = Session(Scene.load(scene), rig=build(Scene.load(scene)))
    with RemoteLink(session, ("127.0.0.1", port), read_key(key), 500.0):
        session.start()
        end = time.monotonic() + 20.0
        while (shown := session.video()) is None and time.monotonic() < end:
            time.sleep(0.05)
        session.stop()
    assert np.asarray(Image.open(io.BytesIO(shown[0]))).shape == (48, 64, 3)
    assert 0.0 <= shown[1] <= 1.0


def test_what_keeps_pictures_away_is_told(camera, node):
    from std_msgs.msg import String

    _, _, told = seen(RosPictures("/test/nobody"), seconds=4.0)
    assert set(told) == {"camera /test/nobody: nobody publishes it"}
    node.create_publisher(String, "/test/words", 1)
    _, _, told = seen(RosPictures("/test/words"), seconds=4.0)
    assert set(told) == {"camera /test/words: it carries std_msgs/msg/String, and pictures are "
                         "sensor_msgs/msg/Image or sensor_msgs/msg/CompressedImage"}  # fmt: skip
    camera("raw", "bayer_rggb8")
    _, _, told = seen(RosPictures("/test/image"), seconds=3.0)
    assert told[0].startswith("camera /test/image: pictures of the encoding 'bayer_rggb8'")
    with pytest.raises(PalpateError, match="'a b' is not the name of a topic"):
        RosPictures("a b")


def test_large_pictures_are_made_smaller_until_they_are_sent():
    noise = np.random.default_rng(0).integers(0, 256, (1080, 1920, 3), np.uint8)
    message = SimpleNamespace(encoding="rgb8", width=1920, height=1080, step=5760, data=array("B", noise.tobytes()))
    video = RosPictures("/test/large")
    data = video._jpeg(message)
    video._background.close()
    assert len(data) <= LARGEST
    assert Image.open(io.BytesIO(data)).size == (480, 270)


@pytest.mark.parametrize(("ago", "expected"), [(0.2, 0.2), (-5.0, 0.0), (3600.0, 0.0)])
def test_a_stamp_of_another_clock_is_not_believed(ago, expected):
    t = time.time() - ago
    assert age(SimpleNamespace(sec=int(t), nanosec=int(1e9 * (t % 1.0)))) == pytest.approx(expected, abs=0.05)


def test_other_machines_need_ros(tmp_path, capsys):
    make_key(tmp_path / "key")
    assert main(["serve", "follower", "remote", "--key", str(tmp_path / "key"), "--network"]) == 2
    assert "--network: a simulated instrument does not use ROS 2" in capsys.readouterr().err
