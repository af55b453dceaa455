"""Short versions of the paper's items."""

import pytest

from palpate.reproduce.item import Work


@pytest.fixture
def work(tmp_path):
    return Work(1, tmp_path, 1)
