"""Touches of a surface: predicted against sampled errors, the best next touch, and what is told when they disagree."""

import re

import numpy as np
import pytest

from palpate.base.arrays import rigid
from palpate.base.errors import RegistrationError
from palpate.world.mesh import Mesh
from palpate.world.registration import disagreement, organ_motion, predict, touch_check, views
from palpate.world.registration.clouds import sampled
from palpate.world.registration.procedure import Organ, Procedure, from_landmarks
from palpate.world.registration.touches import Guess, Touched, next_touch, touched_by, touches
from palpate.world.shapes.organs import gallbladder, organ

SIGMA, TIP, RADIUS = 0.3e-3, 0.2e-3, 2e-3
PRIOR = np.diag([1e-6] * 3 + [1e-4] * 3)
TARGETS = {"a": np.array([-0.065, -0.03, 0.0]), "b": np.array([0.005, 0.02, 0.005])}


@pytest.fixture(scope="module")
def liver():
    vertices, triangles = organ(3000)
    return Organ(Mesh(vertices, triangles).core, sampled(vertices, triangles, 8000), TARGETS)


def touching(liver, rng, X, n=12, sigma=SIGMA, tip=TIP):
    """Touches of the organ at the true pose X, from the upper side, with their errors."""
    p, normals = liver.touchable
    rows = rng.choice(np.flatnonzero(normals[:, 2] > 0.3), n, replace=False)
    centre = rigid.transform(X, p[rows] + RADIUS * normals[rows])
    R = np.tile(rigid.exp(rng.normal(size=3)), (n, 1, 1))
    offset = tip * rng.normal(size=3)
    return Touched(centre - R @ offset + sigma * rng.normal(size=(n, 3)), R, RADIUS, SIGMA, TIP)


def drawn(rng, X0, prior=PRIOR):
    return rigid.displaced(X0, np.sqrt(np.diag(prior)) * rng.normal(size=6))


def test_predicted_errors_are_those_of_sampled_touches(liver):
    rng, squares, q = np.random.default_rng(0), [], []
    for _ in range(40):
        X0 = rigid.rigid(rigid.exp(rng.normal(size=3)), rng.normal(scale=0.1, size=3))
        X = drawn(rng, X0)
        found = touches(liver.surface, Guess(X0, PRIOR), touching(liver, rng, X))
        xi = rigid.displacement(found.X, X)
        squares.append(xi @ np.linalg.solve(found.covariance, xi))
        q.append(found.chi_square)
    assert np.mean(squares) == pytest.approx(6.0, rel=0.25)
    assert np.mean(q) == pytest.approx(12.0, rel=0.2)  # as many as touches


def test_next_touch_is_the_best_of_all_by_brute_force(liver):
    rng = np.random.default_rng(1)
    A = rng.normal(size=(6, 6))
    X, C = rigid.rigid(rigid.exp([0.3, 0.1, -0.5]), [0.1, 0.0, 0.2]), 1e-8 * A @ A.T
    places, normals = (part[::40] for part in liver.touchable)
    goals = np.array(list(TARGETS.values()))
    best, errors = next_touch(Guess(X, C), goals, places, normals, SIGMA)

    def after(k):
        n, arm = X[:3, :3] @ normals[k], X[:3, :3] @ places[k]
        row = np.concatenate([n, np.cross(arm, n)])
        updated = np.linalg.inv(np.linalg.inv(C) + np.outer(row, row) / SIGMA**2)
        return [predict.target(X, updated, p).tre for p in goals]

    worst = [max(after(k)) for k in range(len(places))]
    assert best == int(np.argmin(worst))
    assert errors == pytest.approx(after(best))


def test_bound_of_an_error_is_kept_with_its_probability():
    rng = np.random.default_rng(2)
    for sizes in ((1.0, 1.0, 1.0), (1.0, 0.5, 0.2), (1.0, 0.05, 0.05)):
        errors = np.linalg.norm(rng.normal(size=(100_000, 3)) * sizes, axis=1)
        for p in (0.9, 0.95, 0.99):
            share = np.mean(errors <= predict.within(np.diag(np.square(sizes)), p))
            assert share == pytest.approx(p, abs=0.01)


def moved_after(liver, rng, X, shift):
    early, late = touching(liver, rng, X, 6), touching(liver, rng, rigid.displaced(X, [*shift, 0, 0, 0]), 6)
    R = np.concatenate([early.R_WT, late.R_WT])
    return Touched(np.concatenate([early.p_WT, late.p_WT]), R, RADIUS, SIGMA, TIP)


