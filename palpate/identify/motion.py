"""From a moving recording to positions, velocities, accelerations and torques that belong together."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import signal

from palpate.arrays import Array
from palpate.errors import RecordingError
from palpate.identify.recordings import Moving

EDGE = 0.5  # of either end, where filters have seen too little [s]
_STATE_BAND = 10.0  # of the states: far above the motion, below encoder noise [Hz]
_SHORTEST = 5.0  # [s]


@dataclass(frozen=True)
class Motion:
    """Drive coordinates, evenly sampled, without delay; repeated samples have been replaced."""

    q: Array  # (k, m) [rad, m]
    v: Array  # (k, m)
    a: Array  # (k, m)
    tau: Array  # (k, m) as recorded [N m, N]
    rate: float  # [Hz]
    repeated: int  # rows that only repeated their predecessor
    file: str

    def __len__(self) -> int:
        return len(self.q)

    @property
    def kept(self) -> slice:
        """Rows away from both ends."""
        edge = round(EDGE * self.rate)
        return slice(edge, len(self.q) - edge)


def motion(recording: Moving) -> Motion:
    """Positions and velocities are filtered forwards and backwards, velocities differentiated: no phase, no delay.

    Recorded velocities are from the encoders' own timing, and their differences quieter than second differences of
    positions. A row that repeats the positions before it is a sample that came late: it is interpolated.

    Raises:
        RecordingError: the recording is too short, or nothing moves in it.
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
    return Motion(q, v, a, tau, recording.rate, int(repeated.sum()), recording.file)


def lowpass(x: Array, cutoff: float, rate: float) -> Array:
    """Fourth-order Butterworth along the first axis, forwards and backwards: no phase. cutoff: -6 dB [Hz]."""
    sections = signal.butter(4, cutoff, fs=rate, output="sos")
    return np.asarray(signal.sosfiltfilt(sections, x, axis=0))
