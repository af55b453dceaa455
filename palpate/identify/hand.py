"""Mass, damping and stiffness of a hand from a recorded grip, with confidence intervals.

The arm pushes the hand with a broadband force. Along the direction of that force the hand moves as

    F(t) = m x_tt + b x_t + k (x - x_path)

F is the force of the arm on the hand (load cell) and x is the position of the handle. x_path is the position that the
person intends: it drifts and trembles, and through the closed loop it moves x and F alike, so F / x is biased. The
intended motion is independent of the excitation u (position of a moving wall, or a force commanded in open loop), so
cross spectra with u are unbiased:

    S_uF(f) = m S_ux_tt + b S_ux_t + k S_ux        u is an instrumental variable (Ljung 1999, section 7.6)

The fit is linear least squares over the spectral lines f, each weighted by its coherence with u. The confidence
intervals come from leaving out one section of the recording at a time (jackknife): they cover noise, but neither a hand
of another form nor a load cell that lags. Without u, x replaces u and the result carries a warning.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from palpate.arrays import Array
from palpate.errors import RecordingError

Spectra = dict[str, NDArray[np.complex128]]

SEGMENT = 4.0  # length of a spectrum's segments, which overlap by half [s]
BAND = (0.4, 30.0)  # in which a hand is approximately of second order [Hz]
COHERENT = 0.6  # spectral lines of less coherence are left out
LEAST_LINES = 6
LEAST_SEGMENTS = 6
LEAST_MOTION = 5e-5  # least RMS motion of the handle [m]
_GOOD_FIT = 0.85  # fraction of the impedance that the second-order model should explain
_WIDE = 0.2  # relative half width of a confidence interval above which a warning is given
_Z95 = 1.96


@dataclass(frozen=True)
class Grip:
    """A recorded grip along one direction."""

    rate: float
    """Sampling rate [Hz]."""
    x: Array
    """(n,) position of the handle [m]."""
    F: Array
    """(n,) force of the arm on the hand [N]."""
    u: Array | None = None
    """(n,) excitation independent of the hand: position of a wall, or a force; None if not recorded."""
    direction: tuple[float, float, float] | None = None
    """Unit vector in the leader's base; None if the recording does not give it."""
    source: str = ""
    """Path of the recording, for messages."""


@dataclass(frozen=True)
class HandFit:
    """The hand identified from a grip."""

    value: Array
    """(3,) mass [kg], damping [N s/m], stiffness [N/m]."""
    std: Array
    """(3,) standard deviations."""
    f: Array
    """(l,) spectral lines used [Hz]."""
    Z: NDArray[np.complex128]
    """(l,) measured impedance F / x [N/m]."""
    coherence: Array
    """(l,) coherence of each line with the excitation, 0..1."""
    explained: float
    """Fraction of the squared impedance that the second-order model explains."""
    seconds: float
    """Duration of the recording [s]."""
    warnings: tuple[str, ...]

    @property
    def resonance(self) -> float:
        """Natural frequency sqrt(k / m) / 2 pi [Hz]."""
        return float(np.sqrt(self.value[2] / self.value[0]) / (2 * np.pi))

    @property
    def interval(self) -> Array:
        """(3, 2) 95 % confidence intervals of `value`."""
        return np.stack([self.value - _Z95 * self.std, self.value + _Z95 * self.std], axis=1)

    def impedance(self, f: Array) -> NDArray[np.complex128]:
        """Impedance F / x of the fitted hand at frequencies f [Hz], in N/m."""
        m, b, k = self.value
        w = 2 * np.pi * f
        return np.asarray(k - m * w**2 + 1j * w * b)


def fit(grip: Grip) -> HandFit:
    """Identify the hand of a grip.

    Raises:
        RecordingError: the recording is too short or too slow, has too little motion or coherence, has lines on one
            side of the resonance only, or gives a negative parameter. The message names the number and the remedy.
    """
    _check(grip)
    f, parts = _spectra(grip)
    whole = {key: S.sum(axis=0) for key, S in parts.items()}
    used, coherence = _lines(f, whole, grip)
    Z = (whole["uF"] / whole["ux"])[used]
    weight = np.sqrt(coherence / (1.0 - np.minimum(coherence, 0.999))) / np.abs(whole["uF"][used])
    value = _solve({key: S[used] for key, S in whole.items()}, weight)
    _require_hand(value, f[used], grip)
    n = len(parts["ux"])
    blocks = np.array_split(np.arange(n), min(n, 10))
    left_out = []
    for block in blocks:
        rest = {key: (whole[key] - S[block].sum(axis=0))[used] for key, S in parts.items()}
        left_out.append(_solve(rest, weight))
    g = len(blocks)
    std = np.sqrt((g - 1) / g * np.sum((np.array(left_out) - value) ** 2, axis=0))
    bare = HandFit(value, std, f[used], Z, coherence, 0.0, len(grip.x) / grip.rate, ())
    misfit = np.sum(np.abs(Z - bare.impedance(f[used])) ** 2 / np.abs(Z) ** 2) / len(used)
    explained = float(1.0 - misfit)
    return HandFit(value, std, f[used], Z, coherence, explained, bare.seconds, _warn(bare, explained, grip))