def test_smallest_motion_is_told_in_nine_of_ten_sessions_and_rest_is_not_called_a_motion(liver):
    # Judged by simulated sessions, in which the organ carries the later touches along.
    rng, X0, told = np.random.default_rng(5), np.eye(4), {0.0: 0, 0.5: 0, 1.0: 0, 2.0: 0}
    first, n = Guess(X0, PRIOR), 50
    for _ in range(n):
        given = touching(liver, rng, drawn(rng, X0))
        smallest = organ_motion.smallest(liver.surface, first, given, touches(liver.surface, first, given))
        d = rng.normal(size=3)
        step = np.repeat([0.0, smallest], 6)[:, None] * d / np.linalg.norm(d)
        for factor in told:
            moved = Touched(given.p_WT + factor * step, given.R_WT, RADIUS, SIGMA, TIP)
            told[factor] += bool(organ_motion.told(liver.surface, first, moved, touches(liver.surface, first, moved)))
    assert told[1.0] / n == pytest.approx(0.9, abs=0.1)
    assert told[0.0] <= 3  # 1 % of 50: more with a probability of 0.002
    assert told[0.5] / n < 0.5 < told[2.0] / n
    assert np.isnan(Procedure(liver, first, 1e-3, SIGMA, TIP, RADIUS).smallest_motion)  # no touch, no statement


def test_two_views_tell_the_motion_that_they_promise_and_call_rest_no_motion():
    rng, told = np.random.default_rng(7), {0.0: 0, 0.4: 0, 1.0: 0, 2.0: 0}
    L = 1e-4 * rng.normal(size=(6, 6))
    before, n = Guess(rigid.rigid(rigid.exp(np.ones(3)), np.ones(3)), L @ L.T), 300
    for _ in range(n):
        d = rng.normal(size=3)
        for factor in told:
            e = L @ rng.normal(size=6) + L @ rng.normal(size=6)
            e[:3] += factor * views.smallest(before) * d / np.linalg.norm(d)
            told[factor] += bool(
                views.motion(before, Guess(rigid.displaced(before.X, e), before.covariance), np.zeros(3))
            )
    assert told[1.0] / n == pytest.approx(0.9, abs=0.06)
    assert told[0.0] <= 3  # 0.1 % of 300
    assert told[0.4] / n < 0.5 < told[2.0] / n


def test_motion_is_estimated_beside_the_place_of_the_touches(liver):
    rng, X0 = np.random.default_rng(8), np.eye(4)
    first, given = Guess(X0, PRIOR), touching(liver, rng, drawn(rng, X0), 20)
    step = np.repeat([0.0, 1.0], [8, 12])[:, None] * [0.0, 0.0, 3e-3]
    moved = Touched(given.p_WT + step, given.R_WT, RADIUS, SIGMA, TIP)
    (words,) = organ_motion.told(liver.surface, first, moved, touches(liver.surface, first, moved))
    after, size = map(float, re.search(r"touch (\d+), by about ([\d.]+) mm", words).groups())
    assert 6 <= after <= 10
    assert size == pytest.approx(3.0, abs=1.0)


def test_session_that_asks_for_a_motion_touches_on_until_it_would_be_told(liver):
    rng, X0 = np.random.default_rng(6), np.eye(4)
    X, counts = drawn(rng, X0), []
    for motion in (np.inf, 1.6e-3):
        state = Procedure(liver, Guess(X0, PRIOR), 5e-3, SIGMA, TIP, RADIUS, motion)
        given = touching(liver, rng, X, 40)
        while not state.met:
            state.require_sound(40)
            k = len(state.X_WT)
            state.add(rigid.rigid(given.R_WT[k], given.p_WT[k]))
        counts.append(len(state.X_WT))
        assert state.smallest_motion <= motion
    assert counts[0] == 6 < 12 < counts[1]
    state.motion = 1e-5
    with pytest.raises(RegistrationError, match=r"are not enough: they tell a motion of the organ from 1\.\d+ mm on"):
        state.require_sound(len(state.X_WT))


def one_off(touched, k, shift):
    p = touched.p_WT.copy()
    p[k] += shift
    return Touched(p, touched.R_WT, RADIUS, SIGMA, TIP)


