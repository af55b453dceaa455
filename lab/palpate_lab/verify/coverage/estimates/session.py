"""A liver registered by a simulated camera and touches of a simulated hand, judged at the targets of the scene."""

from __future__ import annotations

from functools import cache

import numpy as np

from palpate.base.arrays.rigid import displaced
from palpate.scene import Scene, shipped
from palpate.scene.overrides import override
from palpate.scene.registered import RegisteredOrgan
from palpate.simulators.room import Room
from palpate.simulators.unattended import unattended
from palpate.world.registration.procedure import Procedure
from palpate_lab.verify.coverage.trial import RIGHT, Trial, of_ellipsoid

COMMAND = "register session"
FORMS = {
    RIGHT: "liver, camera of 1 mm, touches until 1 mm is met",
    "nudged": "the liver moves by 1 mm after three touches",
    "moved": "the liver moves by 5 mm after three touches",
    "tip": "the tip is calibrated 10 mm off",
    "asked": "`motion: 1.5 mm`; the liver moves by that after seven touches",
}
_MOVED = {"nudged": (1e-3, 3), "moved": (5e-3, 3), "asked": (1.5e-3, 7)}  # by [m], after so many touches
_TIP = 10e-3  # m


@cache
def _scene(form: str) -> Scene:
    scene = Scene.load(shipped.file("registration"))
    return override(scene, {"registration.motion": 1.5e-3}) if form == "asked" else scene


def trial(form: str, rng: np.random.Generator) -> Trial:
    """One session; the mean over its targets."""
    direction = rng.normal(size=3)
    direction /= np.linalg.norm(direction)
    scanned = RegisteredOrgan(_scene(form))
    room = Room(_scene(form), int(rng.integers(2**31)), _TIP * direction if form == "tip" else None)

    def after(state: Procedure) -> None:
        by, touched = _MOVED.get(form, (0.0, 0))
        if by and len(state.X_WT) == touched:
            room.move(displaced(room.X_WA, np.r_[by * direction, np.zeros(3)]))

    found = unattended(scanned, room, after)
    moved = room.X_WA @ scanned.X_AO - found.found.X
    judged = [
        of_ellipsoid((moved @ np.append(p, 1.0))[:3], found.targets[name].covariance, False)
        for name, p in scanned.organ.targets.items()
    ]
    return Trial(float(np.mean([one.inside for one in judged])), float(np.mean([one.square for one in judged])), False)
