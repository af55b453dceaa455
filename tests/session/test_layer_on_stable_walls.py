"""The passivity layer leaves the force of a wall that is certified with a margin of 1.5 to the hands that tap on it.

Taps of 2 N at 2.5 Hz, by each leader that comes with Palpate. A force that the rate cap holds back on the way in, and
not on the way out, gives the hand energy, and the layer must take it: the default rate cap follows the stiffness.
"""

import numpy as np
import pytest

import palpate
from palpate.arm.hands import PRESETS

K, FORCE, RATE = 2000.0, 2.0, 2.5  # [N/m], [N], [Hz]
LEADERS = ("mtm_right", "delta", "six_axis")
BASES = {"mtm_right": {"xyz": [0.345, 0.243, 0.219], "rpy_deg": [0, 0, -20]}}
MARGIN, SHARE, LOSS = 1.5, 0.05, 0.02


def tapping(leader, hand, **stability):
    """A hand that taps on a plane without damping."""
    depth, touch, arm = FORCE / K + FORCE / PRESETS[hand].stiffness, 0.002, {"model": leader}
    if leader in BASES:
        arm["base"] = BASES[leader]
    heights = [touch + 0.3 * depth, touch - depth]
    path = [{"t": 0.5 * k / RATE, "xyz": [0, 0, heights[k % 2]]} for k in range(13)]
    return palpate.Scene.model_validate(
        {
            "objects": [{"name": "wall", "plane": {"size": 0.3}, "stiffness": K, "damping": 0.0}],
            "arms": {"leader": arm, "follower": {"bandwidth": 0}},
            "mapping": {"scale": 1.0},
            "operator": {"hand": hand, "path": path},
            "stability": stability,
        }
    )


def felt(scenes):
    """Of each run the share of the contact in which the layer acts, and the mean force in contact [N]."""
    runs = palpate.simulate(
        [palpate.Variation(one, {}) for one in scenes], duration=2.4, signals=["F_H_L", "F_withheld"], signal_rate=1000
    )
    force = np.linalg.norm(runs.signals["F_H_L"], axis=2)
    taken = runs.signals["F_withheld"][:, :, 2]
    touches = force + taken > 0.01
    share = ((taken > 1e-6) & touches).sum(axis=1) / touches.sum(axis=1)
    return share, (force * touches).sum(axis=1) / touches.sum(axis=1)


@pytest.mark.parametrize("leader", LEADERS)
def test_layer_acts_in_at_most_a_twentieth_of_the_contact(leader):
    hands = ["light", "normal", "rigid"]
    scenes = [tapping(leader, hand) for hand in hands]
    for scene in scenes:
        assert palpate.certify(scene).k_max > MARGIN * K, "the wall is certified with the margin"
    share, force = felt(scenes + [tapping(leader, hand, passivity="off") for hand in hands])
    assert share.max() <= SHARE
    np.testing.assert_allclose(force[: len(hands)], force[len(hands) :], rtol=LOSS)


def test_control_a_rate_cap_that_the_wall_outruns_costs_force():
    share, force = felt([tapping("mtm_right", "normal", rate_cap=50.0, passivity=mode) for mode in ("observer", "off")])
    assert share[0] > 0.2
    assert force[0] < 0.8 * force[1]


def test_rate_cap_that_is_not_given_follows_the_felt_stiffness():
    def cap(stiffness, scale=1.0, **stability):
        wall = {"name": "wall", "plane": {}, "stiffness": stiffness}
        return palpate.Scene.model_validate(
            {"objects": [wall], "mapping": {"scale": scale}, "stability": stability}
        ).stability.rate_cap

    assert [cap(400), cap(500), cap(2000), cap(2000, 0.5)] == [50, 50, 350, 150]
    assert cap(2000, rate_cap=40) == 40
    assert cap(2000, force_cap=2) == 350