@pytest.mark.parametrize(
    ("kind", "words"),
    [
        ("right", ""),
        ("one", "touch 5 lies"),
        ("tip", "all touches lie"),
        ("moved", "the organ moved after about touch"),
    ],
)
def test_what_is_wrong_with_touches_is_named(liver, kind, words):
    rng, X0 = np.random.default_rng(3), np.eye(4)
    X = drawn(rng, X0)
    given = touching(liver, rng, X)
    if kind == "one":
        given = one_off(given, 4, [0.0, 0.0, 5e-3])
    if kind == "tip":
        given = Touched(given.p_WT + np.array([0.006, 0.0, 0.008]), given.R_WT, RADIUS, SIGMA, TIP)
    if kind == "moved":
        given = moved_after(liver, rng, X, [3e-3, 3e-3, -3e-3])
    first = Guess(X0, PRIOR)
    told = disagreement.reasons(liver.surface, first, given, touches(liver.surface, first, given))
    assert bool(told) == bool(words)
    assert words in "".join(told)


@pytest.mark.parametrize("shift", [*np.eye(3), *-np.eye(3), np.ones(3) / np.sqrt(3)])
def test_check_passes_a_right_registration_and_fails_one_that_is_3_mm_off(liver, shift):
    rng, X = np.random.default_rng(4), np.eye(4)
    C = np.diag([1e-7] * 3 + [1e-6] * 3)
    places = [(p, n) for p, n in touch_check.spread(liver, X, 8, lambda p, n: n[2] > 0.4)]
    centres = np.array([p + RADIUS * n for p, n in places]) + SIGMA * rng.normal(size=(8, 3))
    given = Touched(centres, np.tile(np.eye(3), (8, 1, 1)), RADIUS, SIGMA, TIP)
    assert touch_check.check(liver, Guess(X, C), given, 1e-3).passed
    wrong = Guess(rigid.displaced(X, [*(-3e-3 * np.array(shift)), 0, 0, 0]), C)
    found = touch_check.check(liver, wrong, given, 1e-3)
    assert not found.passed
    assert found.shift == pytest.approx(3e-3 * np.array(shift), abs=1e-3)  # where the organ really is


def test_mirrored_targets_and_a_view_of_another_organ_are_refused(liver):
    flipped = {name: p * [-1, 1, 1] for name, p in TARGETS.items()}
    with pytest.raises(RegistrationError, match=r"'a' lies .* outside(.|\n)*opposite sign of x"):
        Organ(liver.surface, liver.points, flipped).check_targets()
    view = sampled(*gallbladder(2000), 800) + 1e-3 * np.random.default_rng(0).normal(size=(800, 3))
    with pytest.raises(RegistrationError, match="cannot be registered"):
        views.seen(liver.points, view)


@pytest.mark.parametrize(
    ("flip", "order"), [([1, 1, 1], [0, 1, 2, 3, 4, 5]), ([-1, 1, 1], None), ([1, 1, 1], [1, 0, 2, 3, 4, 5])]
)
def test_landmarks_give_a_first_pose_or_are_refused(liver, flip, order):
    rng, (p_O, normals) = np.random.default_rng(5), liver.touchable
    rows = rng.choice(len(p_O), 6, replace=False)
    X = rigid.rigid(rigid.exp(rng.normal(size=3)), [0.1, 0.2, 0.3])
    tips = rigid.transform(X, p_O[rows] + RADIUS * normals[rows]) + 1e-3 * rng.normal(size=(6, 3))
    poses = [rigid.rigid(np.eye(3), p) for p in tips]
    listed = p_O[rows][order or range(6)] * flip
    given = {f"mark {k}": p for k, p in enumerate(listed)}
    touched = touched_by(poses, RADIUS, SIGMA, TIP)
    if np.array_equal(listed, p_O[rows]):
        xi = rigid.displacement(from_landmarks(liver, given, touched, 1e-3).X, X)
        assert np.linalg.norm(xi[:3]) < 4e-3
        return
    if order is None:
        with pytest.raises(RegistrationError, match="the list is mirrored"):
            liver.check_landmarks(given)
    with pytest.raises(RegistrationError, match="mirror image" if order is None else "disagree|order of the rows"):
        from_landmarks(liver, given, touched, 1e-3)


def test_no_place_is_proposed_twice_and_undo_forgets(liver):
    state = Procedure(liver, Guess(np.eye(4), PRIOR), 1e-3, SIGMA, TIP, RADIUS)
    before = state.bounds
    p, n = state.next_place()
    state.add(rigid.rigid(np.eye(3), p + RADIUS * n))
    assert max(state.bounds.values()) < max(before.values())
    q, _ = state.next_place()
    assert np.linalg.norm(p - q) > 5e-3
    state.remove()
    assert state.bounds == before
    state.skip(p)
    assert np.linalg.norm(state.next_place()[0] - p) > 5e-3
    with pytest.raises(RegistrationError, match="no place is left"):
        state.next_place(lambda p, n: False)
