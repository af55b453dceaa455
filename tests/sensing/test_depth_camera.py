"""The simulated depth camera: its depths against closed forms and cast rays, its errors against their statistics."""

import numpy as np
import pytest

from palpate import _core
from palpate.sensing.around import looking_at
from palpate.sensing.depth_camera import NO_ERRORS, Body, DepthErrors, SimulatedDepthCamera
from palpate.sensing.lens import Lens

LENS = Lens(64, 48, 60.0, 58.0, 31.2, 23.9, near=0.1, far=4.0)
I = np.eye(4)  # noqa: E741


def plane(z: float, tilt: float = 0.0) -> Body:
    """A large square at depth z, turned about x."""
    p = np.array([[-9.0, -9.0, 0.0], [9.0, -9.0, 0.0], [9.0, 9.0, 0.0], [-9.0, 9.0, 0.0]])
    c, s = np.cos(tilt), np.sin(tilt)
    p = p @ np.array([[1, 0, 0], [0, c, -s], [0, s, c]]).T + [0, 0, z]
    return Body("plane", p, np.array([[0, 1, 2], [0, 2, 3]], np.int32))


def cast(body: Body, rays: np.ndarray) -> np.ndarray:
    """Depths (N,) by testing every ray with every triangle (Moeller and Trumbore, 1997); NaN where none is hit."""
    a, b, c = (body.vertices[body.triangles[:, k]] for k in range(3))
    e1, e2 = b - a, c - a
    h = np.cross(rays[:, None], e2[None])
    with np.errstate(divide="ignore", invalid="ignore"):
        f = 1.0 / np.einsum("ti,nti->nt", e1, h)
        u = f * np.einsum("ti,nti->nt", -a, h)
        q = np.cross(-a, e1)
        v = f * np.einsum("ni,ti->nt", rays, q)
        t = f * np.einsum("ti,ti->t", e2, q)
        t[(u < 0) | (v < 0) | (u + v > 1) | (t < 0) | ~np.isfinite(t)] = np.inf
    t = t.min(axis=1)
    return np.where(np.isfinite(t), t, np.nan)


def test_depths_are_those_of_cast_rays():
    rng = np.random.default_rng(0)
    p = rng.uniform([-0.6, -0.5, -0.2], [0.6, 0.5, 2.0], (60, 3))  # some triangles reach behind the camera
    body = Body("soup", p, rng.permutation(60).reshape(20, 3).astype(np.int32))
    drawn = SimulatedDepthCamera([body], LENS, NO_ERRORS).take(I, [I]).depth.ravel()
    exact = cast(body, LENS.rays.astype(float))
    exact[(exact < LENS.near) | (exact > LENS.far)] = np.nan
    nearer = np.isfinite(exact)
    both = np.isfinite(drawn) & nearer
    assert both.sum() > 800
    assert (np.isfinite(drawn) != nearer).sum() <= 2  # pixels exactly on an edge
    assert np.abs(drawn - exact)[both] == pytest.approx(0.0, abs=2e-5)


def test_a_shift_of_half_a_pixel_would_be_seen():
    body, rays = plane(1.0, np.radians(50)), LENS.rays.astype(float)
    drawn = SimulatedDepthCamera([body], LENS, NO_ERRORS).take(I, [I]).depth.ravel()
    assert drawn == pytest.approx(cast(body, rays), rel=1e-5)
    assert np.nanmax(np.abs(drawn - cast(body, rays + np.array([0, 0.5 / LENS.fy, 0])))) > 3e-3


def test_points_of_a_sphere_lie_on_it_and_cosines_are_those_of_its_normals():
    from palpate.world.surfaces import Sphere

    ball, X_WC = Sphere(0.2), looking_at(np.array([0.7, -0.5, 0.4]), np.zeros(3))
    camera = SimulatedDepthCamera([Body("ball", ball.vertices, ball.triangles)], LENS, NO_ERRORS)
    picture = camera.take(X_WC, [I])
    p_C = picture.points[picture.valid].astype(float)
    p = p_C @ X_WC[:3, :3].T + X_WC[:3, 3]
    assert len(p) > 200
    assert np.linalg.norm(p, axis=1) == pytest.approx(0.2, abs=4e-4)  # facets
    towards = -p_C / np.linalg.norm(p_C, axis=1, keepdims=True) @ X_WC[:3, :3].T
    cosine = camera._image.cosine()[picture.valid]
    assert cosine == pytest.approx(np.einsum("ni,ni->n", towards, p / 0.2), abs=0.05)