def _check(grip: Grip) -> None:
    def refuse(what: str, why: str, mend: str) -> None:
        raise RecordingError(what, where=grip.source, why=why, mend=mend)

    signals = [grip.x, grip.F] + ([] if grip.u is None else [grip.u])
    if any(not np.isfinite(s).all() for s in signals):
        refuse("the recording holds values that are not finite", "", "cut those rows out, or record again")
    if grip.rate < 6.0 * BAND[1]:
        mend = "record at 1000 Hz"
        refuse(f"{grip.rate:g} Hz is too slow for a hand", f"{6 * BAND[1]:g} Hz or more are needed", mend)
    seconds = len(grip.x) / grip.rate
    least = SEGMENT * (LEAST_SEGMENTS + 1) / 2
    if seconds < least:
        refuse(f"{seconds:.1f} s of grip are too short", f"{least:g} s are needed", "hold the handle for 30 s")
    moved = float(np.std(grip.x - np.convolve(grip.x, np.ones(int(grip.rate)) / int(grip.rate), "same")))
    if moved < LEAST_MOTION:
        why = f"{1e3 * moved:.3g} mm rms; {1e3 * LEAST_MOTION:g} mm are needed"
        refuse("the handle hardly moves", why, "push with more force: scenes/grip.yaml does")


