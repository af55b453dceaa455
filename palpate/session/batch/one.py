"""One run of a batch: set up with shared surfaces, simulated in batches of ticks, and reduced to its results."""

from __future__ import annotations

import difflib
import threading
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np
import numpy.typing as npt

from palpate.base.errors import PalpateError
from palpate.record.ticks import SIGNALS, Ticks, as_ticks
from palpate.scene.rig import Rig, build
from palpate.scene.surface import Bodies
from palpate.session.batch.result import KEYS, Outcome
from palpate.session.batch.variation import Variation
from palpate.session.session import BATCH
from palpate.session.summary import Totals


class StoppedError(Exception):
    """Another run failed, or the user interrupted the batch."""


@dataclass(frozen=True)
class BatchOptions:
    """Options that hold for every run."""

    duration: float | None
    """Simulated time [s]; None: the scene's duration."""
    signals: tuple[str, ...]
    signal_rate: float
    """Samples per simulated time [Hz]."""

    def times(self, runs: Sequence[Variation]) -> npt.NDArray[np.float64]:
        """Times of the samples (k,) [s]; empty if no signal is requested.

        Raises:
            PalpateError: a signal is unknown, or the runs differ in duration.
        """
        for name in self.signals:
            if name not in SIGNALS:
                near = difflib.get_close_matches(name, SIGNALS, n=1)
                raise PalpateError(f"there is no signal {name!r}", mend=f"did you mean {near[0]!r}?" if near else "")
        if not self.signals:
            return np.zeros(0)
        durations = {self.duration} if self.duration is not None else {one.resolved().duration for one in runs}
        if len(durations) > 1:
            raise PalpateError("signals of runs of different duration do not fit into one array", mend="give duration")
        return np.arange(max(1, round(durations.pop() * self.signal_rate))) / self.signal_rate


class SharedSurfaces:
    """Surfaces shared by the runs, each made once. One thread at a time sets up a run."""

    def __init__(self) -> None:
        self._bodies: Bodies = {}
        self._lock = threading.Lock()

    def rig(self, variation: Variation, duration: float | None) -> Rig:
        """The rig of a run; its automatic path is planned only as far as the run goes.

        Raises:
            SceneError, MeshError: the scene cannot run.
        """
        with self._lock:
            scene = variation.resolved()
            return build(scene, self._bodies, until=scene.duration if duration is None else duration)


def simulate_one(
    shared: SharedSurfaces, index: int, variation: Variation, options: BatchOptions, stop: threading.Event | None = None
) -> Outcome:
    """Simulate run number ``index``.

    Raises:
        PalpateError: the run cannot be set up; the message names the run. StoppedError: ``stop`` was set.
    """
    try:
        rig = shared.rig(variation, options.duration)
        sim = rig.simulation(variation.seed)
    except PalpateError as error:
        named = type(error)(
            f"run {index} ({variation}): {error.what}", where=error.where, why=error.why, mend=error.mend
        )
        raise named from None
    rate = rig.scene.rates.haptic
    n = max(1, round((rig.scene.duration if options.duration is None else options.duration) * rate))
    totals, samples, batch = Totals(rate), _Samples(options, rate, n), max(1, round(BATCH * rate))
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
    """The requested signals, sampled at `signal_rate`."""

    def __init__(self, options: BatchOptions, rate: float, n: int) -> None:
        count = max(1, round(n / rate * options.signal_rate))
        self._rows = np.minimum(np.rint(np.arange(count) * (rate / options.signal_rate)).astype(np.int64), n - 1)
        shapes = {name: (count, SIGNALS[name].size) if SIGNALS[name].size > 1 else (count,) for name in options.signals}
        self.kept = {name: np.empty(shape) for name, shape in shapes.items()}

    def take(self, ticks: Ticks, first: int) -> None:
        """Store the samples among ``ticks``; ``first`` is the number of the first tick."""
        begin, end = np.searchsorted(self._rows, (first, first + len(ticks)))
        for name, values in self.kept.items():
            values[begin:end] = ticks[name][self._rows[begin:end] - first]
