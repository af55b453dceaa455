"""Live objects in the loop: they act as objects with a prescribed motion do, with friction, energy and damping."""

import numpy as np
import pytest
from live_rig import PERIOD, Driven, live_floor, pose
from loop_rig import HEIGHT, floor, run, simulation

from palpate import _core
from palpate.base.arrays import rigid
from palpate.record.ticks import STATUS, as_ticks

K, MU, RATE = 400.0, 0.4, 1000.0
OFF = {"stability__passivity": "off"}
PRESS = _core.HandPath([0.1, 1.0], np.array([[0, 0, HEIGHT], [0, 0, -0.006]]))
START = 1500  # tick at which objects begin to move, when the tool rests on them
STILL = np.zeros(6)


def along(V):
    """A target with a constant velocity from t = 0."""
    V = np.asarray(V, float)

    def target(t):
        X = np.eye(4)
        X[:3, :3], X[:3, 3] = rigid.exp(V[3:] * t), V[:3] * t
        return X, V, False

    return target


@pytest.mark.parametrize(
    "V",
    [[0.004, 0, 0, 0, 0, 0], [0, 0, 0.002, 0, 0, 0], [0.002, 0.001, 0.001, 0.02, -0.03, 0.05]],
    ids=["tangential", "normal", "screw"],
)
def test_an_object_at_constant_velocity_feels_like_one_with_a_prescribed_motion(V):
    """Force within 1 mN of at least 1.8 N, and every energy within 0.5 % of the largest, with friction and damping.

    What remains is the start: a live object has to gain its speed first. The encoders make it a few counts.
    """
    live = Driven(along(V), live_floor(mu=MU, B=2.0), PRESS, **OFF).run(2.5)
    moved = live_floor(mu=MU, B=2.0, motion=_core.Motion(v=np.array(V[:3], float), w=np.array(V[3:], float)))
    told = run(simulation(moved, PRESS, **OFF), 2.5)
    assert np.linalg.norm(told["F_T_W"], axis=1).max() > 1.8
    np.testing.assert_allclose(live["F_T_W"], told["F_T_W"], atol=1e-3)
    largest = np.abs(told["energy_spring"]).max()
    for name in ("port", "spring", "damping", "cut", "source"):
        np.testing.assert_allclose(live[f"energy_{name}"], told[f"energy_{name}"], atol=5e-3 * largest, err_msg=name)


def from_start(t, v=0.004):
    """Target of a floor that moves along x from START on."""
    s = max(t - START / RATE, 0.0)
    return pose([v * s, 0, 0]), np.array([v if s > 0 else 0.0, 0, 0, 0, 0, 0]), False


def stick_error(ticks, x_floor):
    """Largest difference of the friction from K times the displacement of floor against tool, while below mu N [N]."""
    x, F = ticks["p_WT"][START:, 0], ticks["F_T_W"][START:]
    lag = (x_floor[START:] - x_floor[START - 1]) - (x - ticks["p_WT"][START - 1, 0])
    sticks = np.cumsum(np.abs(K * lag) >= 0.99 * MU * F[:, 2]) == 0
    assert sticks.sum() > 300
    return float(np.abs(F[sticks, 0] - ticks["F_T_W"][START - 1, 0] - K * lag[sticks]).max())


def test_a_moving_floor_carries_the_tool_and_slips_at_mu_n():
    """Stick: F = K (floor's displacement - tool's displacement). Slip: |F_t| = mu F_n, whatever the distance."""
    ticks = Driven(from_start, live_floor(mu=MU), PRESS, **OFF).run(3.5)
    assert stick_error(ticks, ticks["live_p"][:, 0]) < 1e-9
    assert ticks["p_WT"][-1, 0] > 9e-4, "the hand is carried along"
    F = ticks["F_T_W"][-500:]
    assert ticks["live_p"][-1, 0] == pytest.approx(0.004 * (3.499 - 1.5), abs=1e-9)
    np.testing.assert_allclose(F[:, 0], MU * F[:, 2], rtol=1e-4)


def test_the_judge_finds_friction_that_is_forgotten_at_every_pose():
    """The check above, on poses that are set as new objects every 10 ms."""
    sim, rows = simulation(floor(mu=MU), PRESS, **OFF), []
    x = []
    for k in range(0, 2500, PERIOD):
        X = from_start(k / RATE)[0]
        other = floor(mu=MU).objects[0]
        sim.set_snapshot(_core.Snapshot([_core.Object("floor", other.surface, X, other.material)]))
        rows.append(sim.run(PERIOD))
        x += [X[0, 3]] * PERIOD
    assert stick_error(as_ticks(np.concatenate(rows)), np.array(x)) > 0.3


def test_a_snapshot_with_the_same_objects_keeps_the_contact():
    """Another stiffness while the tool sticks: the anchor stays, so the friction is K times the same displacement."""
    scene = live_floor(mu=MU)
    driven = Driven(from_start, scene, PRESS, **OFF)
    before = driven.run(1.7)[-1]
    softer = _core.Material(K=np.full(3, 300.0), B=np.zeros(3), mu=MU)
    live = _core.LiveOptions(speed=0.2, turn=1.0, acceleration=2.0)
    for surface in (scene.objects[0].surface, floor().objects[0].surface):
        driven.sim.set_snapshot(_core.Snapshot([_core.Object("floor", surface, np.eye(4), softer, live=live)]))
        after = driven.run(0.01)[0]
        if surface is scene.objects[0].surface:
            assert after["live_p"][0] == pytest.approx(before["live_p"][0], abs=1e-5)
            assert after["F_T_W"][0] == pytest.approx(300.0 * before["F_T_W"][0] / K, rel=0.02)
    assert after["F_T_W"][0] == pytest.approx(0.0, abs=0.01), "another surface: contact starts anew"


