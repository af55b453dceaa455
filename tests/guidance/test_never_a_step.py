"""The stage: edits give no step of the wrench, outputs are always finite, and springs add no energy."""

import numpy as np
import pytest
from fixtures import DT, LINE, RESERVE, Stage, fixture, placed, plane, point_at_height, pose, sphere
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from palpate import _core

RATE, MOMENT_RATE = 20.0, 0.35
EDITS = ["off", "gone", "gains", "law", "moved", "role", "hard", "authority", "other"]


def edited(edit, rng):
    base = {"law_": {"K": 400.0}, "role_": {}}
    where = pose(point_at_height(0.0))
    if edit == "off":
        return [fixture(plane(where), on=False, **base)]
    if edit == "gone":
        return []
    if edit == "gains":
        return [fixture(plane(where), law_={"K": rng.uniform(0, 2000)})]
    if edit == "law":
        return [fixture(plane(where), law=str(rng.choice(["potential", "admittance", "optimise"])))]
    if edit == "moved":
        return [fixture(plane(pose(rng.uniform(-0.01, 0.01, 3), Rotation.random(random_state=rng).as_matrix())))]
    if edit == "role":
        role = str(rng.choice(["guide", "keep-in", "forbid", "orient"]))
        return [fixture(sphere(0.02, where), role, role_={"target": "normal"})]
    if edit == "hard":
        return [fixture(plane(where), hard=True, **base)]
    if edit == "authority":
        return [fixture(plane(where), authority=rng.uniform(), rise=0.01, fall=0.01, **base)]
    return [fixture(plane(where), **base), fixture(sphere(0.02, where), "guide", name="two", law_={"K": 800.0})]


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.lists(st.sampled_from(EDITS), min_size=2, max_size=5))
def test_edits_of_fixtures_give_no_step_at_a_resting_hand(seed, edits):
    """In every tick the wrench changes within its rate limit, and the goal within the return speed."""
    rng = np.random.default_rng(seed)
    X = pose(rng.uniform(-0.006, 0.006, 3), Rotation.random(random_state=rng).as_matrix())
    stage = Stage(*edited("gains", rng))
    before, slowest = stage.settle(X, 100), _core.GuidanceOptions().return_speed
    for edit in edits:
        stage.set_fixtures(*edited(edit, rng))
        for _ in range(60):
            out = stage.step(X)
            change = out["F_T_W"] - before["F_T_W"]
            assert np.linalg.norm(change[:3]) <= RATE * DT * (1 + 1e-9), edit
            assert np.linalg.norm(change[3:]) <= MOMENT_RATE * DT * (1 + 1e-9), edit
            moved = np.linalg.norm(out["X_WT_goal"][:3, 3] - before["X_WT_goal"][:3, 3])
            assert moved <= slowest * DT + RESERVE + 1e-12, edit
            before = out


def test_wrench_of_a_moving_hand_changes_only_with_the_motion():
    stage, rng = Stage(fixture(sphere(0.01), law_={"K": 500.0, "B": 0.0})), np.random.default_rng(1)
    before, p = stage.settle(point_at_height(0.02)), point_at_height(0.02)
    for _ in range(3000):
        last, p = p, 0.99 * p + rng.normal(size=3) * 2e-4
        out = stage.step(p)
        change = np.linalg.norm((out["F_T_W"] - before["F_T_W"])[:3])
        assert change <= 500.0 * np.linalg.norm(p - last) + RATE * DT + 1e-9
        before = out


@pytest.mark.parametrize("number", [np.nan, np.inf, 1e300])
def test_invalid_inputs_give_finite_outputs(number):
    """Invalid inputs of contact and operator; poses are checked before the stage."""
    made = [
        fixture(sphere(0.1), "limit", name="f", role_={"force": 1.0}, hard=True),
        fixture(plane(), ramps=[_core.Ramp("force", 4.0, 2.0)]),
    ]
    out = Stage(*made).settle(
        point_at_height(-0.003), 50, F_T_W=np.full(3, number), stiffness=number, F_hand=number, pedal=number
    )
    assert np.isfinite(out["F_T_W"]).all()
    assert np.isfinite(out["X_WT_goal"]).all()


def test_springs_and_potentials_add_no_energy_on_a_closed_motion():
    """Over many cycles in and out of soft fixtures the hand gets back no more energy than it has put in."""
    made = [
        fixture(sphere(0.02), law_={"K": 400.0}),
        fixture(placed(LINE, pose(point_at_height(0.01))), "guide", "potential", name="two"),
    ]
    stage = Stage(*made)
    stage.settle(point_at_height(0.03))
    s = np.linspace(0, 10 * np.pi, 20001)
    hand = np.stack([0.01 * np.sin(2 * s), 0.012 * np.sin(s), 0.012 + 0.018 * np.cos(s)], axis=1)
    F = np.array([stage.step(p)["F_T_W"][:3] for p in hand])
    work = (F[:-1] * np.diff(hand, axis=0)).sum()
    exchanged = np.abs(F[:-1] * np.diff(hand, axis=0)).sum()
    assert work < 2e-3 * exchanged


def test_hard_fixture_takes_over_a_touched_force_without_a_step():
    """A pressed tool at rest: switching a hard plane on and off changes what the hand feels within the rate."""
    stage, X, touched = Stage(), point_at_height(-0.003), np.array([0.4, -0.2, 3.0])

    def felt():
        out = stage.step(X, F_T_W=touched)
        return out["F_T_W"][:3] + (out["J_goal"].T @ np.r_[touched, np.zeros(3)])[:3]

    before, most = [felt() for _ in range(50)][-1], 0.0
    for made in ([fixture(plane(), hard=True)], [], [fixture(plane(), hard=True)]):
        stage.set_fixtures(*made)
        for _ in range(400):
            now = felt()
            most, before = max(most, np.linalg.norm(now - before)), now
    assert most <= RATE * DT * (1 + 1e-9)


def test_soft_fixture_that_becomes_hard_does_not_count_twice():
    """What the fixture itself pushed with is no force of the surroundings: the spring at rest stays K e."""
    stage, X = Stage(fixture(plane(), law_={"K": 400.0})), point_at_height(-0.003)
    stage.settle(X, 300)
    stage.set_fixtures(fixture(plane(), law_={"K": 400.0}, hard=True))
    assert stage.settle(X, 3000)["F_T_W"][2] == pytest.approx(400.0 * (0.003 + RESERVE), rel=1e-3)
