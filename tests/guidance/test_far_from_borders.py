"""Far from its border a fixture on a mesh uses a lower bound of the distance: sound, and without effect on the motion.

The exact search visits nearly all triangles in the middle of a round cavity. The bound must have the right sign there,
must not exceed the true distance, and must leave the tool's goal as it is.
"""

import numpy as np
import pytest
from brute_force import distance_by_segments_and_planes
from effort import examples
from geometry_queries import assert_sound, poses
from hypothesis import given, settings
from hypothesis import strategies as st

from palpate import _core, _guidance
from palpate.world.mesh import Mesh
from palpate.world.shapes.analytic import SHAPES
from palpate.world.shapes.organs import organ
from palpate_lab.verify.bench.guidance import tube

FAR = 15.0 / 16.0


def shell(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """A closed shape of two shells with a thin wall: inside, outside, and in between lie close together."""
    v, t = SHAPES["sphere"].mesh(1500)
    scale = rng.uniform(0.6, 1.4, 3)
    inner = (0.9 + 0.09 * rng.uniform()) * v
    return np.concatenate([v, inner]) * scale, np.concatenate([t, t[:, ::-1] + len(v)]).astype(np.int32)


@settings(max_examples=examples(25), deadline=None)
@given(seed=st.integers(0, 2**32 - 1), kind=st.sampled_from(["shell", "torus", "tube", "organ"]))
def test_bound_has_the_right_sign_and_never_exceeds_the_distance(seed, kind):
    rng = np.random.default_rng(seed)
    makers = {"shell": lambda: shell(rng), "tube": lambda: tube(1500), "organ": lambda: organ(2000)}
    v, t = makers.get(kind, lambda: SHAPES["torus"].mesh(1500))()
    mesh = Mesh(v, t)
    size = np.abs(v - v.mean(axis=0)).max()
    points = v.mean(axis=0) + size * rng.uniform(-1.5, 1.5, (60, 3))
    points[:20] = v.mean(axis=0) + 1e-3 * size * rng.normal(size=(20, 3))
    within = size * 10.0 ** rng.uniform(-3, 0)
    truth = distance_by_segments_and_planes(mesh.vertices, mesh.triangles, points)
    exact, q = (_guidance.SurfaceGeometry(mesh.core).query(poses(points), np.zeros(60), w) for w in (np.inf, within))
    assert_sound(q)
    np.testing.assert_array_equal(np.sign(q["distance"]), np.sign(exact["distance"]))
    bound, near = np.abs(q["distance"]), truth <= within
    np.testing.assert_allclose(bound[near], truth[near], rtol=1e-9, atol=1e-12 * size)
    assert (bound[~near] <= truth[~near] * (1.0 + 1e-9)).all()
    assert (bound[~near] >= np.maximum(FAR * truth[~near], within) * (1.0 - 1e-9)).all()
    on_mesh = distance_by_segments_and_planes(mesh.vertices, mesh.triangles, q["point"])
    np.testing.assert_allclose(on_mesh, 0.0, atol=1e-9 * size)
    for kernel in ("avx2", "portable") if _core.bvh_has_avx2() else ("portable",):
        found = mesh.core.closest_by_kernel(points, kernel, within)
        np.testing.assert_allclose(found[near], truth[near], rtol=1e-9, atol=1e-12 * size)
        assert (truth[~near] >= np.maximum(FAR * found[~near], within) * (1.0 - 1e-9)).all()


def exact_fixture(geometry: _guidance.Geometry, **policy: float) -> _guidance.Geometry:
    """The same geometry as a difference with a distant ball: combinations always ask for exact distances."""
    X = np.eye(4)
    X[0, 3] = 100.0
    away = _guidance.PlacedGeometry(_guidance.SurfaceGeometry(_core.Sphere(0.01)), X)
    return _guidance.CombinedGeometry("difference", [geometry, away])


@pytest.mark.parametrize("law", ["spring", "potential", "admittance", "optimise"])
@pytest.mark.parametrize("hard", [True, False])
@pytest.mark.parametrize("reach", [0.005, 0.015], ids=["at the wall", "far beyond the wall"])
def test_motion_and_force_are_those_of_exact_distances(law, hard, reach):
    """A tool that wanders through a tube, along its middle line and against its wall, or deep into it."""
    geometry = _guidance.SurfaceGeometry(Mesh(*tube(4000)).core)
    rng = np.random.default_rng(4)
    t = np.arange(3000) * 1e-3
    wander = np.array([np.sin(2 * np.pi * f * t + phase) for f, phase in rng.uniform(0.2, 3.0, (3, 2))]).T
    p = np.array([reach, reach, 0.04]) * (t / t[-1])[:, None] * wander
    goals, wrenches, gaps = [], [], []
    for shape in (geometry, exact_fixture(geometry)):
        policy, options = _core.Policy(), _core.GuidanceLawOptions()
        policy.hard, options.range = hard, 1e-3
        stage = _guidance.Guidance()
        stage.take(
            _guidance.Fixtures(
                [_guidance.Fixture("tube", shape, "keep-in", law=law, law_options=options, policy=policy)]
            )
        )
        outs = [stage.step(i * 1e-3, X, np.zeros(6), X) for i, X in enumerate(poses(p))]
        goals.append([out["X_WT_goal"] for out in outs])
        wrenches.append([out["F_T_W"] for out in outs])
        gaps.append([out["gap"] for out in outs])
    np.testing.assert_allclose(*goals, atol=1e-9)
    np.testing.assert_allclose(*wrenches, atol=1e-7)
    assert np.min(gaps[1]) < (-5e-3 if reach > 0.01 else 0.0), "control: the tool was at the wall, or far beyond it"
    assert np.max(gaps[1]) > 3.5e-3, "control: the tool was on the middle line"
    assert np.max(np.abs(wrenches)) > 0.3 or law == "admittance", "control: the tool pushed the wall"
    assert np.max(np.abs(np.subtract(*gaps))) > 1e-6, "control: the bound was used"
