"""Cones, meshes, clouds, grids and combinations: closed forms, sampling, trimesh, finite differences."""

import numpy as np
import pytest
import trimesh
from geometry_queries import assert_sound, poses, query_points, slope
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from palpate import _core, _guidance
from palpate.scene.guidance.curve import path
from palpate.world.shapes import analytic

POINTS = np.random.default_rng(5).uniform(-0.08, 0.08, (3000, 3))
APEX, AXIS, HALF = np.array([0.01, 0.0, -0.02]), np.array([0.2, -0.1, 1.0]), 0.4
VERTICES, TRIANGLES = analytic.Box((0.06, 0.04, 0.05)).mesh(12)
WAY = [[-0.05, 0, 0], [-0.02, 0.02, 0.01], [0.01, -0.01, 0.02], [0.05, 0.01, 0]]


def surface(core):
    return _guidance.SurfaceGeometry(core)


def translated(geometry, x):
    X = np.eye(4)
    X[:3, 3] = x
    return _guidance.PlacedGeometry(geometry, X)


BALL, OTHER = surface(_core.Sphere(0.03)), translated(surface(_core.Sphere(0.02)), [0.03, 0.0, 0.0])
EVERY = {
    "point": _guidance.PointGeometry(),
    "line": _guidance.LineGeometry(np.zeros(3), np.array([0.01, 0.05, 0])),
    "plane": surface(_core.Plane()),
    "sphere": BALL,
    "box": surface(_core.Box(np.array([0.06, 0.04, 0.05]))),
    "cylinder": surface(_core.Cylinder(0.02, 0.05)),
    "capsule": surface(_core.Capsule(0.02, 0.05)),
    "mesh": surface(_core.Mesh(VERTICES, TRIANGLES)),
    "cloud": surface(_core.Cloud(np.ascontiguousarray(VERTICES), 0.004)),
    "path": path(WAY),
    "tube": _guidance.OffsetGeometry(path(WAY), 0.005),
    "cone": _guidance.ConeGeometry(APEX, AXIS, HALF),
    "grown": _guidance.OffsetGeometry(BALL, 0.01),
    "shrunk": _guidance.OffsetGeometry(BALL, -0.01),
    "union": _guidance.CombinedGeometry("union", [BALL, OTHER]),
    "intersection": _guidance.CombinedGeometry("intersection", [BALL, OTHER]),
    "difference": _guidance.CombinedGeometry("difference", [BALL, OTHER]),
    "blended": _guidance.CombinedGeometry("union", [BALL, OTHER], 0.01),
}


@pytest.mark.parametrize("name", EVERY)
def test_results_are_consistent_and_the_normal_is_the_distance_gradient(name):
    geometry = EVERY[name]
    q = query_points(geometry, POINTS)
    assert_sound(q)
    h = 1e-7
    offsets = [query_points(geometry, POINTS + e)["normal"] for e in h * np.r_[np.eye(3), -np.eye(3)]]
    smooth = np.linalg.norm(np.array(offsets) - q["normal"], axis=2).max(axis=0) < 1e-3
    assert smooth.mean() > 0.99
    gradient = slope(geometry, POINTS, h)[smooth]
    length = np.linalg.norm(gradient, axis=1)
    if name == "blended":
        assert (length < 1.0 + 1e-6).all()
        assert (length > 0.0).all()
    else:
        np.testing.assert_allclose(length, 1.0, atol=2e-6)
    np.testing.assert_allclose(gradient / length[:, None], q["normal"][smooth], atol=2e-5)


@pytest.mark.parametrize("name", EVERY)
def test_nearest_point_lies_on_the_geometry(name):
    if name in ("union", "difference", "intersection", "blended"):
        return  # the distance is a bound; the point may lie inside another part
    q = query_points(EVERY[name], POINTS)
    np.testing.assert_allclose(abs(query_points(EVERY[name], q["point"])["distance"]), 0.0, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(POINTS - q["point"], axis=1), abs(q["distance"]), atol=1e-9)


@pytest.mark.parametrize("name", EVERY)
def test_queries_are_independent_of_the_frame(name):
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = Rotation.from_rotvec([0.4, -1.1, 0.7]).as_matrix(), [0.3, -0.2, 0.1]
    one = query_points(EVERY[name], POINTS)
    other = _guidance.PlacedGeometry(EVERY[name], X).query(X @ poses(POINTS), np.zeros(len(POINTS)))
    np.testing.assert_allclose(other["distance"], one["distance"], atol=1e-12)
    same = np.linalg.norm(other["normal"] - one["normal"] @ X[:3, :3].T, axis=1) < 1e-6
    assert same.mean() > 0.999, "except for points with two nearest points within rounding"
    np.testing.assert_allclose(other["point"][same], one["point"][same] @ X[:3, :3].T + X[:3, 3], atol=1e-9)


