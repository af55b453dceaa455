"""Short versions of the paper's items."""

import pytest

from palpate_lab.reproduce.item import Work


@pytest.fixture(autouse=True)
def quick(unarranged_figures, sweeps_in_process):
    """All items draw figures, and many sweep."""


@pytest.fixture
def work(tmp_path):
    return Work(1, tmp_path, 1)
