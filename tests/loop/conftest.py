import pytest
from loop_rig import floor, run, simulation


@pytest.fixture(scope="session")
def pressed():
    """Ticks of three seconds: approach, press, slide and retract with default options, on a floor with damping."""
    return run(simulation(floor(B=(2.0, 2.0, 2.0))), 3.0)