def test_a_jump_of_5_mm_reaches_the_force_gradually():
    """Per tick the force grows by K v dt at most; it settles at K times the depth; the tool never passes through."""
    up = lambda t: (pose([0, 0, 0.005 if t >= START / RATE else 0.0]), STILL, False)  # noqa: E731
    ticks = Driven(up, live_floor(speed=0.05, acceleration=0.5), PRESS, **OFF).run(3.5)
    F = ticks["F_T_W"][:, 2]
    assert np.abs(np.diff(F[START - 1 :])).max() <= K * 0.05 / RATE * 1.01
    assert np.linalg.norm(np.diff(ticks["F_H_L"][START - 1 :], axis=0), axis=1).max() * RATE < 50.0
    depth = ticks["live_p"][-1, 2] - ticks["p_WT"][-1, 2] + 0.002  # the tool's sphere has a radius of 2 mm
    assert F[-1] == pytest.approx(K * depth, rel=1e-3)
    assert ticks["live_p"][-1, 2] == pytest.approx(0.005, abs=3e-4)
    assert ticks["normal"][START:, 2].min() > 0.999
    assert ticks["depth"].max() < 0.012


def test_targets_that_stop_stop_the_object_and_fade_its_force():
    """No target for longer than max_age: velocity to zero, status bit, force to zero in the time `fade`; and back."""

    def rising(t):
        if 2.0 <= t < 3.2:
            return None
        return pose([0, 0, 0.003 * min(max(t - 1.5, 0.0), 0.5)]), STILL, False

    ticks = Driven(rising, live_floor(max_age=0.2, fade=0.4), PRESS, **OFF).run(4.5)
    lost = (ticks["status"].astype(int) & STATUS["frame_lost"][0]) != 0
    first = int(np.flatnonzero(lost)[0])
    assert 2190 <= first <= 2195
    assert not lost[3210:].any()
    z = ticks["live_p"][:, 2]
    assert np.ptp(z[first + 300 : 3190]) < 1e-9
    share = ticks["live_share"][:, 0]
    np.testing.assert_allclose(share[first : first + 400], 1.0 - np.arange(1, 401) / 400.0, atol=0.01)
    assert np.abs(ticks["F_T_W"][first + 410 : 3190]).max() == 0.0
    np.testing.assert_allclose(np.diff(share[3210:3500]), 2.5e-3, atol=1e-9)
    held = ticks["F_T_W"][[1990, -1], 2]
    assert held[1] == pytest.approx(held[0], rel=0.05)


def test_an_object_starts_at_its_pose_in_the_snapshot_whenever_targets_begin():
    """A floor 3 mm lower than in the other tests, with its first target after 1 s; it never leaves its place."""
    X, floor_O = pose([0.01, -0.02, -0.003]), live_floor().objects[0]
    live = _core.LiveOptions()
    scene = _core.Snapshot([_core.Object("floor", floor_O.surface, X, floor_O.material, live=live)])
    ticks = Driven(lambda t: (X, STILL, False) if t >= 1.0 else None, scene, PRESS, **OFF).run(1.5)
    np.testing.assert_array_equal(ticks["live_p"][:, :3], np.tile(X[:3, 3], (1500, 1)))
    still = _core.Snapshot([_core.Object("floor", floor_O.surface, X, floor_O.material)])
    np.testing.assert_array_equal(ticks["F_T_W"], run(simulation(still, PRESS, **OFF), 1.5)["F_T_W"])


def test_lockstep_with_live_objects_is_repeatable_in_any_pieces():
    def rows(pieces):
        sim, k = simulation(live_floor(mu=MU), PRESS, **OFF), 0
        for n in pieces:
            if k % PERIOD == 0:
                targets = _core.LiveTargets()
                targets.add(k / RATE, pose([0.001 * k / RATE, 0, 0]))
                sim.set_live(targets)
            last, k = sim.run(n), k + n
        return last[-1]

    a, b = as_ticks(rows([10] * 150)), as_ticks(rows([3, 7] * 150))
    assert all(a[name].tobytes() == b[name].tobytes() for name in ("F_T_W", "p_WT", "q", "tau", "live_p"))


def test_wrong_numbers_of_targets_are_refused():
    sim = simulation(live_floor(), PRESS)
    with pytest.raises(ValueError, match="0 targets for 1 live objects"):
        sim.set_live(_core.LiveTargets())
    with pytest.raises(ValueError, match="at most 8"):
        simulation(_core.Snapshot([live_floor().objects[0]] * 9), PRESS)
    with pytest.raises(ValueError, match="above 0"):
        _core.LiveOptions(speed=0.0)
    moving = _core.Motion(v=np.array([0.01, 0, 0]))
    with pytest.raises(ValueError, match="no motion of its own"):
        _core.Object("floor", floor().objects[0].surface, np.eye(4), motion=moving, live=_core.LiveOptions())
