"""Noise whose neighbouring samples are alike: its covariance from the residual of a fit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.base.arrays import Array

_REWEIGHTS = 4  # of the octaves of the residual's spectrum


@dataclass(frozen=True)
class Noise:
    """Noise of rows as a sum of spectra, by its circulant embedding of twice the length."""

    n: int
    spectrum: Array  # at the frequencies of rfft over 2 n rows

    def times(self, x: Array) -> Array:
        """The covariance (n, n) times x (n, k)."""
        X = np.fft.rfft(x, 2 * self.n, axis=0)
        return np.asarray(np.fft.irfft(X * self.spectrum[:, None], 2 * self.n, axis=0)[: self.n])

    def periodogram(self, Q: Array) -> Array:
        """Expected periodogram of a residual from which the columns of Q (n, p) were fitted."""
        n = self.n
        lags = np.fft.irfft(self.spectrum, 2 * n)[:n] * (1.0 - np.arange(n) / n)
        whole = 2.0 * np.fft.rfft(lags).real - lags[0]
        V = self.times(Q)
        A, B = np.fft.rfft(Q, axis=0), np.fft.rfft(V, axis=0)
        taken = 2.0 * (A * B.conj()).real.sum(axis=1) - ((A @ (Q.T @ V)) * A.conj()).real.sum(axis=1)
        return np.asarray(np.maximum(whole - taken / n, 1e-12 * lags[0]))

    @staticmethod
    def of(e: Array, Q: Array) -> Noise:
        """The shares of white, 1/f and 1/f^2 noise that explain the periodogram of a residual e (n,) in octaves."""
        from scipy.optimize import nnls

        n = len(e)
        f = np.maximum(np.arange(n + 1), 0.5) / (2.0 * n)
        kinds = [Noise(n, f**-slope / np.mean(f**-slope)) for slope in (0.0, 1.0, 2.0)]
        measured = np.square(np.abs(np.fft.rfft(e))) / n
        octave = np.floor(np.log2(np.maximum(np.arange(len(measured)), 1))).astype(int)
        count = np.bincount(octave)

        def banded(p: Array) -> Array:
            return np.asarray(np.bincount(octave, p) / count)

        E, power = np.array([banded(kind.periodogram(Q)) for kind in kinds]), banded(measured)
        total, share = power, np.zeros(len(kinds))
        for _ in range(_REWEIGHTS):
            w = np.sqrt(count) / np.maximum(total, 1e-300)
            share = nnls((E * w).T, power * w)[0]
            total = share @ E
        return Noise(n, np.asarray(share @ [kind.spectrum for kind in kinds]))


def over_white(r: Array) -> float:
    """Rms of a residual (n,) over that of white noise with the same differences from row to row."""
    white = float(np.sqrt(np.mean(np.square(np.diff(r, 2))) / 6.0))
    return float(np.sqrt(np.mean(np.square(r)))) / max(white, 1e-300)
