"""Scans of bodies in closed form: error of the surface, of the poses, holes; and views from which none is made."""

import re
import sys

import numpy as np
import pytest

from palpate.base.arrays.rigid import displacement, exp, inverse, rigid, transform
from palpate.base.errors import CloudError, MissingExtraError
from palpate.sensing.around import around, looking_at
from palpate.sensing.depth_camera import Body
from palpate.world import shapes
from palpate.world.clouds import PointCloud
from palpate.world.mesh import Mesh, quiet
from palpate.world.scan import alignment, scan, view

R = np.array([0.06, 0.045, 0.035])  # semi-axes [m]


def ellipsoid_rays(p_WC, n=90):
    """Points (N, 3) in C of an ellipsoid, where rays of a pinhole camera meet it (closed form), and X_WC."""
    X = looking_at(np.asarray(p_WC, float), np.zeros(3))
    u, v = np.meshgrid(np.linspace(-0.22, 0.22, n), np.linspace(-0.22, 0.22, n))
    d = np.stack([u, v, np.ones_like(u)], axis=-1).reshape(-1, 3)
    a, b = (X[:3, 3] / R), (d @ X[:3, :3].T) / R
    A, B, C = (b * b).sum(1), b @ a, a @ a - 1.0
    root = B * B - A * C
    t = (-B - np.sqrt(np.maximum(root, 0.0))) / A
    return (t[:, None] * d)[root > 0.0], X


def ring(noise, n=6, seed=0, height=0.16):
    """Views around the ellipsoid from above and below."""
    rng, clouds, poses = np.random.default_rng(seed), [], []
    for k in range(n):
        angle, z = 2 * np.pi * k / n, height * (1 if k % 2 else -1)
        p, X = ellipsoid_rays([0.28 * np.cos(angle), 0.28 * np.sin(angle), z])
        p *= 1.0 + noise * rng.normal(size=(len(p), 1)) / np.linalg.norm(p, axis=1, keepdims=True)
        clouds.append(PointCloud(p, name=f"view {k}"))
        poses.append(X)
    return clouds, poses


def error(p):
    """Distance (N,) of points near the ellipsoid from it, to first order [m]."""
    return np.abs(np.linalg.norm(p / R, axis=1) - 1.0) / np.linalg.norm(p / R**2, axis=1)


def rms(values):
    return float(np.sqrt(np.square(values).mean()))


def test_surface_of_exact_points_has_no_error_by_its_curvature():
    clouds, poses = ring(0.0)
    found = scan(clouds, poses, align=False, spacing=0.002)
    assert rms(error(found.vertices)) < 3e-5  # smoothing by 2 mm alone would give 2^2 / 35 = 0.11 mm
    assert found.closed
    assert found.mesh().report.watertight
    assert found.mesh().report.volume_m3 == pytest.approx(4 / 3 * np.pi * R.prod(), rel=3e-3)


def test_noise_is_averaged_and_reported():
    clouds, poses = ring(1e-3)
    found = scan(clouds, poses, align=False)
    assert rms(error(found.vertices)) < 0.25e-3
    points = np.concatenate([c.points @ X[:3, :3].T + X[:3, 3] for c, X in zip(clouds, poses, strict=True)])
    assert found.rms == pytest.approx(rms(error(points)), rel=0.05)  # noise along the rays, seen along the normals
    assert found.noise == pytest.approx(rms(error(points)), rel=0.25)
    assert found.outliers < 0.03 * found.points


def test_the_error_of_a_wrong_surface_is_seen():
    clouds, poses = ring(0.0)
    shifted = [pose.copy() for pose in poses]
    shifted[3][:3, 3] += [0.0, 0.0, 0.004]
    found = scan(clouds, shifted, align=False, spacing=0.002)
    assert rms(error(found.vertices)) > 3e-4
    assert found.rms > 3e-4


def test_views_are_aligned_from_rough_poses():
    body = Body("organ", *shapes.organ(6000))
    views = around(body, 8, 0.5e-3, seed=2)
    middle = body.vertices.mean(axis=0)

    def away(poses):
        return [np.linalg.norm(transform(X @ inverse(true), middle) - middle)
                for X, true in zip(poses, views.true, strict=True)]  # fmt: skip

    found = scan(views.clouds, views.stated)
    assert max(away(views.stated)) > 4e-3
    assert max(away(found.poses)) < 0.6e-3
    with quiet():
        assert rms(Mesh(body.vertices, body.triangles).closest(found.vertices)[0]) < 0.5e-3


