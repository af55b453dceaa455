"""A session of registration without an operator: the simulated camera looks, and the simulated hand touches."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from palpate.base.arrays import Array
from palpate.base.errors import RegistrationError
from palpate.scene.registered import RegisteredOrgan
from palpate.simulators.room import Room
from palpate.world.registration import views
from palpate.world.registration.procedure import Procedure, nothing_felt

MOST_MISSES = 4
"""Places at which nothing is felt, after which the session gives up [-]."""

Told = Callable[[Procedure], None]


def unattended(scanned: RegisteredOrgan, room: Room, told: Told = lambda procedure: None) -> Procedure:
    """Register the organ of a simulated room until its targets are met.

    Args:
        scanned: the organ.
        room: the room; its truth is used by its camera and its hand alone.
        told: called after the first pose and after every touch.

    Raises:
        RegistrationError: the view is not of this organ, the touches disagree, or the accuracy cannot be reached.
    """
    camera, given = scanned.section.camera, scanned.section
    if camera is None:
        raise RegistrationError("the scene has no camera", mend="give registration.camera, or register attended")
    stated = room.rig.frames.pose(camera.frame)
    seen = views.seen(scanned.organ.points, room.look(scanned.index))
    first = views.placed(seen, stated.X, stated.covariance)
    procedure = Procedure(
        scanned.organ, first, given.accuracy, 1e-3 * given.touch_mm, 1e-3 * given.tip_mm, room.hand.radius,
        np.inf if given.motion is None else given.motion, seen if camera.looks_again else None,
    )  # fmt: skip
    told(procedure)
    misses = 0
    while not procedure.met:
        procedure.require_sound(given.touches)
        p_W, n_W = procedure.next_place(room.hand.reaches)
        X_WT = room.hand.touch(p_W, n_W)
        if X_WT is None:
            misses += 1
            procedure.skip(p_W)
            if misses == MOST_MISSES:
                raise nothing_felt(misses)
            continue
        procedure.add(X_WT)
        told(procedure)
    if procedure.view is not None:
        procedure.look_again(room.look(scanned.index, last=True))
    return procedure


def true_errors(scanned: RegisteredOrgan, room: Room, X_WO: Array) -> dict[str, float]:
    """Distance of each target, placed by X_WO (4, 4), from its true place [m]."""
    X = room.X_WA @ scanned.X_AO
    found = {}
    for name, p in scanned.organ.targets.items():
        found[name] = float(np.linalg.norm((X_WO - X) @ np.append(p, 1.0)))
    return found
