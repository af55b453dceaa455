"""MuJoCo's flex on the same mesh as a soft body of Palpate: error of the force, and time of a tick, of both."""

from __future__ import annotations

from typing import TypedDict

import numpy as np

from palpate.world.tissue import indentation
from palpate_lab.verify.bench.tissue.bodies import POISSON, YOUNG, Lab, pressed
from palpate_lab.verify.bench.tissue.rows import Found
from palpate_lab.verify.bench.tissue.ticks import Times, times_of

LAYER = (10e-3, 5e-3, 25e-3)  # thickness, cell, half width [m]; MuJoCo does not solve finer layers
RADIUS, DEPTH = 5e-3, 1.25e-3  # [m]


class MuJoCo(TypedDict):
    """MuJoCo's flex, and Palpate on the same mesh."""

    tets: int
    tick_ms: Times
    layer_error: float  #: largest of two places, on a node and in the middle of a face, relative [-]
    own_tick_ms: Times  #: Palpate
    own_layer_error: float  #: Palpate


def measure(lab: Lab, short: bool = False) -> Found:
    """Both on a coarse layer; null where MuJoCo is not installed."""
    soft = lab.layer(*LAYER)
    fixed = soft.nodes[:, 2] < -LAYER[0] + 1e-9
    try:
        from palpate_lab.verify.bench.tissue import mujoco_layer as other

        built = other.model(soft, fixed, YOUNG, POISSON, RADIUS, np.array([0.0, 0.0, RADIUS + 1e-3]))
    except ImportError:
        return Found((), {"mujoco": None})
    expected = float(indentation.layer(RADIUS, DEPTH, YOUNG, POISSON, LAYER[0]))
    places = ((0.0, 0.0), (0.5 * LAYER[1], 0.25 * LAYER[1]))[: 1 if short else 2]
    found = [other.press(built, RADIUS, DEPTH, at) for at in places]
    own = [lab.touch(soft, pressed(RADIUS, DEPTH, at), radius=RADIUS) for at in places]
    figures: MuJoCo = {
        "tets": len(soft.tets),
        "tick_ms": times_of(np.concatenate([spent for _, spent in found])),
        "layer_error": max((force / expected - 1.0 for force, _ in found), key=abs),
        "own_tick_ms": times_of(np.concatenate([one.latency for one in own])),
        "own_layer_error": max((float(one.force[-20:, 2].mean()) / expected - 1.0 for one in own), key=abs),
    }
    return Found((), {"mujoco": figures})