def test_views_of_a_moving_camera_need_no_poses():
    rng, clouds, poses, first = np.random.default_rng(1), [], [], np.eye(4)
    corner = np.concatenate([np.stack([a, b, 0 * a], 1)[:, order] for order in ([0, 1, 2], [2, 0, 1], [1, 2, 0])
                             for a, b in [rng.uniform(0, 0.3, (2, 6000))]])  # fmt: skip
    for k in range(4):
        X = looking_at(np.array([0.9, 0.7 + 0.02 * k, 0.6 - 0.01 * k]), np.array([0.1, 0.1, 0.1]))
        p = (corner - X[:3, 3]) @ X[:3, :3] + 5e-4 * rng.normal(size=corner.shape)
        clouds.append(PointCloud(p, name=f"view {k}"))
        first = X if k == 0 else first
        poses.append(inverse(first) @ X)
    found = scan(clouds)
    for X, true in zip(found.poses, poses, strict=True):
        assert displacement(true, X) == pytest.approx(np.zeros(6), abs=2e-3)
    assert not found.closed


def test_a_half_seen_body_stays_open_and_its_hole_is_reported():
    p, X = ellipsoid_rays([0.0, 0.05, 0.3])
    found = scan([PointCloud(p)], [X])
    assert not found.closed
    assert not found.mesh().report.watertight
    assert found.holes[0].area > 1e-3
    closed = scan([PointCloud(p)], [X], close=True)
    assert closed.closed
    assert closed.mesh().report.watertight


def test_a_small_hole_is_closed_and_reported_where_it_is():
    clouds, poses = ring(0.0)
    tip = np.array([0.0, 0.0, 0.035])
    cut = []
    for cloud, X in zip(clouds, poses, strict=True):
        p_W = cloud.points @ X[:3, :3].T + X[:3, 3]
        cut.append(PointCloud(cloud.points[np.linalg.norm(p_W - tip, axis=1) > 0.015]))
    found = scan(cut, poses, align=False, spacing=0.002)
    assert found.closed
    assert found.mesh().report.watertight
    assert np.linalg.norm(found.holes[0].centre - tip) < 0.008
    assert 2e-4 < found.holes[0].area < 8e-4  # about pi * 11 mm squared where no point is within reach
    left = scan(cut, poses, align=False, spacing=0.002, close=False)
    assert not left.mesh().report.watertight


def test_flying_pixels_leave_no_trace():
    clouds, poses = ring(5e-4)
    rng = np.random.default_rng(0)
    dirty = [PointCloud(np.r_[c.points, c.points[:150] * rng.uniform(1.02, 1.6, (150, 1))]) for c in clouds]
    found = scan(dirty, poses, align=False)
    assert found.outliers > 0.6 * 150 * len(clouds)
    assert rms(error(found.vertices)) < 0.25e-3


@pytest.mark.parametrize(
    ("clouds", "more", "words"),
    [
        ([], {}, "no view is given"),
        ([np.zeros((5, 3))], {}, "too few"),
        ([np.linspace([0, 0, 0], [1, 1, 1], 400)], {}, "on one line"),
        ([np.ones((400, 3))], {}, "in one place"),
        ([np.random.default_rng(0).random((400, 3))], {"poses": [np.eye(4)] * 2}, "2 poses for 1 view"),
        ([np.random.default_rng(0).random((400, 3))], {"spacing": -1.0}, "a cell of -1 m"),
    ],
)
def test_bad_views_are_refused(clouds, more, words):
    with pytest.raises(CloudError, match=words):
        scan([PointCloud(p) for p in clouds], **more)


def test_views_that_do_not_overlap_are_refused():
    clouds, _ = ring(0.0, n=2)
    far = np.eye(4)
    far[0, 3] = 1.0
    with pytest.raises(CloudError, match=r"view 0: only 0 % of the view lies on the other"):
        scan(clouds, [np.eye(4), far])


@pytest.mark.parametrize("marker", [(0.0, 0.0, 0.0), (0.0, 0.0, 4.0), (0.1, -0.1, 0.3)])
@pytest.mark.parametrize("share", [0.2, 0.85])
def test_markers_of_invalid_pixels_change_nothing(marker, share):
    """Cameras write the origin, a largest range or another constant where they saw nothing."""
    clouds, poses = ring(3e-4, n=3)
    clean = scan(clouds, poses, align=False, spacing=0.003)
    marked = []
    for cloud in clouds:
        count = round(len(cloud) * share / (1.0 - share))
        marked.append(PointCloud(np.vstack([cloud.points, np.tile(marker, (count, 1))]), name=cloud.name))
    found = scan(marked, poses, align=False, spacing=0.003)
    np.testing.assert_array_equal(found.vertices, clean.vertices)
    assert found.outliers > clean.outliers
    with pytest.raises(CloudError, match="of 400 points are measurements"):
        scan([PointCloud(np.vstack([clouds[0].points[:100], np.tile(marker, (300, 1))]), name="a")])


def test_one_view_needs_no_alignment(monkeypatch):
    monkeypatch.setitem(sys.modules, "small_gicp", None)
    p, X = ellipsoid_rays([0.0, 0.05, 0.3])
    assert scan([PointCloud(p)], [X]).doubt == ""
    with pytest.raises(MissingExtraError, match="small_gicp"):
        scan([PointCloud(p), PointCloud(p)])