@settings(max_examples=40)
@example(p=[1e-320, -3e-320, 2e-162], t=0.0)
@example(p=[1.5e-162, 1e-162, 0.0], t=0.0)
@given(p=st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=3, max_size=3), t=st.floats(-1e300, 1e300))
def test_every_finite_pose_has_a_finite_result(p, t):
    for geometry in EVERY.values():
        assert_sound(query_points(geometry, [p, np.array(p) * 1e-300], t))


def test_cone_distance_has_the_closed_form():
    """Reference: the nearest of 400 000 points of the cone, and the sign from the angle at the apex."""
    axis = AXIS / np.linalg.norm(AXIS)
    side = np.linspace(0, 0.3, 2000)[:, None, None]
    around = np.linspace(0, 2 * np.pi, 200)[None, :, None]
    x = np.cross(axis, [1.0, 0, 0])
    x /= np.linalg.norm(x)
    ring = np.cos(around) * x + np.sin(around) * np.cross(axis, x)
    places = (APEX + side * (np.cos(HALF) * axis + np.sin(HALF) * ring)).reshape(-1, 3)
    q = query_points(EVERY["cone"], POINTS)
    found = cKDTree(places).query(POINTS)[0]
    out = POINTS - APEX
    inside = out @ axis > np.cos(HALF) * np.linalg.norm(out, axis=1)
    assert 0.02 < inside.mean() < 0.5
    np.testing.assert_array_equal(q["distance"] < 0, inside)
    assert (abs(q["distance"]) <= found + 1e-12).all()
    np.testing.assert_allclose(found, abs(q["distance"]), atol=2e-3)
    np.testing.assert_allclose(q["attitude"][:, :, 2], np.tile(-axis, (len(POINTS), 1)), atol=1e-14)


def test_mesh_distance_agrees_with_trimesh():
    corners = VERTICES[TRIANGLES]
    each = [trimesh.triangles.closest_point(np.tile(c, (len(POINTS), 1, 1)), POINTS) for c in corners]
    found = np.linalg.norm(np.array(each) - POINTS, axis=2).min(axis=0)
    np.testing.assert_allclose(abs(query_points(EVERY["mesh"], POINTS)["distance"]), found, atol=1e-9)
    exact = query_points(EVERY["box"], POINTS)
    np.testing.assert_allclose(query_points(EVERY["mesh"], POINTS)["distance"], exact["distance"], atol=1e-12)
    outside = exact["distance"] > 1e-6
    np.testing.assert_allclose(
        query_points(EVERY["mesh"], POINTS)["normal"][outside], exact["normal"][outside], atol=1e-6
    )


@settings(max_examples=25)
@given(seed=st.integers(0, 2**32 - 1), n=st.integers(1, 500), radius=st.floats(1e-4, 0.01))
def test_cloud_distance_agrees_with_a_k_d_tree(seed, n, radius):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(n, 3)) * 0.05
    where = rng.normal(size=(200, 3)) * 0.08
    q = query_points(surface(_core.Cloud(points, radius)), where)
    found, which = cKDTree(points).query(where)
    np.testing.assert_allclose(q["distance"], found - radius, atol=1e-14)
    np.testing.assert_allclose(q["normal"], (where - points[which]) / found[:, None], atol=1e-9)


def sphere(centre, radius):
    return lambda p: np.linalg.norm(p - centre, axis=1) - radius


A, B = sphere(np.zeros(3), 0.03), sphere(np.array([0.03, 0, 0]), 0.02)


