"""Video of the surgeon's view: a pinhole by closed form, both eyes, and films that PyAV decodes."""

import json
import sys

import numpy as np
import pytest
from lerobot_rules import faults, faults_of_open_h
from scipy.spatial.transform import Rotation

from palpate.base.errors import MissingExtraError, PalpateError, RecordError
from palpate.cli import main
from palpate.export import export
from palpate.export.demonstration import demonstrations
from palpate.export.episode import episode_of
from palpate.export.video.drawing import Canvas
from palpate.export.video.film import Film
from palpate.session import Session
from palpate.viewer.solids import ball

av = pytest.importorskip("av", reason="av (extra learning) is not installed")
SIZE = (480, 640)


@pytest.fixture(scope="module", autouse=True)
def _opengl():
    try:
        Canvas((8, 8), 60.0).close()
    except (PalpateError, MissingExtraError) as error:
        pytest.skip(f"no OpenGL without a window: {error.what}")


def test_camera_is_the_pinhole_of_its_intrinsics():
    """A ball at a place is drawn at the pixel of the closed form: x right, y down, z ahead."""
    rng = np.random.default_rng(0)
    width_deg, f = 70.0, 0.5 * SIZE[1] / np.tan(np.radians(35.0))
    for _ in range(4):
        X_WC = np.eye(4)
        X_WC[:3, :3] = Rotation.from_rotvec(rng.normal(size=3)).as_matrix()
        X_WC[:3, 3] = 0.1 * rng.normal(size=3)
        p_C = np.array([rng.uniform(-0.03, 0.03), rng.uniform(-0.02, 0.02), rng.uniform(0.08, 0.15)])
        canvas = Canvas(SIZE, width_deg)
        body = canvas.add(*ball(0.002), (255, 255, 255))
        body.X_WB[:3, 3] = X_WC[:3, :3] @ p_C + X_WC[:3, 3]
        picture = canvas.picture(X_WC)
        canvas.close()
        rows, columns = np.nonzero(picture[:, :, 2] > 60)
        expected = f * p_C[:2] / p_C[2] + [0.5 * SIZE[1], 0.5 * SIZE[0]]
        np.testing.assert_allclose([columns.mean() + 0.5, rows.mean() + 0.5], expected, atol=1.0)


