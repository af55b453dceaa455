"""Positions, velocities, accelerations and torques of a moving recording, filtered without delay."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import signal

from palpate.arm.identify.recordings import Moving
from palpate.base.arrays import Array
from palpate.base.errors import RecordingError

EDGE = 0.5  # discarded at either end, where the filters have not settled [s]
_STATE_BAND = 10.0  # cutoff for positions and velocities: above the motion, below the encoder noise [Hz]
_SHORTEST = 5.0  # shortest usable recording [s]


@dataclass(frozen=True)
class RecordedMotion:
    """A motion in the coordinates of its recording, sampled evenly; repeated samples are interpolated."""

    q: Array  # (k, m) [rad, m]
    v: Array  # (k, m) [rad/s, m/s]
    a: Array  # (k, m) [rad/s^2, m/s^2]
    tau: Array  # (k, m) as recorded [N m, N]
    rate: float  # [Hz]
    repeated: int  # number of rows that repeated the row before them
    file: str

    def __len__(self) -> int:
        return len(self.q)

    @property
    def kept(self) -> slice:
        """Rows without the discarded ends."""
        edge = round(EDGE * self.rate)
        return slice(edge, len(self.q) - edge)


def motion(recording: Moving) -> RecordedMotion:
    """Filter positions and velocities without phase lag, and differentiate the velocities.

    Recorded velocities come from the timing of encoder edges, so their differences are less noisy than second
    differences of positions. A row that repeats the positions of the row before is a late sample: it is interpolated.

    Raises:
        RecordingError: the recording is too short, or the arm does not move in it.
    """
    repeated = np.zeros(len(recording), dtype=bool)
    repeated[1:] = (np.diff(recording.q, axis=0) == 0.0).all(axis=1)
    seconds = (~repeated).sum() / recording.rate
    if seconds < _SHORTEST:
        why = f"{len(recording)} rows, {repeated.sum()} of them repeated, at {recording.rate:g} Hz"
        raise RecordingError(
            f"{seconds:.2g} s of motion are too short", where=recording.file, why=why,
            mend=f"record at least {_SHORTEST:g} s, better 30 s; a constant recording moves nothing",
        )  # fmt: skip
    row = np.arange(len(recording))
    q, v, tau = (
        np.column_stack([np.interp(row, row[~repeated], x[~repeated, j]) for j in range(x.shape[1])])
        for x in (recording.q, recording.v, recording.tau)
    )
    q, v = lowpass(q, _STATE_BAND, recording.rate), lowpass(v, _STATE_BAND, recording.rate)
    a = np.gradient(v, 1.0 / recording.rate, axis=0)
    return RecordedMotion(q, v, a, tau, recording.rate, int(repeated.sum()), recording.file)


def lowpass(x: Array, cutoff: float, rate: float) -> Array:
    """Fourth-order Butterworth along the first axis, forwards and backwards (no phase lag). cutoff: -6 dB [Hz]."""
    sections = signal.butter(4, cutoff, fs=rate, output="sos")
    return np.asarray(signal.sosfiltfilt(sections, x, axis=0))
