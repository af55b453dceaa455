import numpy as np
import pytest

import palpate
from palpate import _core


@pytest.fixture(scope="session")
def mtm():
    return palpate.Arm.mtm("right")


@pytest.fixture
def options(mtm):
    return mtm.leader_options()


@pytest.fixture
def frictionless(options):
    options.coulomb = options.viscous = np.zeros(7)
    return options


@pytest.fixture
def no_hand():
    """A hand without stiffness and damping, which only adds its mass."""
    hand = _core.HandOptions()
    hand.stiffness = hand.damping = hand.rotational_stiffness = hand.rotational_damping = 0.0
    return hand
