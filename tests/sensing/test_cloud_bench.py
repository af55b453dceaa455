"""The judge of forces on moving surfaces, and short versions of its cases."""

import numpy as np
import pytest

from palpate_lab.verify.bench.cloud_cases import CASES, felt, force_error, relative_error, true_force

T = np.arange(0.0, 4.0, 1e-3)
EXACT = 4.0 + 2.0 * (1.0 - np.cos(0.5 * np.pi * T))


def test_the_judge_accepts_the_exact_force_and_its_noise():
    noise = 0.05 * np.random.default_rng(0).normal(size=len(T))
    assert relative_error(EXACT, EXACT) == 0.0
    assert relative_error(EXACT + noise, EXACT) < 0.02


@pytest.mark.parametrize(
    "wrong",
    [
        EXACT[np.maximum(np.arange(len(T)) - 150, 0)],  # delayed by 0.15 s
        EXACT * np.clip(T / 0.5, 0.2, 1.0),  # faded at its beginning
        EXACT[(np.arange(len(T)) // 300) * 300],  # in steps of 0.3 s
        EXACT + 0.4,  # 0.4 mm too high
        0.0 * EXACT,  # passed through
    ],
    ids=["delayed", "faded", "stepping", "displaced", "absent"],
)
def test_the_judge_refuses_each_kind_of_wrong_force(wrong):
    assert relative_error(wrong, EXACT) > 0.05


def test_the_true_force_is_that_at_the_measured_pose_of_the_tool():
    rows = np.zeros(2, dtype=[("t", float), ("p_WT", float, 3)])
    rows["p_WT"][1] = [0.006, 0.0, 0.001]  # 1 mm higher, and 0.3 mm of curvature
    assert true_force(rows, lambda t: 0.001 + 0 * t) == pytest.approx([4.0, 2.7])


@pytest.mark.parametrize("name", [name for name in CASES if name != "breathing"])
def test_force_on_a_moving_surface_is_true_and_nothing_is_passed_through(name):
    case = CASES[name]
    rows = felt(case.height, case.seconds)
    seen = rows[case.seen(rows["t"])]
    assert force_error(seen, case.height) < 0.05
    deep = true_force(seen, case.height) > 2.0
    assert deep.any()
    assert (seen["F_spring_W"][deep, 2] > 0.5).all()
    rate = 1e3 * np.linalg.norm(np.diff(rows["F_H_L"], axis=0), axis=1)
    assert rate.max() <= 50.0 * (1 + 1e-9)  # the scene's cap


def test_force_on_a_breathing_surface_is_true():
    case = CASES["breathing"]
    rows = felt(case.height, 1.5)
    assert force_error(rows[case.seen(rows["t"])], case.height) < 0.05


def test_a_surface_that_rests_between_frames_fails_where_the_surface_moves():
    case = CASES["rising at 0.1 m/s"]
    rows = felt(case.height, 0.55, extrapolate=False)
    assert force_error(rows[case.seen(rows["t"])], case.height) > 0.2


def test_a_proxy_at_rest_follows_a_surface_that_jumps_away_from_it():
    """Without a velocity the object stands still; a proxy must then leave the surface of the frame before."""
    case = CASES["jumps of 5 mm"]
    rows = felt(case.height, 1.2, extrapolate=False)
    assert force_error(rows[case.seen(rows["t"])], case.height) < 0.05
