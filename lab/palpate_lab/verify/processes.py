"""The end of processes that a measurement started."""

from __future__ import annotations

import subprocess
from typing import Any


def end(process: subprocess.Popen[Any], patience: float = 10.0) -> None:
    """Ask a process to end and wait for it; one that has not ended after `patience` [s] is killed."""
    if process.poll() is not None:
        return
    process.terminate()
    try:
        process.wait(patience)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
