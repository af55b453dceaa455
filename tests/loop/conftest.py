import pytest
from loop_rig import floor, run, simulation


@pytest.fixture(scope="session")
def pressed():
    """Three seconds of approach, press, slide, leave with default options, on a floor with damping."""
    return run(simulation(floor(B=(2.0, 2.0, 2.0))), 3.0)
