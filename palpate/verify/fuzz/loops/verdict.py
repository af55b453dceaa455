"""The verdict on a loop: neither direction may hand out energy, once the error of sampling is told apart."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate import _core
from palpate.arrays import Array
from palpate.verify.fuzz.loops import files
from palpate.verify.fuzz.loops.device import Device
from palpate.verify.fuzz.loops.kinds import Loop
from palpate.verify.fuzz.loops.port import work_at_rest, work_held
from palpate.verify.fuzz.loops.ways import Way

SHARE = 2e-3
"""Energy that a loop may return, relative to the largest energy stored on its way [-]."""
LEAST = 3e-7
"""Energy that a loop may return in any case [J]."""
STEP, CORNERS = 1.5e-4, 20
"""Distance of the samples of a way [m], and least number of samples on an edge; halved until the work is known."""
HALVINGS = 4
"""Largest number of halvings."""
_SURE = 0.02  # relative change at a halving, below which the work is known
_REST = 300  # ticks at the start of a felt loop, and between two cycles of a toggled one
_LENT = 0.03  # energy that a fixture which holds the tool at the start may lend [J]
DWELL = 2
"""Ticks at each place: contacts follow the motion of the tool by one tick."""


@dataclass(frozen=True)
class Verdict:
    """What a loop returned."""

    work: float  #: work of the hand over the loop; felt: the least work up to any tick [J]
    stored: float  #: largest energy that the hand had put in on the way [J]
    bound: float  #: least work that is allowed [J]
    backwards: bool = False  #: the direction in which the work is the least
    error: float = 0.0  #: change of the work at the last halving of the steps [J]
    resolved: bool = True  #: False: halving the steps still changed the work

    @property
    def fails(self) -> bool:
        """True if the loop hands out energy."""
        return self.work < self.bound

    @property
    def excess(self) -> float:
        """Energy handed out relative to the stored energy [-]."""
        return (self.bound - self.work) / max(self.stored, LEAST)

    def words(self) -> str:
        """The verdict in words."""
        way = "backwards" if self.backwards else "forwards"
        known = f"+- {1e6 * self.error:.3g} uJ" if self.resolved else f"still changing by {1e6 * self.error:.3g} uJ"
        return (f"{1e6 * self.work:.4g} uJ put in by the hand {way} ({known}), at least {1e6 * self.bound:.3g} uJ "
                f"allowed, {1e6 * self.stored:.4g} uJ stored")  # fmt: skip


def judge(loop: Loop, device: Device | None = None) -> Verdict:
    """Run a loop and judge it.

    Raises:
        PalpateError: the scene cannot run.
    """
    device = device or Device(loop.scene, files.folder())
    return _still(loop, device) if loop.run == "still" else _felt(loop, device)


def _still(loop: Loop, device: Device) -> Verdict:
    """Both directions at rest at every place, with steps halved until the work is known or allowed."""
    found: list[tuple[float, float]] = []  # work and stored energy, of each halving, of the worse direction
    worst, bound, limit = 0, 0.0, 0.0
    for halving in range(HALVINGS + 1):
        step, least = STEP * 0.5**halving, CORNERS * 2**halving
        runs = [_at_rest(way, loop.cycles, device, step, least) for way in (loop.way, loop.way.backwards())]
        if halving == 0:
            bound = -(SHARE * max(stored for _, stored in runs) + LEAST)
            worst = int(np.argmin([work for work, _ in runs]))
        found.append(runs[worst])
        limit = _limit([work for work, _ in found])
        if min(work for work, _ in runs) >= bound or (halving > 1 and limit >= bound):
            break
        if halving > 0 and abs(found[-1][0] - found[-2][0]) < _SURE * abs(found[-1][0]):
            break
    work, stored = found[-1]
    error = abs(limit - work) if len(found) > 1 else 0.0
    return Verdict(max(work, limit), stored, bound, worst == 1, error, error < 0.3 * abs(limit) or limit >= bound)


def _limit(work: list[float]) -> float:
    """The limit of works whose steps were halved each time: by Aitken's formula if their changes fall, or the last."""
    if len(work) < 3:
        return work[-1]
    before, last = work[-2] - work[-3], work[-1] - work[-2]
    return work[-1] + last * last / (before - last) if abs(last) < 0.8 * abs(before) else work[-1]


def _at_rest(way: Way, cycles: int, device: Device, step: float, least: int) -> tuple[float, float]:
    p, theta = way.samples(step, least)
    X = np.repeat(device.handle(p, theta), DWELL, axis=0)
    if cycles > 1:
        X = np.concatenate([X, *[X[DWELL:]] * (cycles - 1)])
    F = device.wrenches(X)
    done = work_at_rest(F[DWELL - 1 :: DWELL], X[DWELL - 1 :: DWELL])
    return float(done[-1]), float(done.max() - done.min())


def _felt(loop: Loop, device: Device) -> Verdict:
    """The least work up to any tick, with the layer on."""
    p, theta = loop.way.timed(loop.speed, 4.0, device.period)
    X = device.handle(p, theta)
    rng = np.random.default_rng(len(p))
    rest = np.repeat(X[:1], _REST, axis=0)
    if loop.toggle:
        F, X = _toggled(loop, device, X, rest)
    else:
        X = np.concatenate([rest, *[X[1:]] * loop.cycles])
        X, t = _clocked(loop.clock, X, device.period, rng)
        F = device.wrenches(X, t)
    pulled = device.scene.guidance and np.abs(F[: _REST // 2]).max() > 0.0  # a fixture holds the tool where it starts
    lent = max(loop.credit, _LENT if pulled else 0.0)
    done = work_held(F, X, loop.axes)
    bound = -(device.scene.stability.allowance + lent) * (1 + 1e-6)
    return Verdict(float(done.min()), float(done.max() - done.min()), bound)


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