@pytest.mark.parametrize(
    ("kind", "value", "exact_where"),
    [("union", lambda a, b: np.minimum(a, b), 1), ("intersection", np.maximum, -1),
     ("difference", lambda a, b: np.maximum(a, -b), -1)],
)  # fmt: skip
def test_combinations_have_the_right_inside_and_a_lower_bound_of_the_distance(kind, value, exact_where):
    """Reference: points sampled on the boundary; exact on one side, a lower bound on the other."""
    where = np.random.default_rng(2).uniform(-0.03, 0.05, (3000, 3))
    q = query_points(EVERY[kind], where)
    np.testing.assert_allclose(q["distance"], value(A(where), B(where)), atol=1e-15)
    rng = np.random.default_rng(0)
    directions = rng.normal(size=(200_000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    boundary = np.concatenate([0.03 * directions, 0.02 * directions + [0.03, 0, 0]])
    boundary = boundary[abs(value(A(boundary), B(boundary))) < 1e-9]
    found = cKDTree(boundary).query(where)[0]
    assert (abs(q["distance"]) <= found + 1e-12).all()
    exact = np.sign(q["distance"]) == exact_where
    assert exact.sum() > 50
    np.testing.assert_allclose(abs(q["distance"][exact]), found[exact], atol=6e-4)


@given(blend=st.floats(1e-4, 0.02), seed=st.integers(0, 2**32 - 1))
def test_blend_smooths_the_normal_and_adds_at_most_a_quarter_of_its_width(blend, seed):
    sharp = EVERY["union"]
    soft = _guidance.CombinedGeometry("union", [BALL, OTHER], blend)
    filled = query_points(sharp, POINTS[:500])["distance"] - query_points(soft, POINTS[:500])["distance"]
    assert (filled >= -1e-15).all()
    assert (filled <= blend / 4 + 1e-15).all()
    line = np.linspace(0, 1, 4000)[:, None] * [0.02, 0, 0] + [0.012, 0.03, np.random.default_rng(seed).normal() * 1e-3]
    step = [np.linalg.norm(np.diff(query_points(g, line)["normal"], axis=0), axis=1).max() for g in (sharp, soft)]
    assert step[0] > 0.3
    assert step[1] < 5e-6 / blend * 4 + 1e-3


def test_velocity_of_a_combination_is_that_of_the_nearest_part():
    frame = _core.MotionFrame(np.eye(4), _core.Motion(v=np.array([0.01, 0.02, 0.0]), w=np.array([0, 0, 1.0])))
    moving = _guidance.PlacedGeometry(BALL, np.eye(4), frame)
    both = _guidance.CombinedGeometry("union", [moving, translated(BALL, [0.0, 0, 0.5])])
    near, far = query_points(both, [[0.06, 0, 0]], 0.0), query_points(both, [[0.06, 0, 0.5]], 0.0)
    np.testing.assert_allclose(near["velocity"][0], [0.01, 0.05, 0], atol=1e-15)
    np.testing.assert_allclose(far["velocity"][0], 0.0)
    grown = query_points(_guidance.OffsetGeometry(moving, 0.02), [[0.06, 0, 0]], 0.0)
    np.testing.assert_allclose(grown["velocity"][0], [0.01, 0.07, 0], atol=1e-15)
    np.testing.assert_allclose(grown["point"][0], [0.05, 0, 0], atol=1e-15)


@pytest.mark.parametrize("name", ["sphere", "mesh", "tube", "blended"])
def test_distance_rate_is_minus_the_normal_velocity_of_the_surface(name):
    """For a point at rest, d/dt of the distance is minus the surface's velocity along the normal."""
    wave = _core.Wave(shift=np.array([0.005, 0, 0.01]), turn=np.array([0.2, 0.1, 0.0]), period=1.5)
    frame = _core.MotionFrame(np.eye(4), _core.Motion(w=np.array([0, 0.3, 0]), waves=[wave]))
    moving = _guidance.PlacedGeometry(EVERY[name], np.eye(4), frame)
    q, h = query_points(moving, POINTS[:400], 0.4), 1e-6
    rate = (
        query_points(moving, POINTS[:400], 0.4 + h)["distance"]
        - query_points(moving, POINTS[:400], 0.4 - h)["distance"]
    ) / (2 * h)
    expected = -(q["velocity"] * q["normal"]).sum(axis=1)
    regular = abs((slope(moving, POINTS[:400], t=0.4) * q["normal"]).sum(axis=1) - 1) < 1e-6
    assert regular.mean() > 0.5
    np.testing.assert_allclose(rate[regular], expected[regular], atol=1e-7)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: _guidance.ConeGeometry(APEX, 0 * AXIS, 0.3), "a cone needs a finite apex, and a mouth apart from it"),
        (
            lambda: _guidance.ConeGeometry(APEX, AXIS, 2.0),
            "half the angle of a cone must be above 0 and at most pi / 2",
        ),
        (lambda: _guidance.OffsetGeometry(EVERY["path"], 0.0), "needs a margin above zero"),
        (lambda: _guidance.OffsetGeometry(BALL, np.nan), "a finite margin"),
        (lambda: _guidance.CombinedGeometry("union", []), "a combination needs parts"),
        (
            lambda: _guidance.CombinedGeometry("minus", [BALL]),
            "kind must be .union., .intersection. or .difference.; got .minus.",
        ),
        (lambda: _guidance.CombinedGeometry("difference", [EVERY["path"], BALL]), "cannot be cut; give it a margin"),
        (lambda: _core.Cloud(np.zeros((0, 3)), 0.01), "a cloud needs points"),
        (lambda: _core.Cloud(np.full((1, 3), np.nan), 0.01), "points of a cloud must be finite"),
        (lambda: _core.Cloud(np.zeros((1, 3)), 0.0), "radius of a cloud's points must be a positive length"),
    ],
)
def test_invalid_geometries_are_reported(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_open_mesh_has_an_inside_only_with_a_margin():
    sheet = surface(_core.Mesh(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.0]]), np.array([[0, 1, 2]], np.int32)))
    shell = _guidance.OffsetGeometry(sheet, 0.1)
    assert not sheet.solid
    assert shell.solid
    np.testing.assert_allclose(query_points(shell, [[0.2, 0.2, 0.05], [0.2, 0.2, -0.3]])["distance"], [-0.05, 0.2])
