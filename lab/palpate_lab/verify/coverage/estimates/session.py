"""A liver registered by a simulated camera and touches of a simulated hand, judged at the targets of the scene."""

from __future__ import annotations

from functools import cache

import numpy as np

from palpate.base.arrays.rigid import displaced
from palpate.base.errors import RegistrationError
from palpate.scene import Scene, shipped
from palpate.scene.overrides import override
from palpate.scene.registered import RegisteredOrgan
from palpate.simulators.room import Room
from palpate.simulators.unattended import unattended
from palpate.world.registration.organ_motion import information
from palpate.world.registration.procedure import Procedure
from palpate.world.registration.touches import touched_by
from palpate_lab.verify.coverage.bound import most_powerful
from palpate_lab.verify.coverage.trial import RIGHT, Trial, of_ellipsoid

COMMAND = "register session"
FORMS = {
    RIGHT: "liver, camera of 1 mm, touches until 1 mm is met, a last view",
    "nudged": "the liver moves by 1 mm after three touches",
    "moved": "the liver moves by 5 mm after three touches",
    "tip": "the tip is calibrated 10 mm off",
    "alone": "without a last view, the liver moves by 1 mm after three touches",
    "asked": "`motion: 1.5 mm` without a last view; the liver moves by that after seven touches",
}
_MOVED = {"nudged": (1e-3, 3), "moved": (5e-3, 3), "alone": (1e-3, 3), "asked": (1.5e-3, 7)}  # [m], touches before it
_TIP = 10e-3  # m
_LEVEL = (
    0.02  # false alarms of the tests of a session with up to ten touches, at most: 0.001 after each, 0.01 at its end
)


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

    states: list[Procedure] = []

    def after(state: Procedure) -> None:
        states[:] = [state]
        by, touched = _MOVED.get(form, (0.0, 0))
        if by and len(state.X_WT) == touched:
            room.move(displaced(room.X_WA, np.r_[by * direction, np.zeros(3)]))
        if form in ("alone", "asked"):
            state.view = None

    try:
        found = unattended(scanned, room, after)
    except RegistrationError:
        if not states:
            raise
        return Trial(np.nan, np.nan, True, _possible(form, scanned, states[0]))
    moved = room.X_WA @ scanned.X_AO - found.found.X
    judged = [
        of_ellipsoid((moved @ np.append(p, 1.0))[:3], found.targets[name].covariance, False)
        for name, p in scanned.organ.targets.items()
    ]
    inside, square = (float(np.mean([getattr(one, key) for one in judged])) for key in ("inside", "square"))
    return Trial(inside, square, False, _possible(form, scanned, found))


def _possible(form: str, scanned: RegisteredOrgan, state: Procedure) -> float:
    """Share of such motions that the most powerful test of the touches would tell; NaN where a last view tells them."""
    by, touched = _MOVED.get(form, (0.0, 0))
    if form != "alone" or len(state.X_WT) <= touched:
        return float("nan")
    given = touched_by(state.X_WT, state.radius, state.sigma, state.tip)
    M = information(scanned.organ.surface, state.first, given, state.found, touched)
    return most_powerful(M, by, _LEVEL)
