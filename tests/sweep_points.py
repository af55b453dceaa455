"""Functions for the tests of sweeps; the workers import them from this module."""

import os
import signal
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np


def draw(point, seed):
    """A number that depends on the point and on its seed, through BLAS."""
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(60, 60))
    return {"x": float((A @ A)[0, 0]) * point["K"], "whole": np.int64(point["K"]), "name": point["law"]}


def slow(point, seed):
    """Append one line per call to a file of this process in the folder of the point."""
    with (Path(point["folder"]) / str(os.getpid())).open("a") as log:
        log.write(f"{point['k']}\n")
    time.sleep(0.02)
    return {"x": seed % 1000 + point["k"]}


def endless(point, seed):
    """Say which process works at the point, and work on for two minutes."""
    (Path(point["folder"]) / str(os.getpid())).touch()
    time.sleep(120.0)
    return {}


def deadly(point, seed):
    if point["k"] == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    return {"x": point["k"]}


def picky(point, seed):
    if point["k"] in (2, 5):
        raise ValueError(f"no {point['k']} today")
    return {"x": point["k"]}


@dataclass(frozen=True)
class Drawn:
    x: float
    whole: np.int64
    name: str


def draw_typed(point, seed):
    """The numbers of `draw` as a dataclass."""
    return Drawn(**draw(point, seed))


def rich(point, seed):
    none = point["K"] > 1 or None
    return {"list": [1.0, point["K"]], "by cap": {"5": 0.5, "50": None}, "word": "wavy" * point["k"], "yes": none}


if __name__ == "__main__":
    import sys

    from palpate.base.sweep import sweep

    folder, journal = sys.argv[1:]
    sweep(slow, {"k": range(200), "folder": [folder]}, 7, workers=2, resume=journal)
