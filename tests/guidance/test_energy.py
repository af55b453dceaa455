"""Springs are conservative: work on closed loops of poses, and the wrench against energy differences."""

import itertools

import numpy as np
import pytest
from fixtures import Stage, fixture, placed, plane, pose
from scipy.spatial.transform import Rotation

from palpate import _core, _guidance
from palpate.scene.guidance.curve import path
from palpate.world.shapes import analytic

AROUND = 0.01
"""Radius of the averaging of normals [m]."""
EVEN = {"K": 300.0, "B": 0.0, "B_turn": 0.0, "range": 0.05, "range_turn": 2.0, "force": 1e3, "moment": 1e3}


def ring(radius):
    a = np.linspace(0.0, 2 * np.pi, 24, endpoint=False)
    return path(np.c_[radius * np.cos(a), radius * np.sin(a), 0.1 * radius * np.sin(2 * a)], closed=True)


def turned_path(radius):
    """A recorded path with the tool's attitude at every waypoint."""
    a = np.linspace(0.0, np.pi, 12)
    R = Rotation.from_rotvec(np.c_[0.5 * np.sin(a), 0.3 * a, 0.4 * np.cos(a)]).as_matrix()
    return path(np.c_[radius * np.cos(a), radius * np.sin(a), 0.2 * radius * a], R)


def shifted(geometry, x):
    return _guidance.PlacedGeometry(geometry, pose((x, 0.0, 0.0)))


BALL = _guidance.SurfaceGeometry(_core.Sphere(0.02))
MESH = _guidance.SurfaceGeometry(_core.Mesh(*analytic.Box((0.06, 0.04, 0.05)).mesh(12)))
GEOMETRIES = {  # geometry, and a point near it [m]
    "point": (_guidance.PointGeometry(), (0.02, 0.01, 0.0)),
    "line": (_guidance.LineGeometry(np.zeros(3), np.array([0.0, 0.01, 0.1]), True), (0.02, 0.01, 0.03)),
    "ring of 15 mm": (ring(0.015), (0.024, 0.002, 0.018)),
    "ring of 40 mm": (ring(0.04), (0.036, 0.02, 0.022)),
    "recorded path": (turned_path(0.03), (0.01, 0.035, 0.03)),
    "ball": (BALL, (0.02, 0.015, 0.01)),
    "edge of a mesh": (MESH, (0.042, 0.032, 0.0)),
    "corner of a mesh": (MESH, (0.042, 0.032, 0.037)),
    "cone": (_guidance.ConeGeometry(np.zeros(3), np.array([0.2, -0.1, 1.0]), 0.4), (0.03, 0.02, 0.02)),
    "crease, blended": (
        _guidance.CombinedGeometry("union", [shifted(BALL, -0.014), shifted(BALL, 0.014)], 0.02),
        (0.0, 0.024, 0.001),
    ),
}
ROLES = {
    "guide": ("guide", {}),
    "forbid": ("forbid", {"margin": 0.04}),
    "rcm": ("rcm", {"margin": 0.0005}),
    "orient along": ("orient", {}),
    "orient against the normal": ("orient", {"target": "normal", "angle": 0.05}),
    "orient as the frame": ("orient", {"target": "frame"}),
}
MEANT = [(role, name) for role in ROLES for name in GEOMETRIES if role != "rcm" or name == "point"]
TILT = Rotation.from_rotvec([0.9, 0.5, -0.2])


def loop(middle, radius, n=400, tilt=0.2):
    """Poses (n + 1, 4, 4) on a closed path of position and attitude around `middle`."""
    s = np.linspace(0.0, 2 * np.pi, n + 1)
    X = np.tile(np.eye(4), (n + 1, 1, 1))
    X[:, :3, 3] = middle + radius * np.c_[np.cos(s), np.sin(s), np.sin(2 * s + 0.5)]
    X[:, :3, :3] = (Rotation.from_rotvec(tilt * np.c_[np.sin(s), np.cos(2 * s), np.sin(s + 1.0)]) * TILT).as_matrix()
    return X


