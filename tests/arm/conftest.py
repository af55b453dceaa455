import numpy as np
import pytest

import palpate


@pytest.fixture(scope="session", params=["mtm_right", "mtm_left", "psm_lnd"])
def arm(request):
    kind, which = request.param.split("_")
    return getattr(palpate.Arm, kind)(which)


@pytest.fixture
def poses(arm):
    """Forty poses spread over the joint range, from a fixed seed."""
    return np.random.default_rng(2).uniform(arm.q_min, arm.q_max, (40, arm.n))