def _spectra(grip: Grip) -> tuple[Array, Spectra]:
    """Frequencies (l,) and the cross spectra (segments, l) that the fit needs, by pair."""
    n = round(SEGMENT * grip.rate)
    starts = np.arange(0, len(grip.x) - n + 1, n // 2)
    window, ramp = np.hanning(n), np.linspace(-1, 1, n)
    basis = np.stack([np.ones(n), ramp, ramp**2])
    basis = np.linalg.qr(basis.T)[0]

    def transform(signal: Array) -> NDArray[np.complex128]:
        cut = np.stack([signal[s : s + n] for s in starts])
        return np.asarray(np.fft.rfft(window * (cut - cut @ basis @ basis.T), axis=1))

    v = _derivative(grip.x, grip.rate)
    X, V, A, F = (transform(signal) for signal in (grip.x, v, _derivative(v, grip.rate), grip.F))
    U = X if grip.u is None else transform(grip.u)
    pairs = {"ux": (U, X), "uv": (U, V), "ua": (U, A), "uF": (U, F), "uu": (U, U), "xx": (X, X), "FF": (F, F)}
    f = np.asarray(np.fft.rfftfreq(n, 1.0 / grip.rate), dtype=np.float64)
    return f, {key: np.conj(a) * b for key, (a, b) in pairs.items()}


def _lines(f: Array, S: Spectra, grip: Grip) -> tuple[NDArray[np.intp], Array]:
    """Indices of the lines at which motion and force are coherent with the excitation, and their coherence."""

    def coherence(key: str, a: str) -> Array:
        return np.asarray(np.abs(S[key]) ** 2 / np.maximum((S["uu"] * S[a]).real, 1e-300))

    both = np.minimum(coherence("ux", "xx"), coherence("uF", "FF"))
    power = S["uu"].real
    good = (f >= BAND[0]) & (f <= BAND[1]) & (both >= COHERENT)
    good &= power > 1e-4 * power[(f >= BAND[0]) & (f <= BAND[1])].max()
    used = np.flatnonzero(good)
    if len(used) < LEAST_LINES:
        within = both[(f >= BAND[0]) & (f <= BAND[1])]
        raise RecordingError(
            f"only {len(used)} frequencies are coherent enough",
            where=grip.source,
            why=f"their median coherence with the excitation is {np.median(within):.2f}; {COHERENT:g} is needed",
            mend="push with a broadband force of about 1 N rms, as scenes/grip.yaml does, and hold the handle still",
        )
    return used, both[used]


def _derivative(x: Array, rate: float) -> Array:
    """Central differences of fourth order; below a quarter of the rate they are within 2 % of the derivative."""
    padded = np.concatenate([x[:1], x[:1], x, x[-1:], x[-1:]])
    return np.asarray(rate * (padded[:-4] - 8 * padded[1:-3] + 8 * padded[3:-1] - padded[4:]) / 12)


def _solve(S: Spectra, weight: Array) -> Array:
    """(m, b, k) by weighted least squares of S_uF = m S_ua + b S_uv + k S_ux."""
    A = np.stack([S["ua"], S["uv"], S["ux"]], axis=1) * weight[:, None]
    y = S["uF"] * weight
    return np.asarray(
        np.linalg.lstsq(np.concatenate([A.real, A.imag]), np.concatenate([y.real, y.imag]), rcond=None)[0]
    )


def _require_hand(value: Array, f: Array, grip: Grip) -> None:
    names = ("mass", "damping", "stiffness")
    negative = [f"{name} {x:.3g}" for name, x in zip(names, value, strict=True) if not x > 0.0]
    if negative:
        why = (
            "x or F has the wrong sign"
            if len(negative) > 1
            else "the motion was too small, or the person moved the hand"
        )
        mend = "F is the force of the arm on the hand, with x positive along F; hold still while the arm pushes"
        raise RecordingError(f"no hand has {' and '.join(negative)}", where=grip.source, why=why, mend=mend)
    f0 = float(np.sqrt(value[2] / value[0]) / (2 * np.pi))
    if f.min() > 0.7 * f0 or f.max() < 1.4 * f0:
        side, parameter = ("below", "stiffness") if f.min() > 0.7 * f0 else ("above", "mass")
        raise RecordingError(
            f"the {parameter} cannot be identified",
            where=grip.source,
            why=f"the hand resonates at {f0:.2g} Hz; coherent lines go from {f.min():.2g} to {f.max():.2g} Hz",
            mend=f"excite the hand {side} its resonance, too",
        )


def _warn(found: HandFit, explained: float, grip: Grip) -> tuple[str, ...]:
    warnings = []
    if grip.u is None:
        warnings.append("nothing in the recording says what shook: the hand's own motions bias what is found")
    for name, value, std in zip(("mass", "damping", "stiffness"), found.value, found.std, strict=True):
        if _Z95 * std > _WIDE * value:
            warnings.append(f"{name} is known to +-{100 * _Z95 * std / value:.0f} % only: record longer, push more")
    if explained < _GOOD_FIT:
        warnings.append(
            f"a mass with spring and damper explains {100 * explained:.0f} % only: the grip changed, or it slid"
        )
    return tuple(warnings)


@dataclass(frozen=True)
class Figures:
    """The figures of a fit: the documented contract of ``--json`` (docs/json.md). Intervals are (2,)."""

    mass_kg: float
    damping_N_s_per_m: float
    stiffness_N_per_m: float
    mass_kg_95: Array
    damping_N_s_per_m_95: Array
    stiffness_N_per_m_95: Array
    resonance_Hz: float
    lines: int
    """Number of spectral lines used."""
    band_Hz: tuple[float, float]
    coherence: float
    """Mean coherence of the lines with the excitation, 0..1."""
    explained: float
    direction: tuple[float, float, float] | None
    seconds: float
    warnings: tuple[str, ...]


def figures(grip: Grip, found: HandFit) -> Figures:
    """The figures of a fit."""
    m, b, k = (float(x) for x in found.value)
    return Figures(
        mass_kg=m,
        damping_N_s_per_m=b,
        stiffness_N_per_m=k,
        mass_kg_95=found.interval[0],
        damping_N_s_per_m_95=found.interval[1],
        stiffness_N_per_m_95=found.interval[2],
        resonance_Hz=found.resonance,
        lines=len(found.f),
        band_Hz=(float(found.f.min()), float(found.f.max())),
        coherence=float(found.coherence.mean()),
        explained=found.explained,
        direction=grip.direction or None,
        seconds=found.seconds,
        warnings=found.warnings,
    )


if not TYPE_CHECKING:

    def __getattr__(name: str) -> object:
        from palpate.renamed import missing_name

        raise missing_name(__name__, name)