def displacement(X):
    """(n, 6) position difference [m] and rotation vector [rad] from pose to pose."""
    R = Rotation.from_matrix(X[:, :3, :3])
    return np.hstack([np.diff(X[:, :3, 3], axis=0), (R[1:] * R[:-1].inv()).as_rotvec()])


def work(F, X):
    """(net work, exchanged energy) on the path [J], by the trapezoidal rule."""
    each = (0.5 * (F[1:] + F[:-1]) * displacement(X)).sum(axis=1)
    return each.sum(), np.abs(each).sum()


@pytest.mark.parametrize("radius", [0.002, 0.004])
@pytest.mark.parametrize(("role", "name"), MEANT)
def test_fixture_does_no_work_on_a_closed_loop_of_poses(role, name, radius):
    geometry, middle = GEOMETRIES[name]
    f = fixture(geometry, ROLES[role][0], role_=ROLES[role][1], law_=EVEN)
    X = loop(np.array(middle), radius)
    F = np.array([f.evaluate(x)["F"] for x in X])
    earned, exchanged = work(F, X)
    assert exchanged > 1e-6, "control: the fixture pulls"
    assert abs(earned) < 2e-4 * exchanged


@pytest.mark.parametrize("law", ["spring", "potential", "optimise"])
@pytest.mark.parametrize(("role", "name"), MEANT)
def test_wrench_is_the_gradient_of_the_stored_energy(role, name, law):
    geometry, middle = GEOMETRIES[name]
    f = fixture(geometry, ROLES[role][0], law, role_=ROLES[role][1], law_=EVEN)
    h = 1e-5
    for X in loop(np.array(middle), 0.003, n=7)[:-1]:
        near, y = np.tile(X, (12, 1, 1)), np.r_[h * np.eye(6), -h * np.eye(6)]
        near[:, :3, 3] += y[:, :3]
        near[:, :3, :3] = (Rotation.from_rotvec(y[:, 3:]) * Rotation.from_matrix(X[:3, :3])).as_matrix()
        U = [f.evaluate(one)["U"] for one in near]
        slope = (np.array(U[:6]) - U[6:]) / (2 * h)
        np.testing.assert_allclose(f.evaluate(X)["F"], -slope, atol=2e-4 * np.abs(slope).max() + 1e-7)


@pytest.mark.parametrize("hard", [False, True])
@pytest.mark.parametrize(
    ("geometry", "role", "middle"),
    [
        (ring(0.03), "orient", (0.028, 0.004, 0.004)),
        (placed(_guidance.PointGeometry()), "rcm", (0.02, 0.015, 0.01)),
    ],
    ids=["orient along a ring", "rcm"],
)
def test_stage_gains_no_energy_on_a_closed_loop(geometry, role, middle, hard):
    """Soft fixtures up to rounding and rates, hard ones up to second order of the correction; damping dissipates."""
    stage = Stage(fixture(geometry, role, law_={"B": 0.0, "B_turn": 0.0}, hard=hard))
    X = loop(np.array(middle), 0.004, n=4000)
    stage.settle(X[0], 3000)
    F = np.array([stage.step(x)["F_T_W"] for x in X])
    earned, exchanged = work(F, X)
    assert exchanged > 1e-4, "control: the fixture pulls"
    assert earned < (0.03 if hard else 2e-3) * exchanged, f"{1e3 * earned:.3f} of {1e3 * exchanged:.3f} mJ"


