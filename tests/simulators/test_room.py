"""The simulated operating room: the camera against closed forms, the hand against the surface, and whole sessions."""

import numpy as np
import pytest

from palpate import _core
from palpate.arm import models_folder
from palpate.base.arrays import rigid
from palpate.base.errors import RegistrationError, SceneError
from palpate.scene import Scene
from palpate.scene.overrides import override
from palpate.scene.registered import RegisteredOrgan
from palpate.simulators.depth_camera import DepthCamera, cast
from palpate.simulators.room import Room
from palpate.simulators.unattended import true_errors, unattended

SCENE = models_folder().parent / "scenes" / "registration.yaml"


@pytest.fixture(scope="module")
def scene():
    return override(Scene.load(SCENE), {"objects.0.triangles": 4000})


def test_rays_end_on_a_sphere_where_the_closed_form_says():
    rng, centre, r = np.random.default_rng(0), np.array([0.1, -0.05, 0.5]), 0.08
    d = DepthCamera().rays()
    assert np.linalg.norm(d, axis=1) == pytest.approx(1.0)
    sphere = _core.Sphere(r)
    t, _ = cast(sphere, -centre, d)
    b = d @ centre
    under = b**2 - centre @ centre + r**2
    clear = np.abs(under) > 1e-5  # rays that graze the sphere may fall either way
    assert np.array_equal(np.isfinite(t)[clear], under[clear] > 0.0)
    hit = clear & (under > 0.0)
    assert t[hit] == pytest.approx((b - np.sqrt(np.maximum(under, 0.0)))[hit], abs=2e-3)
    steep = hit & (under > 2e-3)
    assert t[steep] == pytest.approx((b - np.sqrt(np.maximum(under, 0.0)))[steep], abs=2e-4)
    seen = DepthCamera(noise=1e-3, outliers=0.0).look(sphere, rigid.rigid(np.eye(3), centre), rng)
    along = np.linalg.norm(seen - centre, axis=1) - r
    assert np.std(along) < 1.1e-3
    assert (seen[:, 2] < centre[2]).all()  # the far side is hidden


def test_hand_measures_the_place_of_contact_and_feels_nothing_elsewhere(scene):
    room = Room(override(scene, {"registration.touch_mm": 1e-6, "registration.tip_mm": 1e-6}), 1)
    placed = room.rig.surfaces[0]
    q, n = placed.nearest(np.array([[-0.03, -0.01, 0.2], [0.02, -0.02, 0.2]]))
    for p, normal in zip(q, n, strict=True):
        assert room.hand.reaches(p, normal)
        X_WT = room.hand.touch(p, normal)
        off = rigid.transform(rigid.inverse(placed.X_WO), X_WT[None, :3, 3])
        assert placed.body.core.nearest(off)[0][0] - room.hand.radius == pytest.approx(0.0, abs=0.15e-3)
    assert room.hand.touch(q[0] + [0.0, 0.0, 0.05], n[0]) is None
    assert not room.hand.reaches(q[0] + [0.5, 0.0, 0.0], n[0])
    assert not room.hand.reaches(q[0], -n[0])


def test_session_ends_within_its_bounds(scene):
    scanned, room = RegisteredOrgan(scene), Room(scene, 1)
    state = unattended(scanned, room)
    errors = true_errors(scanned, room, state.found.X)
    assert max(state.bounds.values()) <= 1e-3
    assert all(errors[name] < state.bounds[name] for name in errors)


def test_organ_that_moves_is_told(scene):
    scanned, room = RegisteredOrgan(scene), Room(scene, 3)

    def told(state):
        if len(state.X_WT) == 3:
            room.move(rigid.displaced(room.X_WA, [0.004, -0.003, 0.004, 0.0, 0.0, 0.0]))

    with pytest.raises(RegistrationError, match="touches disagree"):
        unattended(scanned, room, told)


def test_small_motion_that_the_touches_do_not_show_is_seen_by_a_last_view(scene):
    """Touches alone tell a motion of 1 mm in a quarter of such sessions."""
    scanned, seen = RegisteredOrgan(scene), 0
    for seed in range(4):
        room = Room(scene, seed)

        def told(state, room=room):
            if len(state.X_WT) == 3:
                room.move(rigid.displaced(room.X_WA, [0.0, 0.0, 1e-3, 0.0, 0.0, 0.0]))

        with pytest.raises(RegistrationError, match=r"organ or camera moved|the organ moved|touches disagree") as error:
            unattended(scanned, room, told)
        seen += "first view and the last" in str(error.value)
    assert seen >= 1


def test_tip_that_is_off_is_told(scene):
    room = Room(scene, 4, tip_error=np.array([0.006, 0.0, 0.008]))
    with pytest.raises(RegistrationError, match=r"touches disagree(.|\n)*tip is calibrated wrongly|nothing is felt"):
        unattended(RegisteredOrgan(scene), room)


@pytest.mark.parametrize(
    ("changes", "error", "words"),
    [
        ({"registration.frame": "liver"}, SceneError, "no frame 'liver' to register"),
        ({"registration.frame": "camera"}, SceneError, "without a file"),
        ({"frames.1.parent": "camera"}, SceneError, "parent of frame"),
        ({"objects.0.frame": "world"}, SceneError, "no object stands in frame"),
        ({"registration.targets": {"a": [0.0, 0.0, 3.0]}}, RegistrationError, "outside of the organ"),
    ],
)
def test_sections_that_do_not_fit_are_refused(scene, changes, error, words):
    with pytest.raises(error, match=words):
        RegisteredOrgan(override(scene, changes))
