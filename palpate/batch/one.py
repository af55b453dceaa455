"""One run of many: set up from what the runs share, simulated in batches of ticks, reduced while it goes."""

from __future__ import annotations

import difflib
import threading
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np
import numpy.typing as npt

from palpate.batch.result import KEYS, Outcome
from palpate.batch.variation import Variation
from palpate.errors import PalpateError
from palpate.record.ticks import SIGNALS, Ticks, as_ticks
from palpate.scene.rig import Rig, build
from palpate.scene.surface import Bodies
from palpate.session.session import BATCH
from palpate.session.summary import Totals


class StoppedError(Exception):
    """Another run has failed, or the user has interrupted all."""


@dataclass(frozen=True)
class Asked:
    """What is wanted of every run."""

    duration: float | None
    """Of simulated time [s]; the scene's when None."""
    signals: tuple[str, ...]
    signal_rate: float
    """Samples per simulated second [Hz]."""

    def times(self, runs: Sequence[Variation]) -> npt.NDArray[np.float64]:
        """Times of the samples (k,) [s]; empty when no signal is asked for.

        Raises:
            PalpateError: an unknown signal, or runs of different duration.
        """
        for name in self.signals:
            if name not in SIGNALS:
                near = difflib.get_close_matches(name, SIGNALS, n=1)
                raise PalpateError(f"there is no signal {name!r}", mend=f"did you mean {near[0]!r}?" if near else "")
        if not self.signals:
            return np.zeros(0)
        durations = {self.duration} if self.duration is not None else {one.resolved().duration for one in runs}
        if len(durations) > 1:
            raise PalpateError("signals of runs that last differently long make no array", mend="give duration")
        return np.arange(max(1, round(durations.pop() * self.signal_rate))) / self.signal_rate


class World:
    """What runs share: the surfaces of their objects, each made once. Setting a run up is one thread's at a time."""

    def __init__(self) -> None:
        self._bodies: Bodies = {}
        self._lock = threading.Lock()

    def rig(self, variation: Variation, duration: float | None) -> Rig:
        """The run set up, its path no longer than it needs.

        Raises:
            SceneError, MeshError: it cannot run.
        """
        with self._lock:
            scene = variation.resolved()
            return build(scene, self._bodies, until=scene.duration if duration is None else duration)


def outcome(
    world: World, index: int, variation: Variation, asked: Asked, stop: threading.Event | None = None
) -> Outcome:
    """Run number ``index``.

    Raises:
        PalpateError: it cannot run; the message names it. StoppedError: ``stop`` was set.
    """
    try:
        rig = world.rig(variation, asked.duration)
        sim = rig.simulation(variation.seed)
    except PalpateError as error:
        told = type(error)(
            f"run {index} ({variation}): {error.what}", where=error.where, why=error.why, mend=error.mend
        )
        raise told from None
    rate = rig.scene.rates.haptic
    n = max(1, round((rig.scene.duration if asked.duration is None else asked.duration) * rate))
    totals, samples, batch = Totals(rate), _Samples(asked, rate, n), max(1, round(BATCH * rate))
    began = time.perf_counter()
    while totals.ticks < n:
        if stop is not None and stop.is_set():
            raise StoppedError
        ticks = as_ticks(sim.run(min(batch, n - totals.ticks)))
        samples.take(ticks, totals.ticks)
        totals.add(ticks)
    factor = n / rate / (time.perf_counter() - began)
    fault = sim.fault()
    summary = asdict(totals.summary(realtime_factor=round(factor, 3)))
    return Outcome({key: summary[key] for key in KEYS}, (fault,) if fault else (), samples.kept)


class _Samples:
    """The signals that are asked for, at their own rate."""

    def __init__(self, asked: Asked, rate: float, n: int) -> None:
        count = max(1, round(n / rate * asked.signal_rate))
        self._rows = np.minimum(np.rint(np.arange(count) * (rate / asked.signal_rate)).astype(np.int64), n - 1)
        shapes = {name: (count, SIGNALS[name].size) if SIGNALS[name].size > 1 else (count,) for name in asked.signals}
        self.kept = {name: np.empty(shape) for name, shape in shapes.items()}

    def take(self, ticks: Ticks, first: int) -> None:
        """Keep the samples among ``ticks``, the first of which has the number ``first``."""
        begin, end = np.searchsorted(self._rows, (first, first + len(ticks)))
        for name, values in self.kept.items():
            values[begin:end] = ticks[name][self._rows[begin:end] - first]
