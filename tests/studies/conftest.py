import pytest


@pytest.fixture(autouse=True)
def quick_figures(unarranged_figures):
    """Every study draws its figures."""
