"""The tool's tip as the pointer: the simulated hand touches landmarks of the liver with the PSM."""

from __future__ import annotations

from typing import Any

import numpy as np
import yaml

from palpate.base.arrays import Array
from palpate.base.arrays.rigid import inverse, transform
from palpate.base.arrays.yaml_loader import OwnLoader
from palpate.scene import Scene, shipped
from palpate.scene.rig import Rig, build
from palpate.session.batch import Variation, simulate
from palpate.world.registration import points
from palpate.world.shapes.organs import organ
from palpate_lab.studies.registration.result import Touched

LANDMARKS, BELOW = 8, 0.05  # number; depth of the target below their mean [m]
_MIDDLE, _RADII, _HIGHEST = np.array([-0.035, -0.012]), (0.015, 0.032), 0.2  # of the ring of landmarks in W [m]
_VISIT = ((1.0, 0.02), (0.6, 0.0), (0.6, 0.0), (0.5, 0.02))  # duration of each step [s], height above the landmark [m]
_START, _RATE = 0.5, 100.0  # [s], [Hz]


def run(trials: int) -> Touched:
    """Registrations of the liver in the PSM's base from touches, each with other landmarks."""
    rig = build(Scene.load(shipped.file("palpation")))
    vertices, _ = organ(30_000)
    marks = [_landmarks(vertices, np.pi / 4.0 * k / trials) for k in range(trials)]
    radius = rig.scene.contact.radius
    seconds = _START + LANDMARKS * sum(step for step, _ in _VISIT)
    variations = [Variation(_touching(rig, one, radius), {}, seed=k) for k, one in enumerate(marks)]
    found = simulate(variations, duration=seconds, signals=["p_WT"], signal_rate=_RATE)
    rows = [_row(rig, one, tips, radius) for one, tips in zip(marks, found.signals["p_WT"], strict=True)]
    fre, predicted, error = np.array(rows).T
    return {
        "trials": trials,
        "fre_m": float(np.sqrt(np.square(fre).mean())),
        "predicted_m": float(np.sqrt(np.square(predicted).mean())),
        "simulated_m": float(np.sqrt(np.square(error).mean())),
        "largest_m": float(error.max()),
    }


def _landmarks(vertices: Array, first: float) -> Array:
    """Vertices (8, 3) near two rings on the upper side, the first at this angle [rad]."""
    angles = first + np.arange(LANDMARKS) * 2.0 * np.pi / LANDMARKS
    ring = _MIDDLE + np.resize(_RADII, LANDMARKS)[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return np.stack([
        vertices[np.argmin(np.linalg.norm(vertices[:, :2] - q, axis=1) - _HIGHEST * vertices[:, 2])] for q in ring
    ])  # fmt: skip


def _touching(rig: Rig, marks: Array, radius: float) -> Scene:
    """The scene with a hand that lowers the tip onto each landmark in turn, from above."""
    data: dict[str, Any] = yaml.load(rig.resolved_yaml(absolute=True), OwnLoader)
    up, t = np.array([0.0, 0.0, 1.0]), _START
    path = [{"t": 0.0, "xyz": (marks[0] + 0.03 * up).tolist()}]
    for p in marks:
        for step, height in _VISIT:
            t += step
            path.append({"t": t, "xyz": (p + (height + radius) * up).tolist()})
    data["operator"] = {key: data["operator"][key] for key in ("mass", "damping", "stiffness")} | {"path": path}
    data |= {"preset": None, "duration": t}
    return Scene.model_validate({key: value for key, value in data.items() if value is not None})


def _row(rig: Rig, marks: Array, p_WT: Array, radius: float) -> tuple[float, float, float]:
    """FRE, predicted and actual error at the target [m], from the tip's path p_WT (n, 3) at 100 Hz."""
    visit = sum(step for step, _ in _VISIT)
    rests = _START + np.arange(LANDMARKS) * visit + sum(step for step, _ in _VISIT[:3])
    X_BW = inverse(rig.arms.X_WB)
    p_BT = transform(X_BW, p_WT[np.round((rests - 0.05) * _RATE).astype(int)])
    seen = marks + radius * np.array([0.0, 0.0, 1.0])  # centre of the tip's sphere when it touches from above
    goal = marks.mean(axis=0) - [0.0, 0.0, BELOW]
    found = points(seen, p_BT, goal[None])
    error = transform(found.X, goal[None])[0] - transform(X_BW, goal[None])[0]
    return found.fre, float(found.tre[0]), float(np.linalg.norm(error))
