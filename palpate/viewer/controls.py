"""Sets controls of the page from the program."""

from typing import Any


def set_value(handle: Any, value: Any) -> None:
    """Sets a control from the program (viser's setter takes more than its getter gives: mypy cannot follow)."""
    handle.value = value
