"""Damaged tables: places of paths and clouds, and recordings of an arm, as CSV. Each is read or refused with words."""

from __future__ import annotations

import tempfile
import warnings
from functools import cache
from pathlib import Path

import numpy as np

from palpate.arm import Arm
from palpate.arm.identify.recordings import read_moving, read_static
from palpate.base.errors import PalpateError
from palpate.scene.guidance import curve
from palpate.scene.guidance.files import HEADER, read_rows
from palpate_lab.verify.fuzz import FaultError
from palpate_lab.verify.fuzz.damage import damaged

KINDS = ("places", "attitudes", "static", "moving")


def case(seed: int) -> dict[str, int]:
    """Read one damaged table, and query the path through its places.

    Raises:
        FaultError: a table was accepted with values that are not finite, or its path answers with such values.
    """
    rng = np.random.default_rng(seed)
    kind = str(rng.choice(KINDS))
    with tempfile.TemporaryDirectory(prefix="palpate-fuzz-") as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        path = Path(folder) / "table.csv"
        path.write_bytes(damaged(rng, _table(kind, rng)))
        try:
            _read(kind, path)
        except PalpateError:
            return {"refused": 1, kind: 1}
    return {"read": 1, kind: 1}


def _read(kind: str, path: Path) -> None:
    if kind == "static":
        found = read_static(path, _arm())
        _require(np.isfinite(found.q).all() and np.isfinite(found.tau).all(), "a pose is not finite")
    elif kind == "moving":
        motion = read_moving(path, 7)
        _require(np.isfinite(np.hstack([motion.q, motion.v, motion.tau])).all(), "a sample is not finite")
    else:
        places, rotations = read_rows(path)
        turned = rotations if rotations is not None else np.eye(3)
        _require(np.isfinite(places).all(), "a place is not finite")
        _require(np.allclose(turned @ np.swapaxes(turned, -1, -2), np.eye(3), atol=1e-6), "an attitude is no rotation")
        answer = curve.path(places, rotations, name=str(path)).query(np.eye(4)[None], np.zeros(1))
        _require(np.isfinite(answer["distance"]).all(), "the distance to the path is not finite")


def _require(holds: bool | np.bool_, fault: str) -> None:
    if not holds:
        raise FaultError(fault)


@cache
def _arm() -> Arm:
    return Arm.mtm("right")


def _table(kind: str, rng: np.random.Generator) -> bytes:
    """A valid table with the values of a random walk."""
    rows = int(rng.integers(2, 12))
    if kind in ("places", "attitudes"):
        names = HEADER.split(",")[: 3 if kind == "places" else 7]
        values = np.cumsum(rng.normal(size=(rows, 3)), axis=0) * 5.0
        if kind == "attitudes":
            turned = rng.normal(size=(rows, 4))
            values = np.hstack([values, turned / np.linalg.norm(turned, axis=1, keepdims=True)])
        names[0] = str(rng.choice(["x_m", "x_mm", "x_cm", "x"]))
    else:
        quantities = (
            [("q", "_rad"), ("tau", "_Nm")] if kind == "static" else [("q", "_rad"), ("dq", "_rad_s"), ("tau", "_Nm")]
        )
        names = [f"{symbol}{k}{unit}" for symbol, unit in quantities for k in range(1, 8)]
        joints = _arm().q_min + rng.uniform(0.2, 0.8, (rows, 7)) * (_arm().q_max - _arm().q_min)
        values = np.hstack([joints, *(rng.normal(size=(rows, 7)) for _ in quantities[1:])])
    lines = [",".join(f"{x:.6g}" for x in row) for row in values]
    return "\n".join(([",".join(names)] if rng.uniform() < 0.7 else []) + lines).encode()
