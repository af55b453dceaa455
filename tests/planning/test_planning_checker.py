"""The checker against brute force, and the proof of a motion against thin obstacles."""

import numpy as np
import pytest
from planning_worlds import at, posts, problem, psm, reaching

from palpate import Arm, Mesh, PointCloud
from palpate.planning import geometry, shapes
from palpate.planning.allowed import disabled_pairs
from palpate.planning.checker import Checker
from palpate.planning.curves import corner, line
from palpate.planning.robot import Robot
from palpate.planning.world import World, obstacle
from palpate.world import surfaces
from palpate.world.mesh.mesh import quiet
from palpate_lab.studies.collisions.brute import to_triangles


def test_distances_agree_with_brute_force_on_random_poses() -> None:
    import coal
    import trimesh

    ball = trimesh.creation.icosphere(1, 0.02)
    mesh = geometry.mesh(np.asarray(ball.vertices), np.asarray(ball.faces))
    capsule, _ = geometry.capsule(shapes.Capsule(np.array([0.0, 0, -0.015]), np.array([0.0, 0, 0.015]), 0.002))
    rng = np.random.default_rng(0)
    count = 2_000  # `palpate study collisions` compares ten thousand
    p = rng.uniform(-0.05, 0.05, (count, 3))
    z = rng.normal(size=(count, 3))
    z /= np.linalg.norm(z, axis=1, keepdims=True)
    a, b = p - 0.015 * z, p + 0.015 * z
    corners = np.asarray(ball.vertices)[ball.faces]
    exact = np.concatenate([to_triangles(*part, corners).min(axis=1)
                            for part in zip(np.split(a, 20), np.split(b, 20), strict=True)]) - 0.002  # fmt: skip
    request, result = coal.CollisionRequest(), coal.CollisionResult()
    ask, answer = coal.DistanceRequest(), coal.DistanceResult()
    still = geometry.transform(np.eye(3), np.zeros(3))
    wrong = dict.fromkeys((0.0, 0.003, 0.008), 0)
    for k in range(count):
        X = shapes.Capsule(a[k], b[k], 0.002).pose()
        moved = geometry.transform(X[:3, :3], X[:3, 3])
        if exact[k] > 0.0:
            answer.clear()
            found = coal.distance(capsule.coal, moved, mesh.coal, still, ask, answer)
            assert found == pytest.approx(exact[k], abs=1e-6)
        for margin in wrong:
            request.security_margin = margin
            result.clear()
            touches = coal.collide(capsule.coal, moved, mesh.coal, still, request, result) > 0
            wrong[margin] += touches != (exact[k] <= margin) and abs(exact[k] - margin) > 1e-6
    assert wrong == {0.0: 0, 0.003: 0, 0.008: 0}


SOLIDS = [
    surfaces.Sphere(0.02),
    surfaces.Box([0.03, 0.02, 0.05]),
    surfaces.Cylinder(0.015, 0.05),
    surfaces.Capsule(0.01, 0.04),
    surfaces.Plane(),
]


@pytest.mark.parametrize("body", SOLIDS, ids=lambda body: body.name)
def test_primitives_agree_with_the_surfaces_that_contact_uses(body: surfaces.Surface) -> None:
    """Oracle: the core's exact distance, at points along the axis of a thin capsule."""
    robot = psm()
    rng = np.random.default_rng(1)
    X = at(0.02, -0.01, -0.13)
    world = World((obstacle("body", body, X),))
    checker = Checker(robot, world)
    for q in rng.uniform(robot.arm.q_min, robot.arm.q_max, (20, 6)):
        placed = robot.placed(q[None])
        along = np.linspace(0.0, 1.0, 4001)[:, None]
        ends = placed.ends_W[0]
        exact = min(
            float(body.nearest((e[0] + along * (e[1] - e[0]) - X[:3, 3]) @ X[:3, :3])[0].min()) - r
            for e, r in zip(ends, robot.radii, strict=True)
        )
        if exact > 1e-3:
            assert checker.nearest(q)[0].distance == pytest.approx(exact, abs=2e-5)


