"""The passivity layer changes no force in the shipped scenes that docs/stability.md names."""

from pathlib import Path

import numpy as np
import pytest

import palpate

SCENES = Path(__file__).resolve().parents[2] / "scenes"


def forces(name, **changes):
    """Forces on the hand (n, 3) over 20 s with the layer and without."""
    scene = palpate.Scene.load(SCENES / f"{name}.yaml")
    runs = [palpate.Variation(scene, {"stability.passivity": mode, **changes}) for mode in ("observer", "off")]
    found = palpate.simulate(runs, duration=20.0, signals=["F_H_L"], signal_rate=1000.0)
    return found.signals["F_H_L"]


@pytest.mark.parametrize("name", ["palpation", "paper", "solids", "breathing", "nodule"])
def test_the_force_is_the_same_to_the_last_bit(name):
    on, off = forces(name)
    assert np.abs(on).max() > 0.5, "control: the scene is felt"
    np.testing.assert_array_equal(on, off)


def test_control_a_delayed_loop_needs_the_layer():
    on, off = forces("palpation", loop_delay=0.1)
    assert np.abs(on - off).max() > 0.1
