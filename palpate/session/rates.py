"""Rate, lateness and age of every loop and source of a run, measured while it runs or read from its record."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from palpate.record.snapshots import RATE, Track
from palpate.record.ticks import Ticks, Timing
from palpate.scene.live_targets import PERIOD
from palpate.session.samples import Samples
from palpate.session.session import Session
from palpate.session.snapshots import soft_objects


@dataclass(frozen=True)
class Rate:
    """The rate of one loop or source; None for what is unknown."""

    name: str
    asked_Hz: float | None
    measured_Hz: float | None
    lateness_p50_us: float | None = None  # start of a cycle after its deadline
    lateness_p99_us: float | None = None
    missed: int | None = None  # deadlines missed by a whole period
    age_s: float | None = None  # age of the newest value; in a record the largest age


def cells(rate: Rate) -> tuple[str, str, str, str, str]:
    """The row as text: name, measured and asked rate, lateness, missed ticks, age."""
    of = f" of {rate.asked_Hz:g}" if rate.asked_Hz else ""
    return (
        rate.name,
        "-" if rate.measured_Hz is None else f"{rate.measured_Hz:.1f}{of} Hz",
        "-" if rate.lateness_p99_us is None else f"{rate.lateness_p99_us:.0f} us",
        "-" if rate.missed is None else f"{rate.missed}",
        "-" if rate.age_s is None or not np.isfinite(rate.age_s) else f"{1e3 * rate.age_s:.1f} ms",
    )


class LiveRates:
    """The rates of running sessions, measured between two calls of `rows`.

    Args:
        sessions: sessions by the name of their pair; the empty name for a single one.
    """

    def __init__(self, sessions: Mapping[str, Session]) -> None:
        self._sessions = dict(sessions)
        self._before: dict[str, tuple[float, float]] = {}  # time of the clock and value of the count at the last call
        self._cameras: dict[int, int] = {}  # session whose row shows a camera
        self._fresh: dict[str, tuple[float, float]] = {}  # newest value and the time of the clock when it was new

    def rows(self) -> list[Rate]:
        """One row for each haptic loop, soft object, tracked frame and sensor, and for the endoscope."""
        return [row for name, session in self._sessions.items() for row in self._of(name, session)]

    def _of(self, name: str, session: Session) -> list[Rate]:
        tick, timing = session.latest(), session.timing
        label = f"{name} haptic loop".strip()
        late = timing.get("lateness_us", {})
        loop = Rate(
            label,
            session.rate,
            self._measured(label, float(tick["t"]) * session.rate),
            late.get("p50"),
            late.get("p99"),
            int(timing.get("missed_ticks", 0)),
            self._age(label, float(tick["t"])),
        )
        rows = [loop]
        t = float(tick["t"])
        for k, soft in soft_objects(session.rig).items():
            key = f"{name} soft {soft}".strip()  # the body steps in the loop; its surface reaches others in snapshots
            rows.append(Rate(key, session.rate, loop.measured_Hz, age_s=self._surface_age(key, session, k)))
        gates = session.tracking.gates if session.tracking is not None else {}
        for child, gate in gates.items():
            key = f"{name} frame {child}".strip()
            rows.append(Rate(key, None, self._measured(key, gate.taken), age_s=t - gate.seen_at))
        streams = session.sensing.streams if session.sensing is not None else {}
        for sensed, stream in streams.items():
            key = f"{name} cloud {sensed}".strip()
            used, last = stream.gate.counts.used, stream.gate.last
            rows.append(Rate(key, None, self._measured(key, used), age_s=t - last if used else None))
        return rows + self._camera(session)

    def _camera(self, session: Session) -> list[Rate]:
        """The row of the endoscope arm, which several pairs share."""
        camera = session.camera_arm
        if camera is None or self._cameras.setdefault(id(camera), id(session)) != id(session):
            return []
        rate = self._measured("endoscope", camera.steps)
        return [Rate("endoscope", 1.0 / PERIOD, rate, age_s=self._age("endoscope", camera.steps))]

    def _surface_age(self, key: str, session: Session, index: int) -> float | None:
        """Time since the surface changed, None before it does; a body at rest looks old."""
        shape = float(np.abs(session.soft_vertices(index)).sum())
        return self._age(key, shape) if session.running else None

    def _measured(self, key: str, count: float) -> float | None:
        now = time.monotonic()
        before = self._before.get(key)
        self._before[key] = (now, count)
        return None if before is None or now <= before[0] else (count - before[1]) / (now - before[0])

    def _age(self, key: str, value: float) -> float:
        now = time.monotonic()
        if key not in self._fresh or self._fresh[key][0] != value:
            self._fresh[key] = (value, now)
        return now - self._fresh[key][1]


class Recorded:
    """Accumulates the rates of a recorded run.

    Args:
        frames: number of tracked frames.
    """

    def __init__(self, frames: int = 0) -> None:
        self._count, self._first, self._last, self._longest = 0, 0.0, 0.0, 0.0
        self._late = Samples()
        self._age = np.full(frames, np.nan)  # newest known age of each frame [s]
        self._oldest, self._renewed = np.full(frames, np.nan), np.zeros(frames, int)

    def add(self, ticks: Ticks) -> None:
        """Add further ticks (n,)."""
        t = ticks["t"]
        steps = np.diff(t) if not self._count else np.diff(t, prepend=self._last)
        self._first = self._first if self._count else float(t[0])
        self._longest = max(self._longest, float(steps.max(initial=0.0)))
        self._last, self._count = float(t[-1]), self._count + len(t)
        self._late.add(ticks["lateness_us"])
        for k in range(len(self._age)):
            age = ticks["tracked_age"].reshape(len(ticks), -1)[:, k]
            known = age[np.isfinite(age)]
            if len(known):  # a new pose has arrived whenever the age falls
                self._renewed[k] += int((np.diff(known, prepend=self._age[k]) < 0.0).sum())
                self._age[k], self._oldest[k] = known[-1], np.fmax(self._oldest[k], known.max())

    def rows(self, name: str, rate: float, timing: Timing | None, frames: Sequence[str] = ()) -> list[Rate]:
        """The rates.

        Args:
            name: name of the pair; empty for a single one.
            rate: of the record [Hz].
            timing: of a real-time run; None in lockstep.
            frames: names of the tracked frames, in the scene's order.
        """
        n, span = self._count, self._last - self._first
        late = self._late.values if timing is not None else np.zeros(0)
        p50, p99 = np.percentile(late, [50, 99]).tolist() if len(late) else (None, None)
        missed = None if timing is None else int(timing.get("missed_ticks", 0))
        ran = span + (0 if missed is None else missed / rate)  # time of the clock: missed ticks do not advance t
        longest = self._longest if n > 1 else None
        loop = Rate(f"{name} haptic loop".strip(), rate, (n - 1) / ran if ran > 0 else None, p50, p99, missed, longest)
        found = [loop]
        for child, renewed, oldest in zip(frames, self._renewed.tolist(), self._oldest.tolist(), strict=False):
            measured = renewed / span if span > 0 else None
            age = oldest if np.isfinite(oldest) else None
            found.append(Rate(f"{name} frame {child}".strip(), None, measured, age_s=age))
        return found


def recorded(name: str, ticks: Ticks, rate: float, timing: Timing | None, frames: Sequence[str] = ()) -> list[Rate]:
    """The rates of a recorded run (n,); other arguments as for `Recorded.rows`."""
    found = Recorded(len(frames))
    found.add(ticks)
    return found.rows(name, rate, timing, frames)


def snapshot(name: str, track: Track) -> Rate:
    """The rate of recorded snapshots: the shape of a soft object, or the joints of the endoscope arm."""
    longest = float(np.diff(track.t).max()) if len(track.t) > 1 else None
    return Rate(name, RATE, track.rate or None, age_s=longest)
