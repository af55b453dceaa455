"""Loops with the passivity layer on: the least work of the hand up to any moment, and the least that is allowed."""

from __future__ import annotations

import warnings

import numpy as np

from palpate import _core
from palpate.base.arrays import Array
from palpate.base.arrays.plain import Content
from palpate.record.ticks import as_ticks
from palpate.scene.rig import build
from palpate_lab.verify.fuzz.loops import files
from palpate_lab.verify.fuzz.loops.device import Device, scene_of
from palpate_lab.verify.fuzz.loops.kinds import Loop
from palpate_lab.verify.fuzz.loops.port import work_held

_REST = 300  # ticks at the start of a loop, and between two cycles of a toggled one
_LENT = 0.03  # energy [J] that fixtures may lend: that hold the tool at the start, or whose pull begins at a range
_LATE = 3  # periods by which a device delays the force without a word
_ROUNDING = 1 + 1e-6
_DURATION = 4.0  # of a session [s]
_CELL = 0.02  # share of the stored energy by which the load cell, read once a tick, may be wrong [-]


def by_hand(loop: Loop, device: Device) -> tuple[float, float, float]:
    """The least work up to any tick of a device's loop, the largest energy stored, and the least work allowed [J]."""
    p, theta = loop.way.timed(loop.speed, 4.0, device.period, device.scene.mapping.scale)
    X = device.handle(p, theta)
    rest = np.repeat(X[:1], _REST, axis=0)
    if loop.toggle:
        F, X = _toggled(loop, device, X, rest)
    else:
        X = np.concatenate([rest, *[X[1:]] * loop.cycles])
        X, t = _clocked(loop.clock, X, device.period, np.random.default_rng(len(p)))
        F = device.wrenches(X, t)
    if loop.clock == "delayed":
        F = np.concatenate([np.zeros((_LATE, 6)), F[:-_LATE]])
    pulled = device.scene.guidance and np.abs(F[: _REST // 2]).max() > 0.0
    pulls_later = any(one.law.name == "potential" and one.role.name == "guide" for one in device.scene.guidance)
    lent = max(loop.credit, _LENT if pulled or pulls_later else 0.0)
    done = work_held(F, X, loop.axes)
    bound = -(device.scene.stability.allowance + lent) * _ROUNDING
    return float(done.min()), float(done.max() - done.min()), bound


def in_session(scene: Content) -> tuple[float, float, float]:
    """The same of a simulated arm with its control law, at the load cell in the handle [J]."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        rig = build(scene_of(scene, files.folder()))
    ticks = as_ticks(rig.simulation().run(int(_DURATION * rig.scene.rates.haptic)))
    F, p = ticks["F_cell_L"], ticks["p_LH"]
    done = np.append(0.0, -np.cumsum((0.5 * (F[1:] + F[:-1]) * np.diff(p, axis=0)).sum(axis=1)))
    stored = float(done.max() - done.min())
    return float(done.min()), stored, -(rig.scene.stability.allowance + _CELL * stored)


def _clocked(clock: str, X: Array, period: float, rng: np.random.Generator) -> tuple[Array, Array]:
    """The poses and times of a loop whose calls differ from its rate."""
    n, every = len(X), 1
    late = np.zeros(n)
    if clock in ("slow", "wrong"):  # half as often as the rate says, by a right clock, or by one that is half as fast
        every = 2
    elif clock == "late":  # at uneven times
        late = period * rng.uniform(0, 0.9, n)
    keep = np.arange(0, n, every)
    if clock == "lost":
        keep = np.flatnonzero(rng.uniform(size=n) > 0.3)
    t = period * keep.astype(np.float64) + late[keep]
    return X[keep], np.asarray(t / 2 if clock == "wrong" else t)


def _toggled(loop: Loop, device: Device, X: Array, rest: Array) -> tuple[Array, Array]:
    """Cycles between which a pedal, a list of fixtures or the clutch changes."""
    cycle, half = device.cycle(), len(X) // 2
    found, poses, t = [], [], 0.0
    for k in range(loop.cycles):
        for part, on in ((rest, False), (X[1:half], k % 2 == 1), (X[half:], k % 2 == 0)):
            _switch(loop.toggle, cycle, device, on)
            F = np.zeros((len(part), 6))
            times = np.asarray(t + device.period * np.arange(1, len(part) + 1), dtype=np.float64)
            t = float(times[-1])
            cycle.replay(times, np.ascontiguousarray(part), F)
            found.append(F)
            poses.append(part)
    return np.concatenate(found), np.concatenate(poses)


def _switch(what: str, cycle: _core.DeviceCycle, device: Device, on: bool) -> None:
    controls = cycle.controls
    if what == "clutch":
        controls.clutch = on
    elif what == "pedal":
        controls.guidance = 1.0 if on else 0.0
    else:
        cycle.set_fixtures(device.fixtures if on else device.no_fixtures)
    cycle.controls = controls
