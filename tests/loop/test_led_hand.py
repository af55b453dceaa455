"""A hand that an operator positions tick by tick: it is at the commanded points, and all else is unchanged."""

import numpy as np
import pytest
from loop_rig import HEIGHT, options, simulation

from palpate import _core
from palpate.record.ticks import SIGNALS, as_ticks

DETERMINISTIC = [name for name, s in SIGNALS.items() if s.deterministic]
REST = _core.HandPath([0.0], np.array([[0.0, 0.0, HEIGHT]]))


def random_walk(n, seed=0):
    """A random walk (n, 3) of some millimetres [m]."""
    return np.cumsum(np.random.default_rng(seed).normal(0.0, 2e-5, (n, 3)), axis=0)


def test_hand_is_at_the_commanded_point_at_the_end_of_each_tick():
    led, idle = simulation(path=REST), simulation(path=REST)
    hand_W = random_walk(400)
    a, b = as_ticks(led.run(400, hand_W)), as_ticks(idle.run(400))
    moved_W = (a["p_hand_L"] - b["p_hand_L"]) @ options().X_WL[:3, :3].T
    np.testing.assert_allclose(moved_W[1:], hand_W[:-1], atol=1e-12)  # a row has the state at the start of its tick


def test_commands_in_pieces_equal_commands_at_once():
    whole, pieces = simulation(tremor=1e-4), simulation(tremor=1e-4)
    hand_W = random_walk(300)
    a = as_ticks(whole.run(300, hand_W))
    b = np.concatenate([as_ticks(pieces.run(len(some), some)) for some in np.split(hand_W, [1, 11, 150])])
    for name in DETERMINISTIC:
        assert a[name].tobytes() == b[name].tobytes(), name


def test_run_without_commands_is_unchanged_and_a_released_hand_stays():
    a, b = simulation(), simulation()
    rows = as_ticks(a.run(200, np.zeros((200, 3)))), as_ticks(b.run(200))
    for name in DETERMINISTIC:
        np.testing.assert_array_equal(rows[0][name], rows[1][name], err_msg=name)
    sim = simulation(path=REST)
    sim.run(50, np.linspace([0, 0, 0], [1e-3, 0, 0], 50))
    after = as_ticks(sim.run(100))["p_hand_L"]
    np.testing.assert_allclose(after, after[:1].repeat(100, axis=0), atol=1e-6)  # residual of the transition


@pytest.mark.parametrize("points", [np.zeros((9, 3)), np.full((10, 3), np.nan)])
def test_commands_need_one_finite_point_per_tick(points):
    with pytest.raises(ValueError, match=r"hand_W must have shape \(10, 3\), a finite point for each tick"):
        simulation().run(10, points)