def test_views_that_do_not_agree_are_doubted():
    """The pose of one view is wrong by 3 mm, against a noise of 0.3 mm; with the right one there is no doubt."""
    clouds, poses = ring(3e-4)
    assert scan(clouds, poses, align=False).doubt == ""
    moved = [p.copy() for p in poses]
    moved[2][:3, 3] += [3e-3, 0.0, 0.0]
    found = scan(clouds, moved, align=False)
    assert "times their noise from the surface, 1.25 at most" in found.doubt
    moved[2][:3, 3] += [0.0, 0.0, 0.012]
    found = scan(clouds, moved, align=False)
    assert re.search(r"% of the points of view \d lie in front of what view \d saw, 3 % at most", found.doubt)


def test_a_surface_coarser_than_its_points_is_doubted():
    clouds, poses = ring(3e-4)
    found = scan(clouds, poses, align=False, spacing=0.012)
    assert "times their noise from the surface, 1.25 at most" in found.doubt


def bumpy(step, n, noise=3e-4, seed=0):
    """Views, by a camera that is carried about them, of three ellipsoids that meet: rays in closed form."""
    rng, clouds, poses = np.random.default_rng(seed), [], []
    parts = [((0, 0, 0), (0.05, 0.035, 0.03)), ((0.03, 0.01, 0.02), (0.012,) * 3), ((-0.02, 0.02, 0.02), (0.01,) * 3)]
    u, v = np.meshgrid(np.linspace(-0.22, 0.22, 100), np.linspace(-0.22, 0.22, 100))
    d = np.stack([u, v, np.ones_like(u)], axis=-1).reshape(-1, 3)
    for k in range(n):
        a = np.radians(step * k)
        X = looking_at(0.28 * np.array([0.6 * np.cos(a), 0.6 * np.sin(a), 0.8]), np.zeros(3))
        t = np.full(len(d), np.inf)
        for c, r in parts:
            o, e = (X[:3, 3] - c) / r, (d @ X[:3, :3].T) / r
            A, B, C = (e * e).sum(1), e @ o, o @ o - 1.0
            root = B * B - A * C
            t = np.where(root > 0.0, np.minimum(t, (-B - np.sqrt(np.maximum(root, 0.0))) / A), t)
        seen = np.isfinite(t)
        p = t[seen, None] * d[seen]
        clouds.append(PointCloud(p + noise * rng.normal(size=(len(p), 1)) * d[seen], name=f"view {k}"))
        poses.append(X)
    return clouds, [inverse(poses[0]) @ X for X in poses]


def apart(clouds, found, poses):
    """Largest rms distance of a view's points from where they belong [m]."""
    return max(np.linalg.norm(transform(X, c.points) - transform(true, c.points), axis=1).mean()
               for c, X, true in zip(clouds, found, poses, strict=True))  # fmt: skip


@pytest.mark.parametrize("step", [8.0, 20.0])
def test_a_camera_that_is_carried_about_an_organ_needs_no_poses(step):
    """From where the last view was seen alone, steps of 20 degrees end 10 mm off, and the surface is wrong by them."""
    clouds, poses = bumpy(step, 4)
    found = scan(clouds)
    assert apart(clouds, found.poses, poses) < 0.6e-3
    assert found.doubt == ""
    assert found.spacing < 2e-3  # cells follow the density of all views together


def test_the_drift_of_a_full_turn_is_closed():
    """The last view shows what the first one did: a drift of 12 mm is spread over the turn."""
    clouds, poses = bumpy(24.0, 15)
    views = [view.view(c.points, np.zeros(3), 3e-4, 3e-3, c.name) for c in clouds]
    drift = [X @ rigid(exp([0.0, 0.006 * k, 0.0]), [0.0008 * k, 0.0, 0.0]) for k, X in enumerate(poses)]
    closed = alignment.closed(views, drift, 0.012)
    assert closed is not None
    assert apart(clouds[-1:], drift[-1:], poses[-1:]) > 9e-3
    assert apart(clouds[-1:], closed[-1:], poses[-1:]) < 3e-3
    other = alignment.closed(views[:8], drift[:8], 0.012)  # half a turn: the last view shows the other side
    assert other is None or apart(clouds[7:8], other[7:], poses[7:8]) < apart(clouds[7:8], drift[7:8], poses[7:8])


@pytest.mark.parametrize("close", [None, False])
def test_triangles_are_counter_clockwise_seen_from_outside(close):
    vertices, triangles = shapes.organ(4000)
    views = around(Body("organ", vertices, triangles), 12, 3e-4, 1)
    found = scan(list(views.clouds), list(views.stated), close=close)
    a, b, c = (found.vertices[found.triangles[:, k]] for k in range(3))
    outward = ((a + b + c) / 3.0 - vertices.mean(axis=0)) * np.cross(b - a, c - a)
    assert (outward.sum(axis=1) > 0.0).mean() > 0.98
    if found.closed:
        assert float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum()) > 0.0  # the volume
