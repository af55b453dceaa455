"""Random closed loops of the hand in random scenes: no stage may hand out energy.

A case is a scene with a few loops. Without the passivity layer, a slow loop in either direction returns no more energy
than rounding and sampling explain: a field of forces with a curl fails in one of the directions, whatever friction
dissipates. With the layer, no moment of any number of cycles lies below the allowance and what the layer may lend. The
energy is that at the hand, by quadratures of the wrench along the motion (`port.py`); steps are halved until the error
of sampling is told from the law (`verdict.py`).
"""

from __future__ import annotations

from palpate.base.errors import PalpateError
from palpate_lab.verify.fuzz import FaultError
from palpate_lab.verify.fuzz.loops import files
from palpate_lab.verify.fuzz.loops.device import Device
from palpate_lab.verify.fuzz.loops.kinds import Loop, loops
from palpate_lab.verify.fuzz.loops.verdict import Verdict, judge


def case(seed: int, kind: str = "") -> dict[str, int]:
    """Judge the loops of a seed; the counts of loops by kind.

    Args:
        seed: seed of the scene and its ways.
        kind: name of a function of `kinds.KINDS`; drawn when left out.

    Raises:
        FaultError: a loop hands out energy; its details are those of the worst.
    """
    counts: dict[str, int] = {}
    devices: dict[int, Device] = {}
    failed: list[tuple[int, Loop, Verdict]] = []
    for k, loop in enumerate(loops(seed, kind)):
        try:
            verdict = judge(loop, _device(loop, devices))
        except PalpateError:
            counts["refused"] = counts.get("refused", 0) + 1
            continue
        run = (2 if loop.run in ("still", "moving", "soft") else 1) * loop.cycles  # slow loops run both ways
        for name, n in (("loops", run), (loop.kind, run), (f"{loop.kind}: failed", verdict.fails),
                        (f"{loop.kind}: failed in every cycle", verdict.recurs),
                        (f"{loop.kind}: returned what lay ready", verdict.returns and not verdict.fails)):  # fmt: skip
            if n:
                counts[name] = counts.get(name, 0) + int(n)
        if verdict.fails:
            failed.append((k, loop, verdict))
    if failed:
        k, loop, verdict = max(failed, key=lambda one: one[2].excess)
        details = {
            "kind": loop.kind,
            "drawn": kind,
            "run": loop.run,
            "loop": k,
            "work_J": verdict.work,
            "bound_J": verdict.bound,
            "stored_J": verdict.stored,
            "resolved": verdict.resolved,
            "later_J": verdict.later,
            "ready_J": verdict.ready,
        }
        raise FaultError(f"{loop.kind}, {loop.run}, loop {k}: {verdict.words()}", counts, details)
    return counts


def _device(loop: Loop, devices: dict[int, Device]) -> Device | None:
    """The device of a loop, made once for each scene; None for runs that make their own."""
    if loop.run in ("moving", "session"):
        return None
    if id(loop.scene) not in devices:
        like = next(iter(devices.values()), None)
        devices[id(loop.scene)] = Device(loop.scene, files.folder(), like)
    return devices[id(loop.scene)]
