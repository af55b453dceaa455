"""A certificate states the hands for which it holds; at the ends of this range the simulated axis agrees."""

from __future__ import annotations

import re

import numpy as np
import pytest

import palpate
from palpate.arm.hands import PRESETS
from palpate.devices.certificate import trials
from palpate.devices.certificate.words import LESS, hands_covered

DEVICES = {
    "light": palpate.DeviceModel(0.08, 0.2, 1000.0),
    "heavy, delayed": palpate.DeviceModel(0.4, 0.5, 1000.0, 0.004),
    "slow": palpate.DeviceModel(0.2, 0.8, 500.0, 0.001),
}


@pytest.mark.parametrize("name", DEVICES)
@pytest.mark.parametrize("B", [0.0, 2.0])
def test_limits_hold_at_both_ends_of_the_damping(name, B):
    """At 95 % of each limit every hand comes to rest, with its damping and with half of it; a little above not all."""
    device = DEVICES[name]
    found = palpate.certify(device, B=B)
    assert found.hand_damping == (1.5, 25.0)
    assert found.k_half_damping <= found.k_max
    for factor, limit in ((1.0, found.k_max), (LESS, found.k_half_damping)):
        hands = [hand.damped(factor) for hand in PRESETS.values()]
        assert not any(trials.oscillates(device, hand, 0.95 * limit, B) for hand in hands), factor
        assert any(trials.oscillates(device, hand, 1.05 * limit, B) for hand in hands), factor


def test_the_reason_names_the_hands():
    found = palpate.certify(DEVICES["light"], K=200.0)
    (number,) = re.findall(r"for hands of 1\.5 to 25 N s/m; with half of this damping below (\d+) N/m", found.reason)
    assert float(number) == pytest.approx(found.k_half_damping, rel=0.01)
    assert hands_covered([8.0], np.inf) == "for hands of 8 N s/m; with half of this damping below any N/m"
    figures = found.figures()
    assert figures.hand_damping_N_s_per_m == [1.5, 25.0]
    assert figures.k_half_damping_N_per_m == found.k_half_damping
