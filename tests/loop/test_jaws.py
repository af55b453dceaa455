"""The jaws: the pinch program of the hand, their angle at the start, and the torque of contacts on jaws and fingers."""

import numpy as np
import pytest
from loop_rig import HEIGHT, Q_FOLLOWER, Q_LEADER, floor, options, run, simulation

from palpate import _core
from palpate.arm import Arm
from palpate.record.ticks import as_ticks
from palpate.scene.tool import tool_spheres

STAY = np.array([[0.0, 0.0, HEIGHT]])


def test_pinch_moves_by_minimum_jerk_between_its_own_times():
    path = _core.HandPath([0.0, 5.0], np.repeat(STAY, 2, axis=0), [1.0, 0.2], [1.0, 3.0])
    s = np.linspace(0.0, 1.0, 9)
    wanted = 1.0 - 0.8 * s**3 * (10.0 - 15.0 * s + 6.0 * s**2)  # Flash and Hogan 1985
    assert [path.at(1.0 + 2.0 * x)[2] for x in s] == pytest.approx(wanted, abs=1e-12)
    assert (path.at(0.0)[2], path.at(9.0)[2]) == (1.0, 0.2)
    for times, word in (([1.0, 1.0], "not after"), ([1.0, np.nan], "not finite"), ([1.0], "pinch angles")):
        with pytest.raises(ValueError, match=word):
            _core.HandPath([0.0], STAY, [1.0, 0.2], times)


def test_jaw_starts_at_its_angle_and_closes_at_its_rate():
    path = _core.HandPath([0.0], STAY, [0.9, 0.0], [0.2, 0.25])
    ticks = run(simulation(path=path, mapping__jaw_start=0.9, mapping__jaw_rate=1.5), 1.0)
    assert ticks["jaw"][0] == 0.9
    closing = np.diff(ticks["jaw_goal"])
    assert closing.min() == pytest.approx(-1.5e-3)
    assert ticks["jaw"][-1] == pytest.approx(0.0, abs=0.01)


def test_ratchet_keeps_an_almost_closed_jaw_until_the_pinch_has_closed_to_it():
    path = _core.HandPath([0.0], STAY, [0.8, 0.8, 0.2, 0.8], [0.0, 0.5, 1.0, 1.6])
    ticks = run(simulation(path=path, mapping__jaw_start=0.4, mapping__ratchet=True), 2.2)
    assert (ticks["jaw"][:600] == 0.4).all(), "no jaw opens by itself when the tool begins to follow"
    assert ticks["jaw"][1100] == pytest.approx(0.2, abs=0.05)
    assert ticks["jaw"][-1] == pytest.approx(0.8, abs=0.05)


@pytest.fixture(scope="module")
def at_jaw():
    """A tick of the cycle with the jaws at an angle [rad], their tips 1 to 2 mm deep in a rigid floor."""
    o = options()
    o.contact.spheres = [s.core for s in tool_spheres(Arm.psm("lnd"), [], True)]
    X_WB = o.X_WB.copy()
    X_WB[2, 3] -= HEIGHT - 0.0075  # the tip T is 7.5 mm above the floor
    o.X_WB = X_WB

    def tick(jaw):
        cycle = _core.Cycle(o, Arm.mtm("right"), Arm.psm("lnd"))
        row, _, _ = cycle.step(0.001, Q_LEADER, np.zeros(7), 0.5, Q_FOLLOWER, jaw, floor())
        return as_ticks(np.atleast_2d(row))[0]

    return tick


def test_torque_on_the_jaws_is_the_slope_of_the_springs_energy(at_jaw):
    """Virtual work: the torque is minus the derivative of the energy of the contact springs by the jaw angle."""
    h = 1e-4
    for jaw in (0.4, 0.8, 1.1):
        energy = [(np.asarray(at_jaw(jaw + d)["touch_force"]) ** 2).sum() / (2.0 * 400.0) for d in (-h, h)]
        torque = float(at_jaw(jaw)["tau_jaw"])
        assert at_jaw(jaw)["contacts"] == 2, "both jaws touch"
        assert torque == pytest.approx(-(energy[1] - energy[0]) / (2 * h), rel=1e-3)
        assert torque > 1e-4, "the floor opens the jaws further"
    assert at_jaw(0.8)["tau_gripper"] == 0.0, "the gripper of a dVRK has no motor"


def test_gripper_limiter_bounds_torque_and_rate():
    o = options(stability__gripper_cap=1e-4, mapping__jaw_start=0.8)
    o.contact.spheres = [s.core for s in tool_spheres(Arm.psm("lnd"), [], True)]
    path = _core.HandPath([0.1, 0.8], np.array([[0, 0, HEIGHT], [0, 0, 0.0065]]), [0.8], [0.0])
    arm = Arm.mtm("right")
    ticks = as_ticks(_core.Simulation(o, arm, arm, Arm.psm("lnd"), floor(), path).run(1500))
    ratio = o.mapping.force_scale / o.mapping.scale  # of the powers at hand and tool; both angles have the same range
    wanted = ratio * ticks["tau_jaw"]
    assert wanted.max() > 2e-4
    assert np.abs(ticks["tau_gripper"]).max() == pytest.approx(1e-4)
    assert np.abs(np.diff(ticks["tau_gripper"])).max() <= 1e-4 * 1e-3 / 0.05 * (1 + 1e-9)
    below = (np.abs(wanted) < 0.5e-4) & (wanted > 0)
    assert below.any()
