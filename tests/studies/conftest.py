import pytest


@pytest.fixture(autouse=True)
def quick(unarranged_figures, sweeps_in_process):
    """Every study draws its figures, and most sweep."""
