"""Instruments of several pairs push each other apart: equal and opposite forces, at one point."""

import numpy as np
import pytest
from scipy.optimize import minimize

from palpate import _core
from palpate.record.ticks import as_ticks
from palpate.scene import Scene
from palpate.scene.together import build_pairs, capsules, gap_at_start, join_instruments

# Both shafts approach over free space and cross there: the organ lies far below.
CROSSING = """\
objects: [{{sphere: {{radius: 0.01}}, pose: {{xyz: [0, 0, -0.1]}}, stiffness: 300}}]
mapping: {{scale: 0.5}}
stability: {{force_cap: 20, passivity: off, rate_cap: 100000}}
force: {{source: {source}}}
pairs:
  right:
    arms:
      leader: {{base: {{xyz: [0.345, 0.243, 0.219]}}}}
      follower: {{base: {{xyz: [-0.08, 0, 0.16], rpy_deg: [0, 0, 0]}}, bandwidth: 30}}
    operator: {{path: [{{t: 0, xyz: [-0.02, 0, 0.06]}}, {{t: 0.5, xyz: [0.012, 0, 0.06]}}]}}
  left:
    arms:
      leader: {{model: mtm_left, base: {{xyz: [-0.345, 0.243, 0.219]}}}}
      follower: {{base: {{xyz: [0.08, 0, 0.16]}}}}
    operator: {{path: [{{t: 0, xyz: [0.02, 0.003, 0.06]}}, {{t: 0.5, xyz: [0.008, 0.003, 0.06]}}]}}
"""


def crossing(source="contact", n=700, joined=True):
    rigs = build_pairs(Scene.parse(CROSSING.format(source=source)))
    pair = [rig.simulation() for rig in rigs.values()]
    if joined:
        join_instruments(pair, [capsules(rig) for rig in rigs.values()], 800.0, 1.0)
    return rigs, [as_ticks(rows) for rows in _core.run_in_turns(pair, n)]


@pytest.fixture(scope="module")
def met():
    return crossing()


def test_nearest_points_of_segments_agree_with_a_minimiser():
    rng = np.random.default_rng(3)
    for _ in range(30):
        p0, p1, q0, q1 = rng.normal(size=(4, 3))
        p, q = _core.nearest_points(p0, p1, q0, q1)

        def distance(st, p0=p0, p1=p1, q0=q0, q1=q1):
            return float(np.sum((p0 + st[0] * (p1 - p0) - q0 - st[1] * (q1 - q0)) ** 2))

        best = min(minimize(distance, x, bounds=[(0, 1), (0, 1)]).fun for x in ([0.1, 0.1], [0.9, 0.1], [0.5, 0.9]))
        assert np.sum((p - q) ** 2) == pytest.approx(best, abs=1e-7)


@pytest.mark.parametrize(
    ("ends", "distance"),
    [
        ([[0, 0, 0], [1, 0, 0], [0, 2, 0], [1, 2, 0]], 2.0),  # parallel
        ([[0, 0, 0], [0, 0, 0], [1, 1, -1], [1, 1, 1]], np.sqrt(2)),  # a point
        ([[0, 0, 0], [0, 0, 0], [3, 0, 4], [3, 0, 4]], 5.0),  # two points
        ([[-1, 0, 0], [1, 0, 0], [0, -1, 0], [0, 1, 0]], 0.0),  # crossing
        ([[0, 0, 0], [1, 0, 0], [3, 1, 0], [5, 1, 0]], np.sqrt(5)),  # beyond an end
    ],
)
def test_nearest_points_of_special_segments(ends, distance):
    p, q = _core.nearest_points(*np.array(ends, dtype=float))
    assert np.linalg.norm(p - q) == pytest.approx(distance)


def test_forces_are_opposite_at_every_tick(met):
    a, b = met[1]
    assert np.linalg.norm(a["F_instrument_W"], axis=1).max() > 0.5
    np.testing.assert_array_equal(a["F_instrument_W"], -b["F_instrument_W"])


def test_the_impulses_add_up_to_zero_and_so_do_the_moments_about_one_point(met):
    a, b = met[1]
    for turn in (0.0, 0.3):  # about two points of W
        p = np.array([turn, -turn, 0.1])
        moment = sum(t["t_instrument_W"] + np.cross(t["p_WT"] - p, t["F_instrument_W"]) for t in (a, b))
        np.testing.assert_allclose(moment, 0.0, atol=1e-6)  # the tips were measured one count apart at most
    np.testing.assert_array_equal(a["F_instrument_W"].sum(axis=0) + b["F_instrument_W"].sum(axis=0), 0.0)


def test_both_hands_feel_opposite_forces(met):
    rigs, ticks = met
    felt = [rig.arms.X_WL[:3, :3] @ t["F_H_L"].T for rig, t in zip(rigs.values(), ticks, strict=True)]
    assert np.linalg.norm(felt[0], axis=0).max() > 0.4
    np.testing.assert_allclose(felt[0], -felt[1], atol=1e-9)


def test_the_force_is_the_spring_and_damper_of_the_overlap(met):
    a, _ = met[1]
    gap, force = a["instrument_gap"], np.linalg.norm(a["F_instrument_W"], axis=1)
    assert np.all(force[gap >= 0.0] == 0.0)
    rates = np.gradient(gap, 1e-3)
    touching = np.flatnonzero((gap < -1e-4) & (np.abs(np.gradient(rates)) < 1e-3))[2:-2]
    expected = np.maximum(0.0, -800.0 * gap - 1.0 * rates)  # of one capsule of each instrument
    np.testing.assert_allclose(force[touching[:15]], expected[touching[:15]], atol=0.02)
    assert np.all(force[touching] > expected[touching] - 0.02)  # further capsules add to it


def test_instruments_apart_or_not_joined_feel_nothing():
    _, ticks = crossing(joined=False, n=400)
    assert not any(t["F_instrument_W"].any() for t in ticks)
    rigs = build_pairs(Scene.parse(CROSSING.format(source="contact")))
    assert gap_at_start(*rigs.values()) > 0.0


def test_instruments_do_not_pass_through_each_other(met):
    a = met[1][0]
    _, free = crossing(joined=False)
    assert free[0]["p_WT"][-1, 0] > free[1]["p_WT"][-1, 0]  # free hands carry them past each other
    normal = a["F_instrument_W"][np.linalg.norm(a["F_instrument_W"], axis=1) > 0.1]
    assert np.all(normal @ normal[0] > 0.0)  # the side on which they met is kept


def test_driven_followers_are_pushed_by_each_other():
    _, (a, b) = crossing("estimate")
    assert np.linalg.norm(a["F_instrument_W"], axis=1).max() > 0.3
    np.testing.assert_array_equal(a["F_instrument_W"], -b["F_instrument_W"])
    _, free = crossing("estimate", joined=False)
    assert np.abs(a["q_follower"][-1] - free[0]["q_follower"][-1]).max() > 1e-5