def test_noise_grows_with_the_square_of_the_depth_and_the_depth_has_steps():
    lens, spread = Lens(160, 120, 150.0, 150.0, 79.5, 59.5), {}
    for z in (0.5, 1.0, 2.0):
        errors = DepthErrors(step=0.0, dropout=0.0)
        depth = SimulatedDepthCamera([plane(z)], lens, errors, seed=3).take(I, [I]).depth
        spread[z] = float(np.nanstd(depth))
        assert float(np.nanmean(depth)) == pytest.approx(z, rel=1e-3)
    assert spread[1.0] == pytest.approx(1.425e-3, rel=0.03)
    assert spread[2.0] / spread[0.5] == pytest.approx(16.0, rel=0.05)
    stepped = SimulatedDepthCamera([plane(2.0)], lens, DepthErrors(dropout=0.0), seed=3).take(I, [I]).depth
    steps = np.diff(np.unique(stepped[np.isfinite(stepped)].astype(float)))
    assert steps.min() == pytest.approx(2.85e-3 * 4.0, rel=0.05)


def test_what_stands_in_front_hides_and_its_rim_has_flying_pixels():
    card = Body(
        "card", np.array([[-0.1, -0.1, 0], [0.1, -0.1, 0], [0.1, 0.1, 0], [-0.1, 0.1, 0.0]]), plane(0).triangles
    )
    X = np.eye(4)
    X[2, 3] = 0.5
    lens = Lens(160, 120, 150.0, 150.0, 79.5, 59.5)
    exact = SimulatedDepthCamera([plane(1.0), card], lens, NO_ERRORS).take(I, [I, X])
    assert set(np.unique(exact.depth).round(5)) == {0.5, 1.0}
    assert (exact.body == 1).sum() == pytest.approx((0.2 / 0.5 * 150) ** 2, rel=0.03)
    errors = DepthErrors(noise=0.0, step=0.0, dropout=0.0, rim_dropout=0.0, flying=1.0)
    flown = SimulatedDepthCamera([plane(1.0), card], lens, errors).take(I, [I, X])
    between = (flown.depth > 0.51) & (flown.depth < 0.99)
    around = 4 * 0.2 / 0.5 * 150
    assert 0.7 * around < between.sum() < 1.1 * around
    assert (exact.body[between] == 1).all()


def test_lost_pixels():
    lens = Lens(160, 120, 150.0, 150.0, 79.5, 59.5)
    camera = SimulatedDepthCamera([plane(1.0)], lens, DepthErrors(dropout=0.1))
    assert 1.0 - camera.take(I, [I]).valid.mean() == pytest.approx(0.1, abs=0.01)
    for z in (0.1, 5.0):  # nearer than near, farther than far
        assert not SimulatedDepthCamera([plane(z)], lens).take(I, [I]).valid.any()
    slanted = SimulatedDepthCamera([plane(1.0, np.radians(75))], lens, DepthErrors(grazing=0.3, dropout=0.0))
    valid, steep = slanted.take(I, [I]).valid, slanted._image.cosine() > 0.3
    assert valid[steep].mean() > 0.95
    assert not valid[~steep].any()


def test_pictures_differ_and_are_the_same_again_by_their_seed():
    one, other = (SimulatedDepthCamera([plane(1.0)], LENS, seed=5) for _ in range(2))
    first = one.take(I, [I]).depth
    assert np.array_equal(first, other.take(I, [I]).depth, equal_nan=True)
    assert not np.array_equal(first, one.take(I, [I]).depth, equal_nan=True)


def test_what_cannot_be_drawn_is_refused():
    with pytest.raises(ValueError, match="1 to 4096"):
        _core.DepthImage(0, 10, 1.0, 1.0, 0.0, 0.0, 0.1)
    with pytest.raises(ValueError, match="must be positive"):
        _core.DepthImage(8, 8, -1.0, 1.0, 0.0, 0.0, 0.1)
    image = _core.DepthImage(8, 8, 9.0, 9.0, 3.5, 3.5, 0.1)
    with pytest.raises(ValueError, match="names a vertex"):
        image.draw(np.zeros((3, 3)), np.array([[0, 1, 3]], np.int32), np.eye(4), 0)
    image.draw(np.full((3, 3), np.nan), np.array([[0, 1, 2]], np.int32), np.eye(4), 0)
    assert (image.object() == -1).all()