def test_rotating_frame_gives_the_full_drift():
    """The drift is the time derivative of the gap, also for roles whose target depends on the position."""
    motion = _core.Motion(w=np.array([0.3, -0.5, 0.8]), v=np.array([0.02, 0.01, -0.03]))
    for role in ("guide", "rcm", "orient"):
        f = fixture(placed(_guidance.PointGeometry() if role == "rcm" else ring(0.03), motion=motion), role)
        X, h = loop(np.array((0.02, 0.02, 0.01)), 0.002, n=3)[0], 1e-5
        numeric = (f.evaluate(X, 0.2 + h)["gap"] - f.evaluate(X, 0.2 - h)["gap"]) / (2 * h)
        assert f.evaluate(X, 0.2)["drift"] == pytest.approx(numeric, rel=1e-4), role


def test_constraint_gradient_vanishes_where_the_normals_disagree():
    """Near a line the normal changes arbitrarily fast; the mean of the surrounding normals is smooth and vanishes."""
    f = fixture(
        placed(_guidance.LineGeometry(np.zeros(3), np.array([0.1, 0.0, 0.0]), True)),
        "orient",
        role_={"target": "normal"},
    )
    for y in (1e-3, 1e-4, 1e-6, 1e-9):
        along = f.evaluate(pose((0.0, y, 0.0), TILT.as_matrix()))["along"]
        assert np.linalg.norm(along[3:]) == pytest.approx(y / AROUND)
        assert np.linalg.norm(along[:3]) <= np.sqrt(3.0) / AROUND * np.hypot(1.0, np.pi)


@pytest.mark.parametrize("priorities", [(1, 0), (0, 1), (0, 0)])
@pytest.mark.parametrize("seed", range(3))
def test_loops_over_two_walls_of_different_priority_hand_out_no_energy(priorities, seed):
    """The lower wall loses what opposes the higher one; what it thus stores for nothing it never pays back."""
    rng = np.random.default_rng(seed)
    normals = ((0.0, 0.0, 1.0), (0.8, 0.0, -0.6))
    walls = []
    for k, n in enumerate(normals):
        R = Rotation.align_vectors([n], [[0.0, 0.0, 1.0]])[0].as_matrix()
        walls.append(fixture(plane(pose(R=R)), name=f"wall {k}", law_={"B": 0.0}, priority=priorities[k]))
    free = [0.006, 0.0, 0.002]
    inner = rng.uniform(-0.004, 0.004, (5, 3))
    knots = np.array([free, *inner, free])
    way = np.concatenate([np.linspace(a, b, 400, endpoint=False) for a, b in itertools.pairwise(knots)] + [knots[-1:]])
    for tips in (way, way[::-1]):
        stage = Stage(*walls)
        stage.settle(tips[0], 200)
        F = np.array([stage.step(p)["F_T_W"][:3] for p in tips])
        done = -np.cumsum((0.5 * (F[1:] + F[:-1]) * np.diff(tips, axis=0)).sum(axis=1))
        assert done[-1] > -2e-3 * done.max()


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("authority", [0.3, 0.49, 0.8, 1.0])
@pytest.mark.parametrize("hard", [False, True])
def test_a_border_that_acts_in_part_counts_the_side_to_which_it_moves_the_tool(side, authority, hard):
    """Loops in a box, across the places where another face becomes the nearer one; the goal keeps its side.

    The allowed violation was that of the nearer face: with an authority of 0.49, such loops returned 5.7 mJ each.
    """
    box = placed(_guidance.SurfaceGeometry(_core.Box(np.array([0.048, 0.072, 0.048]))))
    ring = 1e-3 * np.array([[-16, -28.6, 0], [-10.7, -28.3, 0], [-8, -23, 0], [-9.4, -21, 0], [-18.5, -25, 0]])
    start = np.array([-0.016, -0.038, 0.0])
    corners = [start, *np.tile(ring if side > 0 else np.roll(ring[::-1], 1, axis=0), (8, 1)), ring[0], start]
    tips = np.concatenate([np.linspace(a, b, 100) for a, b in itertools.pairwise(corners)])
    law = {"K": 735.0, "B": 0.0, "force": 4.8}
    stage = Stage(fixture(box, "forbid", "optimise", law_=law, authority=authority, hard=hard))
    stage.settle(start, 200)
    F = np.array([stage.step(p)["F_T_W"][:3] for p in tips])
    done = -np.cumsum((0.5 * (F[1:] + F[:-1]) * np.diff(tips, axis=0)).sum(axis=1))
    assert done.max() > 5e-3, "control: the fixture acts"
    assert done.min() > -3e-3 * done.max()