def test_nearer_bodies_hide_those_behind():
    canvas = Canvas(SIZE, 70.0)
    behind, ahead = canvas.add(*ball(0.02), (255, 0, 0)), canvas.add(*ball(0.005), (0, 255, 0))
    behind.X_WB[2, 3], ahead.X_WB[2, 3] = 0.12, 0.06
    red, green, _ = canvas.picture(np.eye(4))[SIZE[0] // 2, SIZE[1] // 2]
    canvas.close()
    assert green > 2 * red


def test_bodies_at_rest_look_as_those_drawn_each_time():
    """They are drawn once for a camera; pixels are equal, also for more cameras than are kept and for hidden bodies."""
    cameras = [np.eye(4) for _ in range(3)]
    for k, X_WC in enumerate(cameras):
        X_WC[0, 3] = 0.004 * k
    canvases = [Canvas(SIZE, 70.0) for _ in range(2)]
    for canvas, X in zip(canvases, (np.eye(4), None), strict=True):
        points, triangles = ball(0.02)
        canvas.add(np.add(points, [0.0, 0.0, 0.1]), triangles, (255, 0, 0), 0.2, X)
    moving = [canvas.add(*ball(0.01), (0, 255, 0)) for canvas in canvases]
    for step in range(4):
        for X_WC in cameras:
            for body in moving:
                body.X_WB[:3, 3] = [0.01 * step - 0.02, 0.0, 0.09 + 0.01 * step]
            kept, anew = (canvas.picture(X_WC) for canvas in canvases)
            np.testing.assert_array_equal(kept, anew)
    assert len(canvases[0]._backgrounds) == 2
    for canvas in canvases:
        canvas.close()


@pytest.fixture(scope="module")
def felt(tmp_path_factory):
    """Record of a short simulated palpation."""
    scene = {
        "objects": [{"name": "liver", "shape": "organ", "triangles": 3000}],
        "operator": {"palpate": {"approach": 0.2, "press": 0.1, "slide": 0.2, "leave": 0.2}},
        "record": {"report": False},
    }
    return Session(scene, out=tmp_path_factory.mktemp("felt")).run(0.3).record


def frames_of(file):
    with av.open(str(file)) as film:
        return [frame.to_ndarray(format="rgb24") for frame in film.decode(video=0)]


@pytest.mark.parametrize(
    ("version", "name"), [("3.0", "{}/chunk-000/file-000.mp4"), ("2.1", "chunk-000/{}/episode_000000.mp4")]
)
def test_films_of_both_eyes_belong_to_the_frames(felt, tmp_path, monkeypatch, version, name):
    monkeypatch.setattr(Film.__init__, "__defaults__", (SIZE,))
    words = ["export", felt, "--out", str(tmp_path / "out"), "--video", "--version", version, "--fps", "20"]
    assert main(words) == 0
    assert faults(tmp_path / "out", images=True) == []
    assert faults_of_open_h(tmp_path / "out") == []
    films = {
        side: frames_of(tmp_path / "out/videos" / name.format(f"observation.images.endoscope.{side}"))
        for side in ("left", "right")
    }
    assert {len(film) for film in films.values()} == {6}
    assert films["left"][0].shape == (*SIZE, 3)
    assert np.abs(films["left"][0].astype(int) - films["right"][0]).mean() > 0.5
    camera = json.loads((tmp_path / "out/meta/calibration/camera_intrinsics.json").read_text())
    assert camera["endoscope.left"]["fx"] == pytest.approx(0.5 * SIZE[1] / np.tan(np.radians(35.0)))
    assert camera["baseline_m"] == 0.005


def test_film_shows_the_motion_of_the_tool(felt):
    run = demonstrations([felt])[0]
    film = Film(run, SIZE)
    assert len(film.canvas._resting) == 1  # the organ is drawn once, and not in each picture
    first, *_, last = [shown["left"].astype(int) for shown in film.pictures(episode_of(run, 10))]
    film.close()
    assert (np.abs(first - last).max(axis=2) > 20).mean() > 0.005


PRESS = {"palpate": {"approach": 0.1, "press": 0.3, "slide": 0.1, "leave": 0.1}}
LIVER = {"name": "liver", "box": {"size": [0.06, 0.06, 0.03]}, "pose": {"xyz": [0, 0, -0.015]}}


def test_film_shows_a_soft_object_as_the_loop_deformed_it(tmp_path):
    soft = LIVER | {"tissue": {"preset": "liver", "resolution": 0.012, "springs": 1e6}}
    run = demonstrations([Session({"objects": [soft], "operator": PRESS}, out=tmp_path).run(0.4).record])[0]
    film = Film(run, SIZE)
    ((body, rest, track),) = film._soft
    episode, shown = episode_of(run, 10), []
    body.replace = shown.append
    for _ in film.pictures(episode):
        pass
    film.close()
    np.testing.assert_array_equal(shown, [rest + track.at(t) for t in episode.arms[0].frames.t])
    assert 2e-4 < np.abs(np.stack(shown) - rest).max() < 0.01, "the tool dents it"


def test_film_shows_an_object_where_its_motion_has_it(tmp_path):
    moving = LIVER | {"stiffness": 300, "motion": {"amplitude": [0.0, 0.0, 0.01], "period": 1.0}}
    run = demonstrations([Session({"objects": [moving], "operator": PRESS}, out=tmp_path).run(0.5).record])[0]
    film, episode = Film(run, SIZE), episode_of(run, 10)
    ((body, _),) = film._moving
    assert not film.canvas._resting
    heights = [body.X_WB[2, 3] for _ in film.pictures(episode)]
    film.close()
    assert heights == pytest.approx(-0.015 + 0.01 * np.sin(2.0 * np.pi * episode.arms[0].frames.t))


def test_what_cannot_be_filmed_is_named(make, tmp_path, monkeypatch):
    from crtk_bag import write as write_bag

    with pytest.raises(RecordError, match="the bag has no pictures"):
        export(write_bag(tmp_path / "bag", posed=True), tmp_path / "out", video=True)
    monkeypatch.setitem(sys.modules, "moderngl", None)
    with pytest.raises(MissingExtraError, match="moderngl"):
        export(make().path, tmp_path / "out", video=True)
    assert not (tmp_path / "out").exists()
