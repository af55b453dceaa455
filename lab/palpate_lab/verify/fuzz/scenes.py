"""Random scenes of several moving objects and fixtures, also damaged, run with live edits.

A scene is refused with words, or it runs with a force within its caps; nothing else is allowed. Controls and fixtures
change to random values, NaN included, between the ticks.
"""

from __future__ import annotations

import math
import warnings

import numpy as np
import yaml

from palpate.base.arrays.plain import Content
from palpate.base.errors import PalpateError
from palpate.record.ticks import STATUS
from palpate.scene import Scene
from palpate.session import Session
from palpate_lab.verify.fuzz import FaultError
from palpate_lab.verify.fuzz.damage import damaged

TICKS, EDITS = 40, 6
BALL = [-0.035, -0.012, 0.02]
LINES = ("margin: 3 mm around: ball", "stay-in: cone(entry, target, 30 deg)", "keep-rcm", "follow: line(entry, target)")
"""One-line forms of fixtures."""
_AT_LIMIT = STATUS["torque_limited"][0]  # a motor at its limit may turn the force faster than the rate cap


def case(seed: int) -> dict[str, int]:
    """Read a scene and run it with live edits.

    Raises:
        FaultError: the wrench on the hand is not finite, exceeds its cap, or grows or turns faster than its rate cap.
    """
    rng = np.random.default_rng(seed)
    text = yaml.safe_dump(_scene(rng), sort_keys=False).encode()
    sound = bool(rng.uniform() < 0.5)
    source = (text if sound else damaged(rng, text)).decode(errors="replace")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            session = Session(Scene.parse(source, "fuzz.yaml"), seed=0)
        except PalpateError:
            return {"refused": 1}
        edits, pushed = _run(session, rng)
    return {"ran": 1, "sound" if sound else "damaged": 1, "edits": edits, "pushed": int(pushed)}


def _run(session: Session, rng: np.random.Generator) -> tuple[int, bool]:
    """Run with edits between the ticks; the number of edits that were taken, and whether a force was commanded."""
    caps, edits, pushed = session.scene.stability, 0, False
    rate = session.scene.rates.haptic
    with session:
        before, limited = np.zeros(3), False
        for _ in range(EDITS):
            for _ in range(TICKS):
                session.step()
                tick = session.latest()
                F, was_limited, limited = tick["F_H_L"].copy(), limited, bool(int(tick["status"]) & _AT_LIMIT)
                if not np.isfinite(F).all() or not np.isfinite(tick["tau"]).all():
                    raise FaultError(f"at {tick['t']:g} s a force of {F} N is commanded, torques of {tick['tau']} N m")
                if np.linalg.norm(F) > caps.force_cap * (1.0 + 1e-9):
                    raise FaultError(f"{np.linalg.norm(F):g} N is above the cap of {caps.force_cap:g} N")
                # A fall is free where the hand's motion explains it, and where the energy of a force is spent.
                fallen = before * min(1.0, float(np.linalg.norm(F)) / max(float(np.linalg.norm(before)), 1e-30))
                step = float(np.linalg.norm(F - fallen))
                if step > caps.rate_cap / rate * (1.0 + 1e-9) and not (limited or was_limited):
                    raise FaultError(
                        f"the force grew or turned by {step:g} N in a tick, {caps.rate_cap / rate:g} N are allowed"
                    )
                before, pushed = F, pushed or bool(F.any())
            edits += _edit(session, rng)
    return edits, pushed


def _edit(session: Session, rng: np.random.Generator) -> int:
    """Change controls or a fixture; 1 if the change was taken, 0 if it was refused with a ValueError."""
    names = session.steered.names
    try:
        if names and rng.uniform() < 0.5:
            X = np.eye(4)
            X[:3, 3] = _length(rng) * rng.normal(size=3)
            change = {"enabled": bool(rng.integers(2)), "authority": float(rng.uniform(-0.2, 1.2)), "X_W": X}
            key = str(rng.choice(list(change)))
            session.steered.change(str(rng.choice(names)), **{key: change[key]})  # type: ignore[arg-type]
        else:
            controls = session.controls
            key = str(rng.choice(["stiffness_scale", "damping_scale", "guidance", "clutch", "following", "hold"]))
            setattr(controls, key, bool(rng.integers(2)) if key in ("clutch", "following", "hold") else _factor(rng))
            controls.p_hand_offset_W = _length(rng) * rng.normal(size=3)
            session.controls = controls
    except ValueError:
        return 0
    return 1


def _length(rng: np.random.Generator) -> float:
    """A displacement [m]: millimetres as a rule, sometimes absurd or not a number."""
    return float(rng.choice([1e-3, 1e-2, 0.1, 1e6, math.nan], p=[0.5, 0.3, 0.1, 0.05, 0.05]))


def _factor(rng: np.random.Generator) -> float:
    return float(rng.choice([0.0, rng.uniform(0, 2), 10.0, -1.0, 1e9, math.inf, math.nan]))


KINDS: Content = {
    "sphere": {"radius": 0.01},
    "box": {"size": [0.02, 0.01, 0.03]},
    "plane": {},
    "cylinder": {"radius": 0.01, "length": 0.03},
    "capsule": {"radius": 0.006, "length": 0.05},
    "implicit": {"half": [0.02, 0.015, 0.01]},
}


def _scene(rng: np.random.Generator) -> Content:
    """One to five objects of any kind around the palpated ball, half of them moving, with up to three fixtures."""
    objects: list[Content] = [{"name": "ball", "sphere": {"radius": 0.02}, "pose": {"xyz": BALL}, "stiffness": 400}]
    objects += [_object(rng, k) for k in range(int(rng.integers(0, 5)))]
    for one in objects:
        if rng.uniform() < 0.5:
            swing = {
                "amplitude": rng.normal(scale=3e-3, size=3).round(5).tolist(),
                "period": float(rng.choice([0.2, 4])),
            }
            drift = {"velocity": rng.normal(scale=0.05, size=3).round(3).tolist(), "spin_deg": [0, 0, 90]}
            one["motion"] = [swing, drift]
    return {
        "objects": objects,
        "guidance": [str(line) for line in rng.choice(LINES, int(rng.integers(0, 4)), replace=False)],
        "operator": {"palpate": {"object": "ball", "force": 1.2, "length": 0.02}},
        "places": {"entry": [-0.035, -0.012, 0.15], "target": [-0.035, -0.012, 0.0]},
    }


def _object(rng: np.random.Generator, k: int) -> Content:
    kind = str(rng.choice(list(KINDS)))
    place = BALL + rng.normal(scale=0.02, size=3)
    place[2] -= 0.04 if kind == "plane" else 0.01
    return {
        "name": f"object{k}",
        kind: KINDS[kind],
        "pose": {"xyz": place.round(4).tolist(), "rpy_deg": rng.uniform(-180, 180, 3).round(1).tolist()},
        "stiffness": round(rng.uniform(0, 2000), 1),
        "damping": round(rng.uniform(0, 10), 2),
        "friction": round(rng.uniform(0, 1), 2),
    }
