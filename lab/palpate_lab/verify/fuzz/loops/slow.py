"""Slow loops without the passivity layer: work of the hand along a way, at steps that may be halved."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np

from palpate.base.arrays import Array
from palpate.base.arrays.plain import Content
from palpate_lab.verify.fuzz.loops import files
from palpate_lab.verify.fuzz.loops.device import Device
from palpate_lab.verify.fuzz.loops.port import rotations, work_at_rest
from palpate_lab.verify.fuzz.loops.ways import Way

STEP, CORNERS = 1.5e-4, 20
"""Distance of the samples of a way [m], and least number of samples on an edge, before any halving."""
_LONGEST, _PATIENCE = 8000, 100
"""Steps of a hand that follows the force: in all, and without getting more."""
DWELL, SETTLED = 2, 20
"""Ticks at each place: contacts follow the motion of the tool by one tick, and forces and goals that have jumped by the
limits of their rates."""


def at_rest(way: Way, cycles: int, device: Device, halvings: int) -> tuple[float, float]:
    """Work at rest at every place, and the largest energy put in before [J]."""
    return _ends(_done(way, cycles, device, halvings, DWELL))


def by_cycle(way: Way, cycles: int, device: Device, halvings: int) -> Array:
    """Work (cycles,) in each cycle, at rest until the force has settled at every place [J]."""
    done = _done(way, cycles, device, halvings, SETTLED)
    return np.diff(done[:: (len(done) - 1) // cycles])


def _done(way: Way, cycles: int, device: Device, halvings: int, ticks: int) -> Array:
    """Work up to each place, after as many ticks there [J]."""
    p, theta = way.samples(STEP * 0.5**halvings, CORNERS * 2**halvings)
    X = np.repeat(device.handle(p, theta), ticks, axis=0)
    if cycles > 1:
        X = np.concatenate([X, *[X[ticks:]] * (cycles - 1)])
    F = device.wrenches(X)
    return work_at_rest(F[ticks - 1 :: ticks], X[ticks - 1 :: ticks])


def ready(way: Way, device: Device) -> float:
    """Energy that lies ready at the start of a way: what hands get that follow the force from there [J].

    One hand follows the force of the whole scene, others that of one fixture each: their sum counts if it is larger,
    since the first one may end where two fixtures balance each other.
    """
    return max(_got(way, device), sum(_got(way, one) for one in device.alone()))


def _got(way: Way, device: Device) -> float:
    """Energy of a hand that follows the force from the start of a way [J]."""
    X = device.handle(way.p[:1], way.theta[:1])[0]
    wrench = device.at_rest()
    got, most, since = 0.0, 0.0, 0
    F = wrench(X)[:3]
    for _ in range(_LONGEST):
        size = float(np.linalg.norm(F))
        if not size > 0.0 or since > _PATIENCE:
            break
        moved = STEP / 4 * F / size
        X = X.copy()
        X[:3, 3] += moved
        F, before = wrench(X)[:3], F
        got += float(0.5 * (F + before) @ moved)
        most, since = max(most, got), 0 if got > most else since + 1
    return most


def on_tissue(way: Way, device: Device, speed: float) -> tuple[float, float]:
    """Work on a soft body at a slow speed [m/s], and the largest energy put in before [J]."""
    p, theta = way.timed(speed, 1.0, device.period)
    X = device.handle(p, theta)
    X = np.concatenate([X, X[-1:]])
    return _ends(work_at_rest(device.wrenches(X)[1:], X[:-1]))  # the tool follows by one tick


def on_moving_object(way: Way, scene: Content, halvings: int) -> tuple[float, float]:
    """Work on one object that moves, relative to it: the hand's and that of whatever moves the object [J].

    The periods of its motion in the scene are in units of the duration of the way, and its velocities in units of one
    over that duration. The contact of a tick belongs to the tool of the tick before and the object of this tick.
    """
    p, _ = way.samples(STEP * 0.5**halvings, CORNERS * 2**halvings)
    one = copy.deepcopy(scene)
    motion, duration = one["objects"][0]["motion"], len(p) / scene["rates"]["haptic"]
    motion["period"] *= duration
    for key in ("velocity", "spin_deg"):
        motion[key] = [value / duration for value in motion[key]]
    device = Device(one, files.folder())
    t = np.asarray(device.period * np.arange(len(p)), dtype=np.float64)
    R, shift = _motion(motion, t)
    about = np.array(one["objects"][0]["pose"]["xyz"])
    p_tool = np.einsum("nij,nj->ni", R, p - about) + about + shift
    X = device.handle(p_tool, np.zeros_like(p))
    F_W = device.force_in_world(device.wrenches(X, t))
    late = np.concatenate([p_tool[:1], p_tool[:-1]])
    q = np.einsum("nji,nj->ni", R, late - about - shift)
    F_O = np.einsum("nji,nj->ni", R, F_W)
    return _ends(np.append(0.0, -np.cumsum((0.5 * (F_O[1:] + F_O[:-1]) * np.diff(q, axis=0)).sum(axis=1))))


def _motion(motion: Any, t: Array) -> tuple[Array, Array]:
    """Rotation (n, 3, 3) about the centre and translation (n, 3) [m] of an object's motion at times (n,) [s]."""
    wave = np.sin(2 * np.pi * t / motion["period"] + np.radians(motion["phase_deg"]))[:, None]
    theta = np.radians(wave * motion["turn_deg"] + t[:, None] * motion["spin_deg"])
    return rotations(theta), wave * motion["amplitude"] + t[:, None] * motion["velocity"]


def _ends(done: Array) -> tuple[float, float]:
    return float(done[-1]), float(done.max() - done.min())
