"""What is told of a wrench adds up to it; of soft springs, potentials and dampings nothing is left over."""

import numpy as np
from fixtures import Stage, pose
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from palpate.guidance import Fixture, Here, Line, Plane, Sphere
from palpate.guidance.why import of_tick, terms

HERE = Here()


def some(rng, i):
    role, shape = [
        ("guide", Line(start=(0.0, 0.0, 0.0), end=(0.1, 0.0, 0.0), endless=True)),
        ("forbid", Sphere(radius=0.02, at=tuple((0.01 * rng.normal(size=3)).tolist()))),
        ("keep-in", Sphere(radius=0.005)),
        ("forbid", Plane(normal=tuple(rng.normal(size=3).tolist()))),
        ("orient", Line(start=(0.0, 0.0, 0.0), end=(0.0, 0.1, 0.1))),
    ][rng.integers(5)]
    return Fixture(
        shape,
        name=f"f{i}",
        role=role,
        law=str(rng.choice(["spring", "potential", "admittance", "optimise"])),
        hard=bool(rng.random() < 0.3),
        authority=float(rng.choice([1.0, 0.4])),
        priority=int(rng.integers(0, 3)),
        ramps=[{"by": "distance", "start": 0.0, "end": 0.01}] if rng.random() < 0.3 else [],
    )


def tick_of(stage, fixtures, X, V, ticks=1500):
    stage.give(*(f.make(HERE) for f in fixtures))
    for _ in range(ticks):
        out = stage.step(X, V=V)
    return {
        "t": 0.0,
        "quat_WT": np.roll(Rotation.from_matrix(X[:3, :3]).as_quat(), 1),
        "p_WT_goal": out["X_WT_goal"][:3, 3],
        "p_correction_W": out["correction"],
        "F_guidance_W": out["F_T_W"][:3],
        "t_guidance_W": out["F_T_W"][3:],
        "F_T_W": np.zeros(3),
        "guidance_fixture": out["strongest"],
    }


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 4))
def test_the_terms_add_up_to_the_wrench_and_nothing_is_left(seed, n):
    rng = np.random.default_rng(seed)
    fixtures = [some(rng, i) for i in range(n)]
    X = pose(0.004 * rng.normal(size=3), Rotation.random(random_state=rng).as_matrix())
    V = np.r_[0.02 * rng.normal(size=3), 0.2 * rng.normal(size=3)]
    tick = tick_of(Stage(), fixtures, X, V)
    told = terms(fixtures, tick, HERE, V)
    wrench = np.r_[tick["F_guidance_W"], tick["t_guidance_W"]]
    np.testing.assert_allclose(sum(term.F for term in told), wrench, atol=1e-12)
    if not any(f.hard or f.law.name == "optimise" for f in fixtures):  # of those the goal's way there matters, too
        np.testing.assert_allclose(told[-1].F, 0.0, atol=1e-7)


def test_what_is_told_names_every_part_its_authority_and_the_damping():
    fixtures = [
        Fixture(Plane(), name="floor", role="forbid", hard=True),
        Fixture(Line(start=(0, 0.01, 0.0), end=(0.1, 0.01, 0.0)), name="line", role="guide", authority=0.5),
    ]
    V = np.array([0.0, -0.03, 0.0, 0.0, 0.0, 0.0])
    tick = tick_of(Stage(), fixtures, pose((0.02, 0.0, -0.002)), V)
    words = of_tick(fixtures, tick, HERE, V)
    assert "floor: (+0.000, +0.000, +0.820) N" in words
    assert "line: (" in words
    assert "at 50 % of its authority" in words
    alone = fixtures[1].why(pose((0.02, 0.0, 0.0)), V)
    assert "damping: 0.06 N" in alone
    assert "its authority is 0.5: the hand is given 2.03 N of it" in alone


def test_why_names_the_term_that_made_the_force():
    fixture = Fixture(Sphere(radius=0.03), role={"name": "forbid", "margin": 0.002}, name="vessel")
    told = fixture.why([0.028, 0, 0], V_WT=[-0.02, 0, 0, 0, 0, 0])
    assert "vessel (forbid, law spring, soft)" in told
    assert "the tool is 4 mm inside its margin of 2 mm" in told
    assert "spring: 1.6 N, at 400 N/m" in told
    assert "damping: 0.04 N, at 2 N s/m" in told
    assert "together 1.64 N along (+1.00, +0.00, +0.00) in W; most of it is the spring" in told
    assert "no force" in fixture.why([0.1, 0, 0])
    assert "switched off" in fixture.model_copy(update={"enabled": False}).why([0.028, 0, 0])


def test_the_tools_axis_is_the_shaft_of_a_psm_while_its_wrist_is_straight():
    """`keep-rcm` is about z of T: through the remote centre, until the wrist bends."""
    from palpate.scene import Scene
    from palpate.scene.rig import build

    arms = build(Scene.parse("objects: [{sphere: {radius: 0.03}}]")).arms
    q = np.array(arms.q_follower0)
    q[:4] += [0.3, -0.2, 0.05, 0.7]
    for bend, low, high in ((0.0, 0.0, 1e-4), (0.5, 25.0, 30.0)):
        q[4:] = [bend, 0.0]
        X_BT = arms.follower.fk(q)
        shaft = X_BT[:3, 3] / np.linalg.norm(X_BT[:3, 3])
        assert low <= np.degrees(np.arccos(min(X_BT[:3, 2] @ shaft, 1.0))) <= high
