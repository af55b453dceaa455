"""The verdict on a loop: neither direction may hand out energy, once the error of sampling is told apart."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from palpate_lab.verify.fuzz.loops import felt, files, slow
from palpate_lab.verify.fuzz.loops.device import Device
from palpate_lab.verify.fuzz.loops.kinds import Loop
from palpate_lab.verify.fuzz.loops.ways import Way

SHARE = 2e-3
"""Energy that a slow loop may return, relative to the largest energy stored on its way [-]."""
LEAST = 3e-7
"""Energy that a slow loop may return in any case [J]."""
HALVINGS = 4
"""Largest number of halvings of the steps."""
_CYCLES = (4, 16, 64, 256)  # in which a loop that returns energy may spend what lay ready at its start
_FINE = 2  # halvings of the steps in these cycles
_FOUND = 1.02  # energy that lay ready, relative to what a hand that follows the force in steps gets
_SURE = 0.02  # relative change at a halving, below which the work is known
_SHARE_OF_TISSUE = 1e-2  # in place of SHARE: a soft body is never at rest

Work = tuple[float, float]
"""Work of the hand, and the largest energy that it had put in [J]."""


@dataclass(frozen=True)
class Verdict:
    """What a loop returned."""

    work: float  #: work of the hand over the loop; felt: the least work up to any tick [J]
    stored: float  #: largest energy that the hand had put in on the way [J]
    bound: float  #: least work that is allowed [J]
    backwards: bool = False  #: the direction in which the work is the least
    error: float = 0.0  #: distance of the work from its limit for small steps [J]
    resolved: bool = True  #: False: halving the steps still changed the work
    later: float | None = None  #: of a slow loop that returns energy: work in the last of its cycles [J]
    ready: float = 0.0  #: energy that lay ready at its start [J]
    cycles: int = 1  #: cycles over which it was run to spend that
    spent: float = 0.0  #: work of the hand over these cycles [J]

    @property
    def fails(self) -> bool:
        """True if the loop hands out energy: in its last cycle too, or in all cycles more than what lay ready."""
        over = self.spent < self.cycles * self.bound - _FOUND * self.ready
        return self.returns and (self.later is None or self.later < self.bound or over)

    @property
    def returns(self) -> bool:
        """True if a cycle hands out energy, whether or not it lay ready at the start."""
        return self.work < self.bound

    @property
    def recurs(self) -> bool:
        """True if the last cycle hands out energy as well."""
        return self.fails and (self.later is None or self.later < self.bound)

    @property
    def excess(self) -> float:
        """Energy handed out relative to the stored energy [-]."""
        return (self.bound - self.work) / max(self.stored, LEAST)

    def words(self) -> str:
        """The verdict in words."""
        way = "backwards" if self.backwards else "forwards"
        change = f"{1e6 * self.error:.3g} uJ"
        known = f"{change} from its limit for small steps" if self.resolved else f"still changing by {change}"
        again = ""
        if self.later is not None:
            again = (
                f", {1e6 * self.later:.4g} uJ in the last and {1e6 * self.spent:.4g} uJ in all {self.cycles} cycles, "
                f"{1e6 * self.ready:.4g} uJ ready at the start"
            )
        return (
            f"{1e6 * self.work:.4g} uJ put in by the hand {way} ({known}){again}, at least {1e6 * self.bound:.3g} uJ "
            f"allowed, {1e6 * self.stored:.4g} uJ stored"
        )


def judge(loop: Loop, device: Device | None = None) -> Verdict:
    """Run a loop and judge it.

    Args:
        loop: the loop.
        device: a device with its scene; made when left out.

    Raises:
        PalpateError: the scene cannot run.
    """
    if loop.run == "session":
        return Verdict(*felt.in_session(loop.scene))
    device = device or Device(loop.scene, files.folder())
    if loop.run == "still":
        found = _both_ways(loop, lambda way, k: slow.at_rest(way, loop.cycles, device, k))
        return _in_later_cycles(loop, device, found) if found.returns else found
    if loop.run == "moving":
        return _both_ways(loop, lambda way, k: slow.on_moving_object(way, loop.scene, k))
    if loop.run == "soft":
        return _both_ways(loop, lambda way, k: slow.on_tissue(way, device, loop.speed * 0.5**k), 2, _SHARE_OF_TISSUE)
    return Verdict(*felt.by_hand(loop, device))


def _in_later_cycles(loop: Loop, device: Device, found: Verdict) -> Verdict:
    """The verdict after as many cycles as it takes until one returns nothing, or all more than what lay ready."""
    way = loop.way.backwards() if found.backwards else loop.way
    ready = slow.ready(way, device)
    for cycles in _CYCLES:
        works = slow.by_cycle(way, cycles, device, _FINE)
        later, spent = float(works[-1]), float(works.sum())
        if later >= found.bound or spent < 2 * cycles * found.bound - 2 * ready:
            break
    return replace(found, later=later, ready=ready, cycles=cycles, spent=spent)


def _both_ways(loop: Loop, run: Callable[[Way, int], Work], halvings: int = HALVINGS, share: float = SHARE) -> Verdict:
    """Both directions, with steps halved until the work is known or allowed; run(way, number of halvings)."""
    found: list[Work] = []  # of the worse direction, at each halving
    worst, bound, limit = 0, 0.0, 0.0
    for halving in range(halvings + 1):
        runs = [run(way, halving) for way in (loop.way, loop.way.backwards())]
        if halving == 0:
            bound = -(share * max(stored for _, stored in runs) + LEAST)
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
