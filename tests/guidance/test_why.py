"""The explained terms of a guidance wrench add up to it; soft springs, potentials and damping leave no residual."""

import re

import numpy as np
import pytest
from fixtures import Stage, pose
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import palpate
from palpate.scene import Scene
from palpate.scene.guidance import Fixture, FixtureContext, Line, Plane, Sphere
from palpate.scene.guidance.why import OperatorInput, explain_tick, terms
from palpate.scene.rig import build

HERE = FixtureContext()


def random_fixture(rng, i):
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
        ramps=[{"by": "angle", "end": 30.0} if role == "orient" else {"by": "distance", "end": 0.01}]
        if rng.random() < 0.3
        else [],
    )


def tick_of(stage, fixtures, X, V, ticks=1500):
    stage.set_fixtures(*(f.make(HERE) for f in fixtures))
    for _ in range(ticks):
        out = stage.step(X, V=V)
    return {
        "t": 0.0,
        "quat_WT_asked": np.roll(Rotation.from_matrix(X[:3, :3]).as_quat(), 1),
        "p_WT_goal": out["X_WT_goal"][:3, 3],
        "p_correction_W": out["correction"],
        "F_guidance_W": out["F_T_W"][:3],
        "t_guidance_W": out["F_T_W"][3:],
        "F_T_W": np.zeros(3),
        "guidance_fixture": out["strongest"],
    }


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 4))
def test_terms_add_up_to_the_wrench_without_residual(seed, n):
    rng = np.random.default_rng(seed)
    fixtures = [random_fixture(rng, i) for i in range(n)]
    X = pose(0.004 * rng.normal(size=3), Rotation.random(random_state=rng).as_matrix())
    V = np.r_[0.02 * rng.normal(size=3), 0.2 * rng.normal(size=3)]
    tick = tick_of(Stage(moment_rate=10.0), fixtures, X, V)  # moments settle within the ticks
    parts = terms(fixtures, tick, HERE, OperatorInput(V))
    wrench = np.r_[tick["F_guidance_W"], tick["t_guidance_W"]]
    np.testing.assert_allclose(sum(term.F for term in parts), wrench, atol=1e-12)
    if not any(f.hard or f.law.name == "optimise" for f in fixtures):  # these also depend on the goal's motion
        np.testing.assert_allclose(parts[-1].F, 0.0, atol=1e-7)


def test_explanation_names_every_part_its_authority_and_the_damping():
    fixtures = [
        Fixture(Plane(), name="floor", role="forbid", hard=True),
        Fixture(Line(start=(0, 0.01, 0.0), end=(0.1, 0.01, 0.0)), name="line", role="guide", authority=0.5),
    ]
    V = np.array([0.0, -0.03, 0.0, 0.0, 0.0, 0.0])
    tick = tick_of(Stage(), fixtures, pose((0.02, 0.0, -0.002)), V)
    explanation = explain_tick(fixtures, tick, HERE, OperatorInput(V))
    # The spring holds 0.820 N; the line pulled the tool against the floor by 4 mN when this began to hold the tool.
    floor = next(part for part in terms(fixtures, tick, HERE, OperatorInput(V)) if part.name == "floor")
    np.testing.assert_allclose(floor.F[:3] - floor.F_taken_over[:3], [0.0, 0.0, 400.0 * 2.05e-3], atol=1e-6)
    assert re.search(r"floor: \([+-]0.000, [+-]0.000, \+0.824\) N, 0.0039\d N of it taken over", explanation)
    assert "residual" not in explanation
    assert "line: (" in explanation
    assert "at 50 % of its authority" in explanation
    alone = fixtures[1].why(pose((0.02, 0.0, 0.0)), V)
    assert "damping: 0.06 N" in alone
    assert "its authority is 0.5: the hand is given 2.03 N" in alone


def test_why_names_the_dominant_term():
    fixture = Fixture(Sphere(radius=0.03), role={"name": "forbid", "margin": 0.002}, name="vessel")
    explanation = fixture.why([0.028, 0, 0], V_WT=[-0.02, 0, 0, 0, 0, 0])
    assert "vessel (forbid, law spring, soft)" in explanation
    assert "the tool is 4 mm inside its margin of 2 mm" in explanation
    assert "spring: 1.6 N, at 400 N/m" in explanation
    assert "damping: 0.04 N, at 2 N s/m" in explanation
    assert "together 1.64 N along (+1.00, +0.00, +0.00) in W; most of it is the spring" in explanation
    assert "no force" in fixture.why([0.1, 0, 0])
    assert "switched off" in fixture.model_copy(update={"enabled": False}).why([0.028, 0, 0])


