"""Damaged records: each is read up to its last sound tick, or refused with words."""

from __future__ import annotations

import tempfile
import warnings
from functools import cache
from pathlib import Path

import numpy as np

from palpate.base.errors import PalpateError
from palpate.record.reader import Record
from palpate.scene import Scene
from palpate.session import Session
from palpate_lab.verify.fuzz import FaultError
from palpate_lab.verify.fuzz.damage import damaged

_SCENE = "objects:\n  - name: floor\n    plane: {}\n    stiffness: 300\n"


def case(seed: int) -> dict[str, int]:
    """Read one damaged record.

    Raises:
        FaultError: the record was accepted, but its ticks are in disorder or it has more of them than were written.
    """
    rng = np.random.default_rng(seed)
    data, written = _record()
    with tempfile.TemporaryDirectory(prefix="palpate-fuzz-") as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        path = Path(folder) / "record.mcap"
        path.write_bytes(damaged(rng, data, 3))
        try:
            record = Record.open(path)
        except PalpateError:
            return {"refused": 1}
    t = record.ticks["t"]
    if len(t) > written or (np.diff(t) <= 0).any():
        raise FaultError(f"{len(t)} ticks of {written}, some of them not later than the one before")
    return {"complete" if record.complete else "cut": 1}


@cache
def _record() -> tuple[bytes, int]:
    """The bytes of a record of half a second, and the number of its ticks."""
    with tempfile.TemporaryDirectory(prefix="palpate-fuzz-") as folder:
        Session(Scene.parse(_SCENE), out=folder).run(0.6)
        path = next(Path(folder).rglob("*.mcap"))
        return path.read_bytes(), len(Record.open(path).ticks)
