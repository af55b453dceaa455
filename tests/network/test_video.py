"""The remote camera: whole pictures with a true delay, at most the bandwidth, none queued, damaged ones left out."""

import http.server
import io
import threading
import time
import warnings
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from palpate.base.errors import PalpateError
from palpate.cli import main
from palpate.session.network import video
from palpate.session.network.keys import make_key
from palpate.viewer.video import VideoPanel

pytest.importorskip("cryptography", reason="links need the extra remote")
from palpate.scene import Scene
from palpate.scene.rig import build
from palpate.session import Session
from palpate.session.remote import link as links
from palpate.session.remote import site as sites

KEY = bytes(range(32))


def jpeg(k, size=(64, 48)):
    out = io.BytesIO()
    Image.fromarray(np.full((*size[::-1], 3), 20 * k % 256, np.uint8)).save(out, "JPEG")
    return out.getvalue()


@pytest.fixture
def folder(tmp_path):
    for k in range(5):
        (tmp_path / f"{k}.jpg").write_bytes(jpeg(k))
    return tmp_path


def sender(pictures, send, bandwidth=1e9):
    class Given:
        def pictures(self, stopped, tell):
            yield from pictures

    return video.Sender(Given(), send, bandwidth)


def test_the_operator_sees_the_pictures_of_the_far_side_with_their_delay(folder):
    """Over the encrypted channel of a running link; the delay is that of the camera's clock, which is this one here."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        rig = build(Scene.load("remote"))
    server = sites.FollowerServer(rig, KEY, "127.0.0.1", 0, 500.0, lambda line: None,
                                  video=video.Folder(folder, 30.0))  # fmt: skip
    thread = threading.Thread(target=server.run)
    thread.start()
    shown, delays = set(), []
    try:
        mine = Session(rig.scene, rig=rig)
        with links.RemoteLink(mine, ("127.0.0.1", server.port), KEY, 500.0):
            mine.start()
            for _ in range(100):
                time.sleep(0.03)
                if found := mine.video():
                    shown.add(found[0])
                    delays.append(found[1])
                if len(shown) >= 4:
                    break
            mine.stop()
        assert mine.video is None
    finally:
        server.stop()
        thread.join()
    assert shown <= {jpeg(k) for k in range(5)}
    assert len(shown) >= 4
    assert -0.005 <= min(delays) <= 0.5  # the last one of a busy machine may be older
    assert server.video.sent >= 4


def test_a_slow_network_drops_pictures_and_queues_none():
    """Nothing is sent while the picture before is late; what is sent then is the newest one."""
    sent = []
    pictures = (video.Picture(jpeg(k), float(k)) for k in range(50))
    one = sender(pictures, lambda message: sent.append(message) or True)
    one.run()
    assert [m["t"] for m in sent] == [0.0]  # the first has not arrived
    assert one.dropped == 49
    one.seen(sent[0]["video"])
    assert one._may(1000)


def test_no_more_than_the_bandwidth_is_sent():
    picture = jpeg(1, (640, 480))
    sent = []

    def pictures():
        end = time.monotonic() + 1.0
        while time.monotonic() < end:
            time.sleep(0.002)
            yield video.Picture(picture, time.monotonic())

    def send(message):
        sent.append(len(message["jpeg"]))
        one.seen(message["video"])
        return True

    one = sender(pictures(), send, bandwidth=8.0 * 20 * len(picture))
    begin = time.monotonic()
    one.run()
    assert 3 <= len(sent) <= 20 * (time.monotonic() - begin) + 1
    assert one.dropped > 0


@pytest.mark.parametrize(
    "message",
    [{}, {"t": 1.0}, {"t": 1.0, "jpeg": "???"}, {"t": 1.0, "jpeg": "AAAA"}, {"t": "x", "jpeg": ""},
     {"t": float("nan"), "jpeg": ""}],
)  # fmt: skip
def test_messages_without_a_picture_are_left_out(message):
    assert video.received(message) is None


def test_streams_of_motion_jpeg_are_read_and_others_refused():
    pictures = [jpeg(k) for k in range(4)]
    stream = b"".join(b"--frame\r\nContent-Type: image/jpeg\r\n\r\n" + p + b"\r\n" for p in pictures)
    assert list(video.parts(io.BytesIO(stream))) == pictures
    rng = np.random.default_rng(0)
    for _ in range(200):  # damaged bytes lose pictures and fail nothing
        damaged = bytearray(stream)
        for i in rng.integers(0, len(stream), 20):
            damaged[i] = int(rng.integers(0, 256))
        assert all(video.is_jpeg(p) for p in video.parts(io.BytesIO(bytes(damaged))))
    with pytest.raises(ValueError, match="no pictures of motion JPEG"):
        list(video.parts(io.BytesIO(b"x" * (5 * video.LARGEST))))


def test_a_camera_over_http_is_asked_again_when_it_ends(monkeypatch):
    monkeypatch.setattr(video, "_PAUSE", 0.01)

    class Camera(http.server.BaseHTTPRequestHandler):
        def do_GET(self):
            self.send_response(200)
            self.end_headers()
            self.wfile.write(b"--a\r\n\r\n" + jpeg(3) + b"\r\n")

        def log_message(self, *args):
            pass

    with http.server.HTTPServer(("127.0.0.1", 0), Camera) as camera:
        threading.Thread(target=camera.serve_forever, daemon=True).start()
        stopped, found, told = threading.Event(), [], []
        for picture in video.Mjpeg(f"http://127.0.0.1:{camera.server_port}/").pictures(stopped, told.append):
            found.append(picture.jpeg)
            if len(found) == 3:
                stopped.set()
        camera.shutdown()
    assert found == [jpeg(3)] * 3
    assert set(told) == {f"camera http://127.0.0.1:{camera.server_port}/: it has ended its stream, and is asked again"}


def test_a_camera_that_does_not_answer_is_told_once(monkeypatch):
    monkeypatch.setattr(video, "_PAUSE", 0.01)
    told = []
    one = video.Sender(video.Mjpeg("http://127.0.0.1:9/"), lambda message: True, tell=told.append)
    running = threading.Thread(target=one.run)
    running.start()
    time.sleep(0.3)
    one.stop()
    running.join(5.0)
    assert not running.is_alive()
    assert len(told) == 1
    assert told[0].startswith("camera http://127.0.0.1:9/: ")


def test_a_file_that_has_gone_is_told_and_the_others_are_sent(folder):
    given, stopped, told, found = video.Folder(folder, 1000.0), threading.Event(), [], []
    (folder / "2.jpg").unlink()
    for picture in given.pictures(stopped, told.append):
        found.append(picture.jpeg)
        if len(found) == 6:
            stopped.set()
    assert found == [jpeg(k) for k in (0, 1, 3, 4, 0, 1)]
    assert "2.jpg" in told[0]


def test_wrong_sources_are_told(tmp_path, capsys):
    with pytest.raises(PalpateError, match="no picture"):
        video.Folder(tmp_path)
    (tmp_path / "a.jpg").write_bytes(b"text")
    with pytest.raises(PalpateError, match="no JPEG picture of at most 256 KiB"):
        video.Folder(tmp_path)
    make_key(tmp_path / "key")
    assert main(["serve", "follower", "remote", "--key", str(tmp_path / "key"), "--video", "nowhere"]) == 2
    assert "--video nowhere: there is no such folder" in capsys.readouterr().err


class Gui:
    """The part of viser that the panel uses."""

    def __init__(self):
        self.made = []

    def add_html(self, content, order):
        self.made.append(SimpleNamespace(content=content))
        return self.made[-1]


def test_the_viewer_shows_the_newest_picture_with_its_delay():
    gui, panel = Gui(), None
    panel = VideoPanel(gui)
    panel.show(None)
    panel.show(lambda: None)
    assert gui.made == []
    for k in range(3):
        panel.show(lambda k=k: (jpeg(k), 0.1 + 0.01 * k))
    picture, words = gui.made
    assert "delay 120 ms" in words.content
    assert "data:image/jpeg;base64," in picture.content


def test_a_picture_that_stands_still_is_told():
    """A frozen picture beside its last delay would look like a live one."""
    gui, one = Gui(), jpeg(1)
    panel = VideoPanel(gui)
    for age in np.arange(0.05, 3.2, 0.1):
        panel.show(lambda age=age: (one, age))
        assert ("delay 50 ms" in gui.made[1].content) == (age < 1.0)
    assert "no new picture for 3 s" in gui.made[1].content
    panel.show(lambda: (jpeg(2), 0.04))
    assert "delay 40 ms" in gui.made[1].content


def test_the_endoscope_of_a_simulated_site_sees_its_tool_move():
    """Its pictures come from the pose in the packets; the object lies where the site has it."""
    pytest.importorskip("moderngl", reason="drawing needs the extra learning")
    from palpate import _network
    from palpate.gym.site_camera import SiteCamera

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        rig = build(Scene.load("remote"))
    state = _network.Datagram()
    state.t, state.X = 1.0, rig.arms.X_WB @ rig.arms.follower.fk(rig.arms.q_follower0)
    stopped, found, told = threading.Event(), [], []
    asked = []

    def packets():  # nobody looks at first
        asked.append(len(found))
        return [_network.encode(state)] if len(asked) > 3 else []

    for picture in SiteCamera([rig], packets).pictures(stopped, told.append):
        found.append(np.asarray(Image.open(io.BytesIO(picture.jpeg)), int))
        assert 0.0 <= time.monotonic() - picture.t < 5.0
        if len(found) == 2:
            X = np.array(state.X)
            X[:3, 3] += [0.0, 0.0, 0.005]
            state.X = X
        if len(found) == 3:
            stopped.set()
    assert told == []
    assert asked == [0, 0, 0, 0, 1, 2]
    still, moved = (np.abs(found[k] - found[k - 1]).max(axis=2) > 40 for k in (1, 2))
    assert still.sum() == 0
    assert 200 < moved.sum() < 0.2 * moved.size  # the instrument, and nothing else


def test_an_arm_over_ros_has_no_simulated_camera(tmp_path, capsys):
    make_key(tmp_path / "key")
    given = ["--key", str(tmp_path / "key"), "--video", "scene", "--arm", "PSM1", "--force", "/f"]
    assert main(["serve", "follower", "remote", *given]) == 2
    assert "--video scene: an arm over ROS 2 is at no simulated site" in capsys.readouterr().err