def test_poses_and_capsules_agree_with_the_arm() -> None:
    robot = psm()
    rng = np.random.default_rng(2)
    for q in rng.uniform(robot.arm.q_min, robot.arm.q_max, (5, 6)):
        poses, links = robot.kinematics.poses(q[None])[0], robot.arm.link_poses(q)
        for link, (carrier, X) in robot.kinematics.mount.items():
            if carrier >= 0:
                np.testing.assert_allclose(poses[carrier] @ X, links[link], atol=1e-12)


def test_capsules_contain_the_parts_of_the_model() -> None:
    robot = psm()
    rng = np.random.default_rng(3)
    for part in robot.arm.visuals:
        size = np.array(part.size)
        if part.shape == "box":
            points = 0.5 * size * rng.choice([-1.0, 1.0], (64, 3))
        else:
            angle = rng.uniform(0.0, 2.0 * np.pi, 64)
            half = 0.5 * size[1] * rng.choice([-1.0, 1.0], 64) if part.shape == "cylinder" else np.zeros(64)
            points = np.stack([size[0] * np.cos(angle), size[0] * np.sin(angle), half], axis=1)
        X = robot.kinematics.mount[part.link][1] @ part.X_link_visual
        points = points @ X[:3, :3].T + X[:3, 3]
        bodies = [b for b in robot.bodies if b.link == part.link]
        inside = np.min([b.capsule.distances(points) for b in bodies], axis=0)
        assert inside.max() < 1e-9


def test_a_link_with_a_mesh_is_checked_with_the_mesh_inside_of_its_capsule(tmp_path) -> None:  # type: ignore[no-untyped-def]
    import trimesh

    trimesh.creation.box((0.01, 0.02, 0.06)).export(tmp_path / "finger.stl")
    xml = f"""<robot name="m"><link name="base"/><link name="finger"><visual><geometry>
      <mesh filename="{tmp_path}/finger.stl"/></geometry></visual></link><link name="tip"/>
      <joint name="a" type="revolute"><parent link="base"/><child link="finger"/><axis xyz="0 1 0"/>
      <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
      <joint name="b" type="fixed"><parent link="finger"/><child link="tip"/><origin xyz="0 0 0.03"/></joint></robot>"""
    robot = Robot("M", Arm(xml, "base", "tip"), np.eye(4))
    assert robot.geometry == "meshes"
    (body,) = [b for b in robot.bodies if b.link == "finger"]
    assert body.mesh is not None
    assert body.capsule.distances(body.mesh[0]).max() < 1e-9
    world = World((obstacle("ball", surfaces.Sphere(0.01), at(0.02, 0.0, 0.0)),))
    assert Checker(robot, world).nearest(np.zeros(1))[0].distance == pytest.approx(0.02 - 0.01 - 0.005, abs=1e-6)


def test_no_point_moves_farther_than_the_bound() -> None:
    robot = psm()
    rng = np.random.default_rng(4)
    tight = 0.0
    for _ in range(40):
        a, b = rng.uniform(robot.arm.q_min, robot.arm.q_max, (2, 6))
        b = a + rng.uniform(0.02, 1.0) * (b - a)
        curve = line(a, b) if rng.uniform() < 0.5 else corner(a, 0.5 * (a + b) + 0.05 * rng.normal(size=6), b)
        half = rng.uniform(0.01, 0.5)
        placed = robot.placed(curve.at(np.array([0.5])))
        bound = robot.reach(placed, curve.rate, np.array([half]))[0]
        others = robot.placed(curve.at(np.linspace(0.5 - half, 0.5 + half, 41)))
        moved = np.linalg.norm(others.ends_W - placed.ends_W, axis=-1).max(axis=(0, 2))
        assert (moved <= bound + 1e-12).all()
        tight = max(tight, float((moved / np.maximum(bound, 1e-9)).max()))
    assert tight > 0.5  # and the bound is not so loose that nothing could ever be proved


def _across() -> tuple[np.ndarray, np.ndarray]:
    return reaching(0.0, 0.0, -0.12), reaching(0.06, 0.0, -0.12)