def across(*corners, cycles=4, step=1e-4):
    """Places (n, 3) on a closed way over corners [mm], several times, and the number in a cycle."""
    way = 1e-3 * np.array([*corners, corners[0]])
    pieces = [
        np.linspace(a, b, 2 + int(np.linalg.norm(b - a) / step), endpoint=False) for a, b in itertools.pairwise(way)
    ]
    once = np.concatenate(pieces)
    return np.concatenate([*[once] * cycles, way[-1:]]), len(once)


def works_of_cycles(fixtures, tips, n):
    """Work of the hand in each cycle [J], at rest at every place."""
    stage = Stage(*fixtures)
    F = np.array([stage.settle(p, 30)["F_T_W"][:3] for p in tips])
    return np.diff(np.append(0.0, -np.cumsum((0.5 * (F[1:] + F[:-1]) * np.diff(tips, axis=0)).sum(axis=1)))[::n])


def cylinder(radius, at, rpy):
    X = pose(1e-3 * np.array(at), Rotation.from_euler("xyz", rpy, degrees=True).as_matrix())
    return placed(_guidance.SurfaceGeometry(_core.Cylinder(radius, 0.05)), X)


@pytest.mark.parametrize("backwards", [False, True])
def test_hard_fixtures_that_contradict_each_other_are_no_source(backwards):
    """Their goal wanders without work of the hand: such loops returned 1.3 to 2.6 mJ in every cycle (seed 80228)."""
    guide = cylinder(0.01561, (-21.1, 8.09, -5.07), (-78.45387, 147.73234, 164.80258))
    room = cylinder(0.005361, (-17.84, -2.18, 2.85), (-149.11435, -164.06259, -169.61352))
    law = {"B": 0.0, "K": 500.0}
    fixtures = [
        fixture(guide, "guide", name="guide", law_=law, hard=True),
        fixture(room, "keep-in", name="room", law_=law, role_={"margin": 0.0015}, hard=True),
    ]
    corners = [(-12.44, -3.5, 9.48), (-12.24, -0.51, 3.39), (-8.91, -4.64, 3.79), (-10.71, -5.52, 9.71)]
    tips, n = across(*(corners[::-1] if backwards else corners))
    works = works_of_cycles(fixtures, tips, n)
    assert works[1:].min() > -3e-5, f"{1e6 * works} uJ"


@pytest.mark.parametrize("backwards", [False, True])
def test_a_ramp_that_follows_the_hand_earns_nothing_from_a_joint_law(backwards):
    """The correction of all was counted as put in whenever the hand came into the ramp: .4 of .7 mJ (seed 80174)."""
    law = {"B": 0.0, "K": 300.0, "force": 3.0}
    guide = cylinder(0.02093, (-28.49, 25.06, 12.49), (-87.41289, -147.29132, 16.38355))
    wall = cylinder(0.02368, (1.27, -3.82, 20.26), (140.66576, 44.01324, -30.66023))
    ramp = [_core.Ramp("distance", 0.002, 0.0)]
    fixtures = [
        fixture(guide, "guide", "optimise", name="guide", law_=law, ramps=ramp),
        fixture(wall, "forbid", "optimise", name="wall", law_=law | {"K": 600.0}),
    ]
    corners = [(-17.79, 9.83, 30.87), (-13.28, 9.02, 30.9), (-17.42, 9.85, 27.3)]
    tips, n = across(*(corners[::-1] if backwards else corners))
    works = works_of_cycles(fixtures, tips, n)
    assert works[1:].min() > -5e-6, f"{1e6 * works} uJ"
