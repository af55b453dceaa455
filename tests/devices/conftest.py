"""A stand-in of an event device of Linux."""

import os

import pytest


@pytest.fixture
def pipe(tmp_path):
    """Path of a named pipe, and the open end that writes events into it."""
    path = tmp_path / "event"
    os.mkfifo(path)
    reader = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
    with path.open("wb", buffering=0) as writer:
        yield str(path), writer
    os.close(reader)