def test_a_motion_through_a_thin_vessel_is_refused() -> None:
    checker = Checker(psm(), posts())
    a, b = _across()
    ends = [checker.nearest(q)[0].distance for q in (a, b)]
    assert min(ends) > 0.005  # both ends are far from the vessel of 1 mm
    found = checker.blocked(line(a, b), 0.0)
    assert found is not None
    assert found.pair[1] == "vessel"


def test_the_proof_is_what_finds_the_thin_vessel(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without the bound on the motion, samples jump over the vessel: the test above can fail."""
    a, b = _across()
    monkeypatch.setattr(Robot, "reach", lambda self, placed, rate, half: np.zeros(placed.ends_W.shape[:2]))
    assert Checker(psm(), posts()).blocked(line(a, b), 0.0) is None


def test_a_free_motion_is_proved_and_its_clearance_is_kept() -> None:
    checker = Checker(psm(), posts())
    a, b = reaching(-0.015, -0.02, -0.10), reaching(0.015, -0.02, -0.10)
    least = min(checker.nearest(q)[0].distance for q in line(a, b).at(np.linspace(0.0, 1.0, 400)))
    assert checker.blocked(line(a, b), least - 2e-4) is None
    assert checker.blocked(line(a, b), least + 2e-5) is not None


def test_inside_of_a_closed_mesh_is_not_free() -> None:
    import trimesh

    ball = trimesh.creation.icosphere(3, 0.08)
    mesh = Mesh(np.asarray(ball.vertices), np.asarray(ball.faces))
    shell = World((obstacle("organ", mesh, at(0.0, 0.0, -0.12)),))
    q = reaching(0.0, 0.0, -0.13)
    found = Checker(psm(), shell).refusal(q, 0.001)
    assert found is not None
    assert found.distance < 0.0
    with quiet():
        half = Mesh(np.asarray(ball.vertices), np.asarray(ball.faces)[:600])
    opened = obstacle("organ", half, at(0.0, 0.0, -0.12))
    assert opened.inside is None
    assert "surface" in opened.note


def test_clouds_and_implicit_surfaces_are_thicker_than_their_triangles() -> None:
    points = np.random.default_rng(5).uniform(-0.02, 0.02, (4000, 2))
    cloud = surfaces.PointSurface(PointCloud(np.c_[points, np.zeros(len(points))], viewpoint=np.array([0.0, 0.0, 0.3])))
    pillow = surfaces.ImplicitSurface.of_half_lengths([0.02, 0.015, 0.01], [4, 4, 2])
    for body in (cloud, pillow):
        made = obstacle("body", body, at(0.0, 0.0, -0.15))
        assert 0.0 < made.solid.inflation < 0.004
        found = Checker(psm(), World((made,))).nearest(reaching(0.0, 0.0, -0.11))[0]
        exact = float(body.nearest(np.array([[0.0, 0.0, 0.04 - 0.0103]]))[0][0])
        assert found.distance <= exact + 1e-4


def test_an_allowed_pair_is_not_checked() -> None:
    q = reaching(0.03, 0.0, -0.12)
    checker = Checker(psm(), posts())
    assert checker.refusal(q, 0.0) is not None
    free = World(posts().obstacles, frozenset({frozenset(("PSM1", "vessel"))}))
    assert Checker(psm(), free).refusal(q, 0.0) is None


def test_pairs_of_the_instrument_itself_have_a_reason() -> None:
    pairs = {frozenset((p.one, p.two)): p.reason for p in disabled_pairs(psm())}
    assert pairs[frozenset(("wrist", "shaft"))] == "Adjacent"
    assert pairs[frozenset(("pitch_link", "shaft"))] == "Cannula"
    assert set(pairs.values()) <= {"Adjacent", "Cannula", "Linkage", "Default", "Never"}


def test_the_version_changes_with_the_world() -> None:
    world = posts()
    moved = world.moved("ball", at(0.0, 0.031, -0.13))
    assert len({world.version, moved.version, world.without("ball").version}) == 3
    assert world.version == posts().version
    assert problem(moved).world.version == moved.version