def test_explanation_lists_the_residual_and_adds_up_to_the_recorded_force():
    """A tick whose force the fixtures explain only in part: the printed contributions still sum to the whole force."""
    fixtures = [
        Fixture(Plane(), name="floor", role="forbid", law={"stiffness": 400.0}),
        Fixture(Line(start=(0, 0.01, 0.0), end=(0.1, 0.01, 0.0)), name="line", role="guide", authority=0.5),
    ]
    tick = tick_of(Stage(), fixtures, pose((0.02, 0.0, -0.002)), np.zeros(6))
    assert "residual" not in explain_tick(fixtures, tick, HERE)
    unexplained = np.array([0.3, -0.02, 0.0])
    tick["F_guidance_W"] = tick["F_guidance_W"] + unexplained
    printed = re.findall(r"^  (\w+): \((.*?)\) N", explain_tick(fixtures, tick, HERE), re.MULTILINE)
    numbers = {name: np.array([float(x) for x in xyz.split(",")]) for name, xyz in printed}
    assert list(numbers) == ["floor", "line", "residual"]
    np.testing.assert_allclose(numbers["residual"], unexplained, atol=1e-3)
    np.testing.assert_allclose(sum(numbers.values()), tick["F_guidance_W"], atol=2e-3)


SESSION = """
objects: [{sphere: {radius: 0.01}}]
guidance:
  - {name: floor, geometry: {plane: {}}, frame: {pose: {xyz: [0, 0, 0.045]}}, role: forbid, hard: true, priority: 1,
     law: {stiffness: 200}}
  - {name: slope, geometry: {plane: {normal: [-1, 0, 0.3]}}, frame: {pose: {xyz: [0.004, 0, 0.045]}}, role: forbid,
     hard: true, law: {stiffness: 100}}
  - {name: jig, geometry: {line: {start: [0, 0.004, 0.05], end: [0.03, 0.004, 0.05]}}, role: guide,
     law: {name: optimise, stiffness: 150}}
  - {name: turned, geometry: {line: {start: [0, 0, 0.05], end: [0.01, 0.01, -0.05]}}, role: {name: orient,
     angle_deg: 2}, hard: true}
  - {name: upright, geometry: {line: {start: [0, 0, 0.05], end: [0, 0.06, -0.2]}}, role: {name: orient, angle_deg: 1},
     law: optimise}
  - {name: soft, geometry: {point: {at: [0.01, 0, 0.04]}}, role: guide, law: {stiffness: 100},
     ramps: [{by: pedal, start: 0, end: 1}, {by: time, start: 0, end: 0.8}]}
operator: {path: [{t: 0, xyz: [0, 0, 0.05]}, {t: 1, xyz: [0.008, 0, 0.04]}]}
"""


def test_terms_of_hard_and_optimised_fixtures_add_up_to_the_rendered_wrench():
    """Six fixtures, with rotations and a pedal: a small residual during motion and none at rest."""
    session = palpate.Session(Scene.parse(SESSION))
    controls = session.controls
    controls.guidance = 0.5
    session.controls = controls
    rig = session.rig
    for ticks, force, moment in ((900, 0.05, 1e-3), (600, 2e-4, 5e-5), (1500, 2e-4, 5e-5)):
        tick = session.step(ticks).tick
        V = np.r_[rig.scene.mapping.scale * rig.arms.X_WL[:3, :3] @ np.asarray(tick["v_LH"]), np.zeros(3)]
        parts = terms(
            session.fixtures, tick, rig.context, OperatorInput(V, 0.5, float(np.linalg.norm(tick["F_cell_L"])))
        )
        whole = sum(term.F for term in parts)
        np.testing.assert_allclose(whole, np.r_[tick["F_guidance_W"], tick["t_guidance_W"]], atol=1e-12)
        assert np.abs(parts[-1].F[:3]).max() < force, (tick["t"], parts)
        assert np.abs(parts[-1].F[3:]).max() < moment, (tick["t"], parts)
    assert all(np.linalg.norm(term.F) > 0.01 for term in parts[:-1]), "control: every fixture pulls"
    assert parts[5].authority == pytest.approx(0.5)
    felt = rig.arms.X_WL[:3, :3] @ np.asarray(tick["F_H_L"])
    np.testing.assert_allclose(felt, rig.scene.mapping.force_scale * whole[:3], atol=2e-3)
    explanation = session.why()
    assert "residual" not in explanation
    assert "hard fixtures hold the tool's goal back by" in explanation
    assert "soft: (" in explanation
    assert "at 50 % of its authority" in explanation


def test_tool_axis_is_the_shaft_of_a_psm_with_a_straight_wrist():
    """`keep-rcm` uses the z axis of T, which passes through the remote centre until the wrist bends."""
    arms = build(Scene.parse("objects: [{sphere: {radius: 0.03}}]")).arms
    q = np.array(arms.q_follower0)
    q[:4] += [0.3, -0.2, 0.05, 0.7]
    for bend, low, high in ((0.0, 0.0, 1e-4), (0.5, 25.0, 30.0)):
        q[4:] = [bend, 0.0]
        X_BT = arms.follower.fk(q)
        shaft = X_BT[:3, 3] / np.linalg.norm(X_BT[:3, 3])
        assert low <= np.degrees(np.arccos(min(X_BT[:3, 2] @ shaft, 1.0))) <= high
