"""Fixed seeds for every property test, so that failures are reproducible on all machines; what one worker runs alone."""

from pathlib import Path

import pytest
from hypothesis import settings

settings.register_profile("palpate", derandomize=True, deadline=None)
settings.load_profile("palpate")

_ROS = Path(__file__).parent / "ros"


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Groups for ``--dist loadgroup``: the tests of a file stay together, and one worker runs all tests on ROS 2.

    Those are real processes at 1 kHz that mostly wait. Two at a time would take each other's processor time.
    """
    for item in items:
        group = "ros" if _ROS in item.path.parents else str(item.path)
        item.add_marker(pytest.mark.xdist_group(group))
