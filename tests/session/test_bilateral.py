"""The shipped bilateral scene: contact forces of tissue from drive torques, with a virtual keep-out zone."""

from pathlib import Path

import numpy as np
import pytest

from palpate import _core
from palpate.arm import Arm
from palpate.record.ticks import as_ticks
from palpate.scene import Scene
from palpate.scene.rig import build

SCENE = Path(__file__).parents[2] / "scenes" / "bilateral.yaml"
ERROR = 0.4  # rms error of the estimate without the dead band [N], by the friction of slow joints


@pytest.fixture(scope="module")
def scene() -> Scene:
    return Scene.load(SCENE)


@pytest.fixture(scope="module")
def ticks(scene):
    return as_ticks(build(scene).simulation().run(9000))


def norms(x: np.ndarray) -> np.ndarray:
    return np.linalg.norm(x, axis=1)


def test_free_motion_is_exactly_zero_through_the_dead_band(ticks):
    free = ~ticks["F_touch_W"].any(axis=1) & ~ticks["F_T_W"].any(axis=1)
    left = np.flatnonzero(np.diff(free.astype(int)) == 1) + 1
    assert free.sum() > 1500
    for k in left:
        free[k : k + 100] = False  # five time constants of the observer, and the ramp of the rate cap
    assert norms(np.diff(ticks["p_WT"][:1500], axis=0)).sum() > 0.01, "control: the tool moves"
    assert not ticks["F_estimate_W"][free].any()
    assert not ticks["F_H_L"][free].any()


def test_estimate_is_the_contact_force_minus_the_dead_band(ticks, scene):
    touch = norms(ticks["F_touch_W"])
    assert touch.max() > 2.0
    pressed = touch > 1.0
    expected = ticks["F_touch_W"] * np.maximum(1.0 - scene.force.dead_band / np.maximum(touch, 1e-9), 0.0)[:, None]
    error = norms(ticks["F_estimate_W"] - expected)[pressed]
    assert np.sqrt((error**2).mean()) < ERROR


def test_hand_gets_both_forces_within_the_caps(ticks, scene):
    """Without limiter, drive saturation or passivity the force is the sum, rotated into the leader's axes."""
    felt, expected = norms(ticks["F_H_L"]), norms(ticks["F_T_W"] + ticks["F_estimate_W"])
    uncut = (ticks["status"].astype(int) & 0x203F) == 0
    assert uncut.sum() > 3000
    np.testing.assert_allclose(felt[uncut], expected[uncut], atol=1e-9)
    assert felt.max() <= scene.stability.force_cap + 1e-9
    assert np.diff(felt).max() <= scene.stability.rate_cap * 1e-3 + 1e-9


def test_contact_law_and_drives_act_on_different_objects(ticks):
    """The zone (the second object) is rendered only virtually, the organ only through the drives."""
    assert set(ticks["touch_object"][ticks["contacts"] > 0][:, 0].astype(int)) == {1}
    assert norms(ticks["F_T_W"]).max() > 0.3
    both = (ticks["contacts"] > 0) & ticks["F_touch_W"].any(axis=1)
    assert both.sum() > 100


def test_silent_follower_ramps_the_force_down():
    """The drives carry 1.5 N and the weight, then fall silent: stale after 30 ms, a ramp of 50 N/s, exactly 0."""
    leader, follower = Arm.mtm("right"), Arm.psm()
    options = _core.CycleOptions()
    options.source = "estimate"
    options.stability.passivity = "off"  # tests only limits and silence
    cycle = _core.Cycle(options, leader, follower)
    q = np.array([0.2, -0.3, 0.12, 0.4, 0.2, -0.3])
    tau = follower.gravity(q) - follower.jacobian(q).T @ [0.0, 0.0, 1.5, 0.0, 0.0, 0.0]
    rows, silent_at = [], 0.4
    for k in range(700):
        t = 1e-3 * k
        row, *_ = cycle.step(
            t, leader.home, np.zeros(7), 0.0, q, 0.0, _core.Snapshot([]), t_follower=min(t, silent_at),
            v_follower=np.zeros(6), tau_follower=tau,
        )  # fmt: skip
        rows.append(as_ticks(row)[0])
    F = np.array([row["F_H_L"] for row in rows])
    assert np.linalg.norm(F[400]) == pytest.approx(1.5, rel=0.01)
    np.testing.assert_allclose(F[400:431], np.broadcast_to(F[400], (31, 3)), rtol=0.0, atol=1e-14)  # to rounding
    steps = norms(np.diff(F[430:], axis=0))
    assert steps.max() <= 0.05 + 1e-12
    assert not F[465:].any()
    assert not np.array([row["F_estimate_W"] for row in rows[432:]]).any()
    assert all(int(row["status"]) & 8 for row in rows[432:])


@pytest.mark.parametrize("torque", [1e3, 1e9, 1e200, np.nan])
def test_impossible_torques_give_no_force_and_no_later_error(torque):
    """A glitch of the drive torques is reported but not rendered, and has no effect afterwards."""
    leader, follower = Arm.mtm("right"), Arm.psm()
    options = _core.CycleOptions()
    options.source = "estimate"
    options.stability.passivity = "off"
    cycle = _core.Cycle(options, leader, follower)
    q = np.array([0.2, -0.3, 0.12, 0.4, 0.2, -0.3])
    valid = follower.gravity(q) - follower.jacobian(q).T @ [0.0, 0.0, 1.5, 0.0, 0.0, 0.0]
    rows = []
    for k in range(900):
        tau = np.full(6, torque) if 400 <= k < 410 else valid
        row, *_ = cycle.step(
            1e-3 * k, leader.home, np.zeros(7), 0.0, q, 0.0, _core.Snapshot([]), t_follower=1e-3 * k,
            v_follower=np.zeros(6), tau_follower=tau,
        )  # fmt: skip
        rows.append(as_ticks(row)[0])
    no_torques = next(bit for name, bit, _ in _core.status_words() if name == "no_torques")
    assert [k for k, row in enumerate(rows) if int(row["status"]) & no_torques] == list(range(400, 410))
    assert not np.array([row["F_estimate_W"] for row in rows[400:410]]).any()
    F = norms(np.array([row["F_H_L"] for row in rows]))
    assert F[400:].max() <= F[399] * 1.001, "a glitch adds no force"
    assert F[-1] == pytest.approx(F[399], rel=0.01)
