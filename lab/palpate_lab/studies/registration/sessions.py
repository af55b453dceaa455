"""Unattended sessions of the study: what they predict against the truth, and whether wrong set-ups are told."""

from __future__ import annotations

import numpy as np

from palpate.base.arrays import Array
from palpate.base.arrays.rigid import displaced
from palpate.base.errors import RegistrationError
from palpate.base.sweep.grid import Point
from palpate.scene import Scene, shipped
from palpate.scene.overrides import override
from palpate.scene.registered import RegisteredOrgan
from palpate.simulators.room import Room
from palpate.simulators.unattended import true_errors, unattended
from palpate.world.registration.procedure import Procedure
from palpate.world.registration.touch_check import check, spread
from palpate.world.registration.touches import Guess, touched_by

KINDS = ("right", "moved", "tip", "mirrored", "another")
"""As stated; the organ moves after three touches; the tip is calibrated wrongly; mirrored targets; another scan."""
MOVED, TIP, OFF, PLACES = 5e-3, 10e-3, 3e-3, 8  # displacements [m], places of the touch check
_BEFORE = 3  # touches before the organ moves


def judged(point: Point, seed: int) -> dict[str, float]:
    """One session: whether it was told as wrong, and otherwise its true and predicted errors; with two touch checks."""
    rng, kind = np.random.default_rng(seed), KINDS[point["kind"]]
    scene = _scene(kind)
    tip = _somewhere(rng, TIP) if kind == "tip" else None
    try:
        scanned = RegisteredOrgan(_scene("right") if kind in ("right", "moved", "tip") else scene)
        room = Room(_scene("right"), int(rng.integers(2**31)), tip)

        def told(state: Procedure) -> None:
            if kind == "moved" and len(state.X_WT) == _BEFORE:
                room.move(displaced(room.X_WA, np.append(_somewhere(rng, MOVED), np.zeros(3))))

        found = unattended(scanned, room, told)
    except RegistrationError:
        return dict.fromkeys(_KEYS, np.nan) | {"told": 1.0}
    errors, bounds = true_errors(scanned, room, found.found.X), found.bounds
    worst = max(errors, key=lambda name: errors[name])
    return {
        "told": 0.0, "right": float(all(errors[name] <= bounds[name] for name in errors)), "error_m": errors[worst],
        "predicted_m": found.targets[worst].tre, "bound_m": bounds[worst], "touches": float(len(found.X_WT)),
        "seconds": room.hand.seconds, **_checked(scanned, room, found, _somewhere(rng, OFF), kind),
    }  # fmt: skip


_KEYS = ("right", "error_m", "predicted_m", "bound_m", "touches", "seconds", "passed", "off_failed")


def _scene(kind: str) -> Scene:
    scene = Scene.load(shipped.file("registration"))
    if kind == "mirrored":
        flipped = {name: [-x, y, z] for name, (x, y, z) in scene.registration.targets.items()}  # type: ignore[union-attr]
        return override(scene, {"registration.targets": flipped})
    if kind == "another":
        inside = {"target": [0.0, 0.0, 0.0]}
        return override(scene, {"objects.0.shape": "gallbladder", "registration.targets": inside})
    return scene


def _somewhere(rng: np.random.Generator, size: float) -> Array:
    v = rng.normal(size=3)
    return np.asarray(size * v / np.linalg.norm(v))


def _checked(scanned: RegisteredOrgan, room: Room, found: Procedure, off: Array, kind: str) -> dict[str, float]:
    """Whether the touch check passes the registration, and fails one that is 3 mm off."""
    if kind != "right":
        return {"passed": np.nan, "off_failed": np.nan}
    wrong = Guess(displaced(found.found.X, np.append(off, np.zeros(3))), found.found.covariance)
    results = []
    for registered in (found.found, wrong):
        places = spread(scanned.organ, registered.X, PLACES, room.hand.reaches)
        X_WT = [X for X in (room.hand.touch(p, n) for p, n in places) if X is not None]
        touched = touched_by(X_WT, room.hand.radius, found.sigma, found.tip)
        results.append(check(scanned.organ, registered, touched, found.accuracy).passed)
    return {"passed": float(results[0]), "off_failed": float(not results[1])}
