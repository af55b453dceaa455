"""One pair goes through a fault and back, tick by tick, while the other pair stays in contact and is unaffected."""

import numpy as np
from crtk_rig import DT, Device
from loop_rig import floor

from palpate.record.ticks import as_ticks
from palpate.session import machine

RATE_CAP = 50.0
"""Largest change of the force on the hand [N/s]."""
DEEP = 0.045
"""Depth of the handles below their start: both tools are in the floor [m]."""


DRIFT = 5e-6
"""Motion of the faulty pair's hand in a tick, also while it is not heard [m]."""


def two():
    """Two devices that share one scene, both in contact and in `following`."""
    scene = floor()
    devices = [Device(scene=scene, rate_cap=RATE_CAP) for _ in range(2)]
    for device in devices:
        device.run(0.3)
        device.run(0.5, to=DEEP)
        assert machine.name_of(ticks_of(device)["session_state"][-1]) == "following"
        assert np.linalg.norm(ticks_of(device)["F_H_L"][-1]) > 0.3
    return devices


def ticks_of(device):
    return as_ticks(np.array(device.rows))


def walk(device, other, seconds, **gates):
    """Steps both devices in turns, the first with its own gates."""
    for name, value in gates.items():
        setattr(device.gates, name, value)
    for _ in range(round(seconds / DT)):
        device.run(DT, to=device.depth + DRIFT)
        other.run(DT)


def through_a_fault(device, other):
    """Silence, messages again while the arm is not enabled yet, then enabled; returns its ticks from before on."""
    first = len(device.rows) - 1
    device.silent = True
    walk(device, other, 0.3)
    device.silent = False
    walk(device, other, 0.3, leader_enabled=False)
    walk(device, other, 0.6, leader_enabled=True)
    return ticks_of(device)[first:]


def largest_steps(ticks, options):
    """Largest rise and fall of the force in a tick over what is allowed, and of the goal over the hand's motion [-].

    The force rises at the rate cap. In a fault it falls from the force cap to zero within `release`.
    """
    F, p = ticks["F_H_L"], ticks["p_WT_goal"]
    steps = np.linalg.norm(np.diff(F, axis=0), axis=1)
    rises = np.diff(np.linalg.norm(F, axis=1)) > 0.0
    fall = max(RATE_CAP, options.stability.force_cap / options.release) * DT
    goal = np.linalg.norm(np.diff(p, axis=0), axis=1).max() / DRIFT
    return steps[rises].max() / (RATE_CAP * DT), steps[~rises].max() / fall, goal


def test_fault_recover_homing_following_without_a_step():
    device, other = two()
    ticks = through_a_fault(device, other)
    states, F = ticks["session_state"], np.linalg.norm(ticks["F_H_L"], axis=1)
    changes = np.flatnonzero(np.diff(states)) + 1
    assert [machine.name_of(x) for x in states[[0, *changes]]] == [
        "following", "fault", "recover", "homing", "following",
    ]  # fmt: skip
    assert max(largest_steps(ticks, device.options)) <= 1.0 + 1e-9
    fault, back = changes[0], changes[-1]
    rest = ticks["p_WT_goal"][fault:back]
    assert np.linalg.norm(np.diff(rest, axis=0), axis=1).max() < 1e-9, "the goal rests until the tool follows again"
    fallen = fault + round(device.options.release / DT) + 1
    assert not F[fallen:back].any(), "no force outside of following"
    assert F[-1] > 0.3, "the force comes back"


def test_the_other_pair_is_unaffected():
    device, other = two()
    first = len(other.rows)
    through_a_fault(device, other)
    _, alone = two()
    alone.run(len(other.rows[first:]) * DT)
    disturbed, quiet = ticks_of(other), ticks_of(alone)
    for name in ("F_H_L", "p_WT_goal", "p_WT", "session_state", "energy_port"):
        np.testing.assert_allclose(disturbed[name][first:], quiet[name][first:], rtol=0, atol=1e-12)
    assert {machine.name_of(x) for x in disturbed["session_state"][first:]} == {"following"}


def test_a_step_in_a_fault_would_be_noticed():
    device, other = two()
    ticks = through_a_fault(device, other)
    for signal, by in (("F_H_L", 0.2), ("F_H_L", -0.2), ("p_WT_goal", 1e-4)):
        for at in (35, 400, len(ticks) - 5):
            wrong = ticks.copy()
            wrong[signal][at:] += [0.0, 0.0, by]
            assert max(largest_steps(wrong, device.options)) > 1.0 + 1e-9, (signal, by, at)
